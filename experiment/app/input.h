// From presses and releases to what they mean to a session: pure, so that held keys and early presses can be
// tested without a window.
#pragma once

#include <cstdint>
#include <optional>
#include <set>

#include "experiment/app/layout.h"
#include "experiment/session.h"

namespace equilux {

inline constexpr std::int64_t kPauseHoldNs = 2'000'000'000;  ///< Escape is held this long to pause a session
inline constexpr std::int64_t kPageGuardNs =
    300'000'000;                         ///< a page after an answer takes no press before that
inline constexpr int kAnswerButton = 0;  ///< the left mouse button

/// What the session knows of keys; everything else is for text fields.
enum class Key { kLeft, kRight, kSpace, kEnter, kEscape, kF1, kF2, kF3, kF4, kBackspace, kOther };

enum class InputKind { kKeyPress, kKeyRelease, kKeyRepeat, kMousePress, kMouseRelease, kCharacter, kScroll };

/// One event of the window. `code`, `scancode` and `modifiers` are the window library's own.
struct InputEvent {
  InputKind kind = InputKind::kKeyPress;
  std::int64_t time_ns = 0;  ///< monotonic clock, when the program got it
  Key key = Key::kOther;
  double x = 0;  ///< pointer in framebuffer pixels from the top left; distance when scrolling
  double y = 0;
  int code = 0;  ///< key, mouse button or character
  int scancode = 0;
  int modifiers = 0;
};

/// Reads a subject's input. A press counts only if it comes after the onset of the pair, and if no other
/// answer key or button was down at that moment: a key held from before must be let go first.
class SubjectInput {
 public:
  explicit SubjectInput(const Layout& layout) : layout_(layout) {}

  /// The pair is on the screen since then; after an answer the input is closed again.
  void open(std::int64_t onset_ns);

  /// Another screen is there since then.
  void open_page(std::int64_t time_ns) { page_from_ns_ = time_ns; }

  /// What the event means on that screen; most mean nothing.
  std::optional<SessionEvent> read(const InputEvent& event, Screen screen);

  /// A PauseEvent once Escape has been held long enough; it must then be let go first.
  std::optional<SessionEvent> find_pause(std::int64_t now_ns);

 private:
  enum class Source { kMouse, kLeftKey, kRightKey };

  std::optional<SessionEvent> read_key_press(const InputEvent& event, Screen screen);
  std::optional<SessionEvent> turn(std::int64_t time_ns, Screen screen) const;
  std::optional<SessionEvent> press(Source source, std::optional<Side> side, std::int64_t time_ns);
  void release(const InputEvent& event);

  Layout layout_;
  std::set<Source> down_;
  std::optional<std::int64_t> onset_ns_;  ///< empty while closed
  std::int64_t page_from_ns_ = 0;
  std::optional<std::int64_t> escape_ns_;  ///< since when Escape is down
};

}  // namespace equilux
