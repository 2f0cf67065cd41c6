// A page: a column of text and controls in the middle of the grey screen.
#pragma once

#include <string>

#include "experiment/app/gui.h"
#include "experiment/app/layout.h"

namespace equilux {

/// What is laid out between its making and its end stands on the page; it scrolls where it does not fit, and
/// says so by `read_on` below it.
class Page {
 public:
  Page(Gui& gui, Size framebuffer, const std::string& title, PageKind kind = PageKind::kForm,
       const std::string& read_on = "");
  ~Page();
  Page(const Page&) = delete;
  Page& operator=(const Page&) = delete;

  void say(const std::string& paragraph) const;
  void say_indented(const std::string& paragraph) const;
  /// True when it was pressed.
  bool press(const std::string& button) const;
  /// A pale panel, for what must not be overlooked.
  void warn(const std::string& text) const;
  void leave_space() const;
  /// Whether all that was laid out until now has its end on the screen.
  bool is_seen() const;

 private:
  Gui* gui_;
  PageKind kind_;
};

/// A control's text in lines of at most this width, in the letters that are in use; ImGui breaks none.
/// units: pixels
std::string break_text(const std::string& text, float width);

/// All of the window but a margin, for lines and what is drawn below them; keys are the caller's.
class FullPage {
 public:
  FullPage(const Gui& gui, Size framebuffer);
  ~FullPage();
  FullPage(const FullPage&) = delete;
  FullPage& operator=(const FullPage&) = delete;

  void say(const std::string& line) const;
};

/// A line in the middle of a rectangle, without a page; where it has no room it breaks, and is drawn smaller
/// than the text scale asks for.
void draw_line(const Gui& gui, const Rectangle& place, const std::string& text);

}  // namespace equilux
