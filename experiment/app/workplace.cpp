// From parameters to a session that can begin.
#include "experiment/app/workplace.h"

#include "base/error.h"
#include "experiment/app/pictures.h"
#include "experiment/app/viewing.h"
#include "experiment/schedule.h"

namespace equilux {
namespace {

Size picture_size(const Manifest& manifest) { return {manifest.width, manifest.height}; }

std::optional<Degrees> find_achieved(const AppParams& params, const Display& display, const Study& study,
                                     Size picture) {
  const auto pitch = find_pixel_pitch(display.size(), params.diagonal_m, display.reported_mm());
  if (!pitch) return std::nullopt;
  return find_degrees(picture, *pitch, study.viewing_distance_m);
}

ScreenRecord make_screen_record(const Display& display, const Layout& layout, const Study& study,
                                const std::optional<Degrees>& achieved) {
  ScreenRecord screen;
  screen.monitor = display.monitor_name();
  screen.framebuffer_width = layout.framebuffer.width;
  screen.framebuffer_height = layout.framebuffer.height;
  screen.viewing_distance_m = study.viewing_distance_m;
  if (achieved) {
    screen.degrees_wide = achieved->wide;
    screen.degrees_high = achieved->high;
  }
  return screen;
}

}  // namespace

bool is_complete(const AppParams& params) {
  return !params.study_folder.empty() && params.experiment && !params.participant.empty();
}

Size choose_window_size(const AppParams& params, const Display& display) {
  const StudyFolder folder{params.study_folder};
  load_folder_study(folder);
  const Size picture = picture_size(load_manifest(folder.manifest()));
  make_layout(display.size(), picture, *params.experiment);
  return choose_window_size(picture, display.size());
}

Workplace open_workplace(const AppParams& params, const Display& display, AppWindow& window) {
  const StudyFolder folder{params.study_folder};
  Study study = load_folder_study(folder);
  Manifest manifest = load_manifest(folder.manifest());
  const Size wanted = choose_window_size(params, display);
  if (params.windowed && window.framebuffer() != wanted) window.resize(wanted);
  const Layout layout = make_layout(window.framebuffer(), picture_size(manifest), *params.experiment);
  const auto achieved = find_achieved(params, display, study, picture_size(manifest));

  SessionRequest request;
  request.experiment = *params.experiment;
  request.participant = params.participant;
  request.seed = draw_seed();
  request.screen = make_screen_record(display, layout, study, achieved);
  std::optional<TrialLog> found = find_log(folder);
  const SessionInputs inputs = load_session_inputs(folder, found ? &*found : nullptr, request);
  check_pictures(folder, manifest, enumerate_showable(study, inputs.experiment, inputs.cells));
  TrialLog log = found ? std::move(*found) : TrialLog(folder.responses(), true);
  OpenSession open = open_session(inputs, log, request);

  std::vector<std::string> remarks;
  const std::string deviation = describe_deviation(
      achieved, {study.target_degrees_wide, study.target_degrees_high}, study.viewing_distance_m);
  if (!deviation.empty()) remarks.push_back(deviation);
  return {folder,          std::move(study), std::move(manifest), std::move(log),
          std::move(open), layout,           std::move(remarks)};
}

}  // namespace equilux
