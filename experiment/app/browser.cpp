// Three screens, the grid, one picture and the results; keys and clicks for all.
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <algorithm>
#include <fmt/format.h>
#include <imgui.h>
#include <memory>
#include <optional>
#include <vector>

#include "base/error.h"
#include "base/files.h"
#include "base/program.h"
#include "experiment/app/app.h"
#include "experiment/app/background_render.h"
#include "experiment/app/folder_view.h"
#include "experiment/app/gui.h"
#include "experiment/app/key_letter.h"
#include "experiment/app/pages.h"
#include "experiment/app/pictures.h"
#include "experiment/app/results_view.h"
#include "experiment/app/texture.h"
#include "experiment/app/window.h"
#include "experiment/browse.h"

namespace equilux {
namespace {

constexpr double kPatienceS = 0.1;
constexpr int kThumbnailWidth = 140;
constexpr int kDifferenceGain = 4;
// The first three at a text scale of 1, with which they grow.
constexpr float kRowLabel = 60, kCountHeight = 20, kCountText = 16, kGap = 6;
constexpr float kUsualScale = 0.8F;  // of a session's text
constexpr Size kLeastWindow{960, 760};

// A place in the grid.
struct Place {
  std::size_t object = 0, count = 0, level = 0;
  int view = 0;
};

class Browser {
 public:
  Browser(const BrowserParams& params, AppWindow& window, Gui& gui)
      : params_(params),
        folder_{params.study_folder},
        window_(window),
        gui_(gui),
        view_(read_folder_view(folder_, kind_)),
        results_(folder_, view_.study) {
    objects_ = enumerate_objects(view_.study);
  }

  void run() {
    while (!window_.is_closing() && !is_left_) {
      draw();
      const bool is_loading = !shows_picture_ && !shows_results_ && load_next_thumbnail();
      window_.wait(is_loading || gui_.has_events() ? 0 : kPatienceS);
      const auto events = window_.take_events();
      gui_.take(events);
      for (const InputEvent& event : events) {
        if (event.kind == InputKind::kKeyPress || event.kind == InputKind::kKeyRepeat)
          press(find_letter(event.code, glfwGetKeyName(event.code, event.scancode)));
      }
      watch_render();
    }
  }

 private:
  struct Thumbnail {
    std::string key;
    std::optional<Texture> texture;  ///< empty: not there
  };

  const Object& object() const { return objects_[place_.object]; }
  std::vector<std::int64_t> counts() const { return list_counts(view_.study, object()); }
  Column column(std::size_t count) const { return {object(), counts()[count]}; }
  Cell cell(std::size_t count, std::size_t level) const {
    return {column(count), view_.study.clamp_levels[level], view_.study.normalise};
  }
  std::string key_of(std::size_t count, std::size_t level) const {
    return format_key(Condition{cell(count, level), place_.view});
  }
  std::string reference_key() const { return format_key(Family{object(), place_.view}); }
  bool has(const std::string& key) const { return view_.manifest && view_.manifest->pictures.contains(key); }

  void forget_pictures() {
    thumbnails_.clear();
    shown_.clear();
  }

  void refresh() {
    try {
      view_ = read_folder_view(folder_, kind_);
      message_.clear();
    } catch (const std::exception& error) {
      message_ = error.what();
    }
    forget_pictures();
  }

  // A picture that is being made anew, or was changed, ends no rendering; nor does a file that cannot be
  // saved.
  void try_to(const std::function<void()>& act) {
    try {
      act();
    } catch (const InputError& error) {
      message_ = error.what();
    } catch (const StoreError& error) {
      message_ = error.what();
    }
  }

  // One of the grid's pictures a frame, so that the window stays quick. False when all are there.
  bool load_next_thumbnail() {
    const std::size_t levels = view_.study.clamp_levels.size(), number = thumbnails_.size();
    if (number == counts().size() * levels) return false;
    const std::string key = key_of(number / levels, number % levels);
    std::optional<Texture> texture;
    try_to([&] {
      if (!has(key)) return;
      const LdrImage image = load_picture(folder_, *view_.manifest, key);
      texture = Texture(make_thumbnail(image, std::max(1, image.width / kThumbnailWidth)));
    });
    thumbnails_.push_back({key, std::move(texture)});
    return true;
  }

  void move(std::size_t& at, int steps, std::size_t count) {
    const auto last = static_cast<int>(count) - 1;
    at = static_cast<std::size_t>(std::clamp(static_cast<int>(at) + steps, 0, last));
    follows_ = 1;
    shown_.clear();
  }

  void choose_object(int steps) {
    move(place_.object, steps, objects_.size());
    place_.count = std::min(place_.count, counts().size() - 1);
    forget_pictures();
  }

  void shift(int steps) {
    if (!view_.windows) {
      message_ =
          fmt::format("{} is not there: equilux-analyze windows makes one", folder_.windows().string());
      return;
    }
    try_to([&] {
      view_.windows = save_shifted_window(folder_, view_.study, column(place_.count), steps);
      message_.clear();
    });
  }

  void begin_render() {
    if (params_.study_file.empty()) {
      message_ = fmt::format(
          "give the study's file, as in `equilux-session browse {} --study protocols/{}.json`, to "
          "render what is missing",
          folder_.root.string(), view_.study.name);
      return;
    }
    try_to([&] { render_.start(params_.study_file, folder_.root); });
  }

  void watch_render() {
    const RenderState before = render_state_;
    try_to([&] { render_state_ = render_.poll(); });  // which may begin one that was waiting
    if (is_active(before) && !is_active(render_state_)) refresh();
  }

  void draw() {
    if (shows_results_) return draw_results();
    return shows_picture_ ? draw_picture() : draw_grid();
  }

  void show_results(bool shows) {
    shows_results_ = shows;
    if (shows) results_.read(kind_);
  }

  void press(int code) {
    if (shows_results_) return press_on_results(code);
    const std::size_t levels = view_.study.clamp_levels.size();
    switch (code) {
      case GLFW_KEY_LEFT:
        return move(place_.count, -1, counts().size());
      case GLFW_KEY_RIGHT:
        return move(place_.count, 1, counts().size());
      case GLFW_KEY_UP:  // no clamp stands at the bottom
        return move(place_.level, 1, levels);
      case GLFW_KEY_DOWN:
        return move(place_.level, -1, levels);
      case GLFW_KEY_PAGE_UP:
        return choose_object(-1);
      case GLFW_KEY_PAGE_DOWN:
        return choose_object(1);
      case GLFW_KEY_V:
        place_.view = 1 - place_.view;
        return forget_pictures();
      case GLFW_KEY_ENTER:
        shows_picture_ = has(key_of(place_.count, place_.level)) && has(reference_key());
        is_flipped_ = shows_difference_ = false;
        return;
      case GLFW_KEY_BACKSPACE:
        is_left_ = is_left_ || !shows_picture_;
        shows_picture_ = false;
        return;
      case GLFW_KEY_SPACE:
        is_flipped_ = !is_flipped_;
        return;
      default:
        return press_letter(code);
    }
  }

  void press_on_results(int code) {
    if (results_.press(code)) return;
    if (code == GLFW_KEY_G || code == GLFW_KEY_BACKSPACE) return show_results(false);
    if (code == GLFW_KEY_K) change_kind();
    if (code == GLFW_KEY_K || code == GLFW_KEY_F5) results_.read(kind_);
    if (code == GLFW_KEY_F5) read_answers();
  }

  void change_kind() {
    kind_ = kind_ == SubjectKind::kPerson ? SubjectKind::kPlanted : SubjectKind::kPerson;
    read_answers();
  }

  // A log that cannot be read ends no rendering.
  void read_answers() {
    try {
      read_coverage(folder_, kind_, view_);
      message_.clear();
    } catch (const std::exception& error) {
      message_ = error.what();
    }
  }

  void press_letter(int code) {
    switch (code) {
      case GLFW_KEY_G:
        return show_results(!shows_picture_);
      case GLFW_KEY_D:
        shows_difference_ = !shows_difference_;
        shown_.clear();
        return;
      case GLFW_KEY_W:
        return shift(1);
      case GLFW_KEY_S:
        return shift(-1);
      case GLFW_KEY_K:
        return change_kind();
      case GLFW_KEY_F5:
        return refresh();
      case GLFW_KEY_R:
        return render_state_ == RenderState::kPaused ? render_.resume() : begin_render();
      case GLFW_KEY_P:
        return render_.pause();
      case GLFW_KEY_C:
        return render_.cancel();
      default:
        return;
    }
  }

  std::string describe_render() const {
    switch (render_state_) {
      case RenderState::kIdle:
        return view_.holding.missing.empty() ? "" : "R renders what is missing.";
      case RenderState::kRunning:
        return "P pauses, C cancels. " + render_.line();
      case RenderState::kPaused:
        return "Paused: R goes on, C cancels. " + render_.line();
      case RenderState::kCancelling:
        return "Cancelling. R renders anew after it.";
      case RenderState::kDone:
        return "Rendered. " + render_.line();
      case RenderState::kCancelled:
        return "Cancelled; what is whole is kept. R goes on.";
      case RenderState::kFailed:
        break;
    }
    return "Rendering failed: " + render_.line();
  }

  std::vector<std::string> list_lines() const {
    const Holding& holding = view_.holding;
    std::vector<std::string> lines{
        fmt::format("{}: {} of {} pictures are there{}. {}", view_.study.name, holding.there,
                    holding.there + static_cast<int>(holding.missing.size()),
                    holding.missing.empty()
                        ? ""
                        : fmt::format("; the first that is missing is {}", holding.missing[0]),
                    describe_render()),
        fmt::format(
            "{} {} {}, v{} (object {} of {}: PageUp, PageDown; view: V). Arrows choose, Enter looks, W and S "
            "move the window (frame), G: graphs and EE, Backspace closes.",
            object().geometry, object().material, format_illumination(object().illumination), place_.view,
            place_.object + 1, objects_.size()),
        fmt::format("Below each picture: answers of {} subjects, right of all, artifact (a) and material "
                    "(m), ! where "
                    "flagged (K: {}; F5 reads anew).",
                    format_kind(kind_), kind_ == SubjectKind::kPerson ? "planted" : "person")};
    if (!message_.empty()) lines.push_back(message_);
    return lines;
  }

  void draw_results() {
    window_.clear();
    gui_.begin_frame();
    results_.draw(window_, gui_);
    gui_.end_frame();
    window_.swap();
  }

  void draw_grid() {
    window_.clear();
    gui_.begin_frame();
    lay_out_grid();
    gui_.end_frame();
    window_.swap();
  }

  void lay_out_grid() {
    const FullPage page(gui_, window_.framebuffer());
    for (const std::string& line : list_lines()) page.say(line);
    lay_out_counts();
    ImGui::BeginChild("cells", ImVec2(0, 0), false, ImGuiWindowFlags_NoBackground | ImGuiWindowFlags_NoNav);
    lay_out_cells();
    ImGui::EndChild();
  }

  float scaled(float pixels) const { return pixels * gui_.text_scale() / kUsualScale; }

  ImVec2 find_cell_size() const {
    const float width = kThumbnailWidth;
    const float share = view_.manifest ? static_cast<float>(view_.manifest->height) /
                                             static_cast<float>(view_.manifest->width)
                                       : 0.75F;
    return {width, std::round(width * share)};
  }

  float find_left(float origin, ImVec2 cell_size, std::size_t count) const {
    return origin + scaled(kRowLabel) + static_cast<float>(count) * (cell_size.x + 2 * kGap);
  }

  // Over the cells, where they stay however far these are scrolled.
  void lay_out_counts() {
    const ImVec2 origin = ImGui::GetCursorScreenPos(), size = find_cell_size();
    ImDrawList* list = ImGui::GetWindowDrawList();
    list->AddText(origin, IM_COL32_BLACK, "VPLs");
    for (std::size_t count = 0; count < counts().size(); ++count) {
      const std::string name = format_vpl_count(counts()[count]);
      list->AddText(ImVec2(find_left(origin.x, size, count), origin.y), IM_COL32_BLACK, name.c_str());
    }
    ImGui::Dummy(ImVec2(0, ImGui::GetTextLineHeight()));
  }

  void lay_out_cells() {
    const ImVec2 origin = ImGui::GetCursorScreenPos(), size = find_cell_size();
    const std::size_t levels = view_.study.clamp_levels.size(), columns = counts().size();
    ImDrawList* list = ImGui::GetWindowDrawList();
    const auto corner_of = [&](std::size_t count, std::size_t level) {
      return ImVec2(
          find_left(origin.x, size, count),
          origin.y + kGap + static_cast<float>(levels - 1 - level) * (size.y + scaled(kCountHeight) + kGap));
    };
    for (std::size_t level = 0; level < levels; ++level) {
      const ImVec2 corner = corner_of(0, level);
      list->AddText(ImVec2(origin.x, corner.y), IM_COL32_BLACK,
                    format_clamp(view_.study.clamp_levels[level]).c_str());
      for (std::size_t count = 0; count < columns; ++count)
        draw_cell(corner_of(count, level), size, count, level);
    }
    const ImVec2 last = corner_of(columns, 0);
    ImGui::Dummy(ImVec2(last.x - origin.x, last.y - origin.y + size.y + scaled(kCountHeight)));
  }

  void draw_cell(ImVec2 corner, ImVec2 size, std::size_t count, std::size_t level) {
    ImDrawList* list = ImGui::GetWindowDrawList();
    const ImVec2 end(corner.x + size.x, corner.y + size.y);
    const std::size_t number = count * view_.study.clamp_levels.size() + level;
    if (number < thumbnails_.size() && thumbnails_[number].texture) {
      list->AddImage(thumbnails_[number].texture->id(), corner, end, ImVec2(0, 1), ImVec2(1, 0));
    } else {
      list->AddRect(corner, end, IM_COL32(90, 90, 90, 255));
      list->AddLine(corner, end, IM_COL32(90, 90, 90, 255));
    }
    if (is_in_window(count, level)) list->AddRect(corner, end, IM_COL32_BLACK, 0, 0, 3);
    if (count == place_.count && level == place_.level)
      list->AddRect(ImVec2(corner.x - 4, corner.y - 4), ImVec2(end.x + 4, end.y + 4), IM_COL32_WHITE, 0, 0,
                    3);
    const Cell here = cell(count, level);
    const std::string text =
        describe_count(view_.artifact, here, "a") + "  " + describe_count(view_.material, here, "m");
    list->AddText(nullptr, scaled(kCountText), ImVec2(corner.x, end.y + 1), IM_COL32_BLACK, text.c_str());
    ImGui::SetCursorScreenPos(corner);
    ImGui::PushID(static_cast<int>(number));
    if (ImGui::InvisibleButton("cell", size)) {
      place_.count = count;
      place_.level = level;
      press(GLFW_KEY_ENTER);
    }
    ImGui::PopID();
    if (follows_ > 0 && count == place_.count && level == place_.level) {
      ImGui::SetScrollHereY();  // to the button above
      --follows_;
    }
  }

  bool is_in_window(std::size_t count, std::size_t level) const {
    if (!view_.windows) return false;
    const int first = view_.windows->by_column.at(column(count)).first_level,
              here = view_.study.clamp_levels[level];
    return here >= first && here < first + kWindowLevels;
  }

  // The test picture, its reference, or their difference, pixel for pixel at one place.
  void draw_picture() {
    const std::string key = key_of(place_.count, place_.level), reference = reference_key();
    if (!has(key) || !has(reference)) {
      shows_picture_ = false;
      return;
    }
    if (shown_.empty()) try_to([&] { load_shown(key, reference); });
    shows_picture_ = shown_.size() == 2;
    if (!shows_picture_) return draw_grid();
    const Size size = window_.framebuffer();
    const int width = view_.manifest->width, height = view_.manifest->height;
    const bool is_reference = is_flipped_ && !shows_difference_;
    window_.clear();
    gui_.begin_frame();
    const std::string what =
        shows_difference_ ? fmt::format("{} minus {}, {} times, on grey", key, reference, kDifferenceGain)
        : is_reference    ? reference
                          : key;
    draw_line(gui_, {0, (size.height - height) / 2 - 60, size.width, 30}, what);
    draw_line(gui_, {0, (size.height + height) / 2 + 20, size.width, 30},
              "Space: the other one   D: difference   Arrows: neighbours   Backspace: back");
    gui_.end_frame();
    shown_[is_reference ? 1 : 0].draw({(size.width - width) / 2, (size.height - height) / 2, width, height},
                                      size);
    window_.swap();
  }

  void load_shown(const std::string& key, const std::string& reference) {
    const LdrImage picture = load_picture(folder_, *view_.manifest, key),
                   other = load_picture(folder_, *view_.manifest, reference);
    shown_.emplace_back(shows_difference_ ? make_difference(picture, other, kDifferenceGain) : picture);
    shown_.emplace_back(other);
  }

  BrowserParams params_;
  StudyFolder folder_;
  AppWindow& window_;
  Gui& gui_;
  SubjectKind kind_ = SubjectKind::kPerson;
  FolderView view_;
  std::vector<Object> objects_;
  Place place_;
  std::vector<Thumbnail>
      thumbnails_;              ///< of this object and view, by column and level, as far as they are loaded
  std::vector<Texture> shown_;  ///< picture or difference, reference; empty: not loaded
  ResultsView results_;
  BackgroundRender render_;
  RenderState render_state_ = RenderState::kIdle;
  std::string message_;
  int follows_ =
      3;  ///< frames in which the chosen cell is scrolled to; at first ImGui does not know its page
  bool shows_picture_ = false, is_flipped_ = false, shows_difference_ = false, shows_results_ = false,
       is_left_ = false;
};

}  // namespace

int run_browser(const BrowserParams& params) {
  const StudyFolder folder{params.study_folder};
  load_folder_study(folder);
  const Display display(params.monitor);
  const Size screen = display.size();
  const auto fit = [](int least, int available) {
    return std::min(std::max(least, available * 9 / 10), available);
  };
  AppWindow window(display, {fit(kLeastWindow.width, screen.width), fit(kLeastWindow.height, screen.height)});
  Gui gui(window, kUsualScale * static_cast<float>(params.text_scale));
  Browser(params, window, gui).run();
  return kExitOk;
}

}  // namespace equilux
