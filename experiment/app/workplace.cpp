// From parameters to a session that can begin.
#include "experiment/app/workplace.h"

#include <fmt/format.h>
#include <utility>

#include "base/error.h"
#include "experiment/app/pictures.h"
#include "experiment/app/screen_facts.h"
#include "experiment/app/viewing.h"
#include "experiment/session_outcome.h"

namespace equilux {
namespace {

Size picture_size(const Manifest& manifest) { return {manifest.width, manifest.height}; }

ScreenRecord make_screen_record(const Workplace& work) {
  ScreenRecord screen;
  screen.monitor = work.facts.monitor;
  screen.framebuffer_width = work.layout.framebuffer.width;
  screen.framebuffer_height = work.layout.framebuffer.height;
  screen.viewing_distance_m = work.setup.viewing_distance_m;
  if (work.setup.degrees) {
    screen.degrees_wide = work.setup.degrees->wide;
    screen.degrees_high = work.setup.degrees->high;
  }
  return screen;
}

SessionRequest make_request(const AppParams& params) {
  SessionRequest request;
  request.experiment = *params.experiment;
  request.participant = params.participant;
  request.lane = params.lane;
  request.kind = params.planted_seed ? SubjectKind::kPlanted : SubjectKind::kPerson;
  request.seed = params.planted_seed ? *params.planted_seed : draw_seed();
  return request;
}

// Of earlier sittings, and that this one goes on.
std::map<std::string, int> count_notes(const std::vector<EventRow>& events) {
  std::map<std::string, int> notes;
  for (const EventRow& event : events) {
    if (event.kind != "showing" && event.kind != "answer") ++notes[event.kind];
  }
  return notes;
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

Workplace prepare_workplace(const AppParams& params, const Display& display, AppWindow& window) {
  const StudyFolder folder{params.study_folder};
  load_folder_study(folder);
  Manifest manifest = load_manifest(folder.manifest());
  const Size wanted = choose_window_size(params, display);
  if (params.windowed && window.framebuffer() != wanted) window.resize(wanted);
  const Layout layout = make_layout(window.framebuffer(), picture_size(manifest), *params.experiment);

  SessionRequest request = make_request(params);
  std::optional<TrialLog> log = find_log(folder);
  SessionInputs inputs = load_session_inputs(folder, log ? &*log : nullptr, request);
  check_pictures(folder, manifest, enumerate_session_keys(inputs));
  if (!log && request.kind == SubjectKind::kPerson) check_code(request.participant, folder.root.string());
  if (log) check_not_running(inputs, *log, request);
  check_can_record(folder);
  request.accepts_clock = true;  // is told on the set-up screen
  const auto unfinished = log ? find_unfinished_session(inputs, *log, request) : std::nullopt;
  request.accepts_clock = false;
  const std::string goes_on_with = unfinished
                                       ? describe_unfinished(*unfinished, log->load_trials(unfinished->id),
                                                             log->load_events(unfinished->id))
                                       : "";
  Texts texts = load_texts(inputs.protocol.language, folder.root);
  Workplace work{std::move(inputs),
                 std::move(manifest),
                 std::move(texts),
                 request,
                 layout,
                 read_screen_facts(display, window),
                 {},
                 {},
                 std::move(log)};
  work.goes_on = unfinished.has_value();
  work.goes_on_with = goes_on_with;
  if (work.log) work.clock_lag = find_clock_lag(*work.log);
  set_up(work, {params.diagonal_m, 0, params.viewing_distance_m});
  return work;
}

namespace {

// True in `has_moved` once the window may be elsewhere. errors: InputError; then `work` is as it was.
void use_monitor(Workplace& work, Display& display, AppWindow& window, const std::string& name,
                 bool& has_moved) {
  const Size picture = picture_size(work.manifest);
  display.choose(name);
  make_layout(display.size(), picture, work.inputs.experiment);
  has_moved = true;
  window.move_to(display, choose_window_size(picture, display.size()));
  const Layout layout = make_layout(window.framebuffer(), picture, work.inputs.experiment);
  ScreenFacts facts = read_screen_facts(display, window);
  work.layout = layout;
  work.facts = std::move(facts);
}

}  // namespace

void change_monitor(Workplace& work, Display& display, AppWindow& window, const std::string& name) {
  const std::string before = display.monitor_name();
  bool has_moved = false;
  try {
    use_monitor(work, display, window, name, has_moved);
  } catch (const InputError& error) {
    display.choose(before);
    if (!has_moved) throw;
    try {
      use_monitor(work, display, window, before, has_moved);
    } catch (const InputError& other) {
      throw InputError(fmt::format("{}; back on monitor {}: {}", error.what(), before, other.what()));
    }
    throw;
  }
  set_up(work, {0, 0, work.setup_input.viewing_distance_m});
}

std::string describe_clock(const Workplace& work) {
  if (!work.clock_lag) return {};
  const auto& limit = work.inputs.protocol.resume_within_hours;
  std::string text = describe_clock_lag(*work.clock_lag);
  if (work.goes_on && limit)
    text += fmt::format(" The protocol lets this session go on within {} hours: continue only if it is so.",
                        *limit);
  return text;
}

void set_up(Workplace& work, const SetupInput& input) {
  const Study& study = work.inputs.study;
  const ViewingTarget target{{study.target_degrees_wide, study.target_degrees_high},
                             study.viewing_distance_m};
  work.setup_input = input;
  work.setup = find_setup(input, work.facts, target, picture_size(work.manifest));
}

Seat take_seat(Workplace& work, const std::map<std::string, std::string>& fields) {
  work.request.screen = make_screen_record(work);
  work.request.fields = find_screen_fields(work.setup, work.facts);
  work.request.fields.insert(fields.begin(), fields.end());
  work.request.fields["prompt"] = work.texts.at("prompt_" + format_experiment(work.inputs.experiment));
  TrialLog log = work.log ? std::move(*work.log) : make_log(work.inputs);
  work.log.reset();
  OpenSession open = open_session(work.inputs, log, work.request);
  const auto notes = count_notes(log.load_events(open.row.id));
  return {std::move(log), std::move(open), notes};
}

}  // namespace equilux
