// Dear ImGui, set up for plain pages of text and forms on the neutral grey.
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "experiment/app/glyphs.h"
#include "experiment/app/window.h"

struct ImFont;

namespace equilux {

/// Of a page of text the arrow keys scroll too, while no control has the keyboard's frame; of a form they
/// move between its controls.
enum class PageKind { kText, kForm };

/// How far the page that is on the screen is scrolled. units: pixels
struct PageScroll {
  PageKind kind = PageKind::kForm;
  float at = 0;
  float most = 0;    ///< 0: all of it is on the screen
  float height = 0;  ///< of what is on the screen
};

/// One for each window. Writes no settings file.
class Gui {
 public:
  /// `text_scale` enlarges all text; 1 is 22 pixels.
  explicit Gui(AppWindow& window, float text_scale = 1);
  ~Gui();
  Gui(const Gui&) = delete;
  Gui& operator=(const Gui&) = delete;

  /// Makes the fonts anew where these texts need more characters. Between frames. errors: as check_glyphs
  void use_texts(const std::vector<ShownText>& texts);

  /// What the user did, for the controls of the next frames.
  void take(const std::vector<InputEvent>& events);
  /// The same while no control is on the screen: only releases count, so that no key stays down for ever.
  void skip(const std::vector<InputEvent>& events);
  /// True while events are left for a further frame: a key that goes down and up between two frames needs
  /// two.
  bool has_events() const { return !events_.empty(); }

  /// Takes the keyboard out of a text field, whose text may then be set from outside.
  void leave_field();

  /// Whether the keyboard's frame is around the control that was laid out last.
  bool has_frame() const;

  /// What was laid out; by this the keys of the next frames scroll.
  void note_scroll(const PageScroll& scroll) { scroll_ = scroll; }
  const PageScroll& scroll() const { return scroll_; }
  /// Where the keys since the last call scroll the page to; empty: nowhere.
  std::optional<float> take_scroll_target() { return std::exchange(scroll_target_, std::nullopt); }

  void begin_frame();
  /// Draws what was laid out since begin_frame over the back buffer.
  void end_frame();

  float text_scale() const { return text_scale_; }
  ImFont* text_font() const { return text_font_; }
  ImFont* title_font() const { return title_font_; }

 private:
  void load_fonts(const std::vector<ShownText>& texts);
  void forward(const InputEvent& event);
  bool scroll_by_key(const InputEvent& event);
  std::optional<float> find_scroll_target(Key key) const;

  AppWindow* window_;
  float text_scale_ = 1;
  std::vector<unsigned short> glyph_ranges_;
  std::string font_name_;
  std::deque<InputEvent> events_;
  PageScroll scroll_;
  std::optional<float> scroll_target_;
  ImFont* text_font_ = nullptr;
  ImFont* title_font_ = nullptr;
};

}  // namespace equilux
