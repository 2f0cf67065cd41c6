// From presses and releases to what they mean to a session: pure, so that held keys and early presses can be
// tested without a window.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <utility>

#include "experiment/app/layout.h"
#include "experiment/session.h"

namespace equilux {

/// Escape is held this long to pause a session, and to leave the pages before it.
inline constexpr std::int64_t kPauseHoldNs = 2'000'000'000;
inline constexpr std::int64_t kPageGuardNs = 300'000'000;       ///< a page takes no press before that
inline constexpr std::int64_t kConsentGuardNs = 1'000'000'000;  ///< likewise, of the consent text
inline constexpr int kAnswerButton = 0;                         ///< the left mouse button

/// What the session knows of keys; everything else is for text fields.
enum class Key {
  kLeft,
  kRight,
  kSpace,
  kEnter,
  kEscape,
  kF1,
  kF2,
  kF3,
  kF4,
  kF5,
  kBackspace,
  kUp,
  kDown,
  kPageUp,
  kPageDown,
  kHome,
  kEnd,
  kOther
};

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

inline constexpr std::int64_t kRefocusNs =
    1'000'000'000;  ///< a key held over a loss of focus repeats by then

/// Keys that stay down while the window has not the keyboard: the window library reports them as let go, and
/// their next repeat as a press.
class HeldKeys {
 public:
  void lose_focus(std::int64_t time_ns);
  void gain_focus(std::int64_t time_ns);

  /// What a key's event is: a repeat where the key was held over the time without focus. Every event is to be
  /// told, in order.
  InputKind read(InputKind kind, int code, std::int64_t time_ns);

 private:
  bool has_focus_ = true;
  std::int64_t gained_ns_ = 0;
  std::set<int> down_;
  std::set<int> held_;  ///< down when the focus was lost, as far as is known still
};

/// Escape, held until something is left that nobody should leave by accident.
class EscapeHold {
 public:
  /// Every event is to be told, in order.
  void read(const InputEvent& event);
  /// True once when it has been held long enough; it must then be let go first.
  bool take(std::int64_t now_ns);

 private:
  std::optional<std::int64_t> since_ns_;
};

/// Keeps from a page what was begun before anybody can have seen it: presses before the guard time is over,
/// and keys and buttons held from before, until they are pressed anew.
class PageGuard {
 public:
  /// The page is on the screen since then. Where `needs_quiet` a press within the guard time begins it anew,
  /// so that keys pressed again and again without looking never leave the page.
  void open(std::int64_t time_ns, std::int64_t guard_ns = kPageGuardNs, bool needs_quiet = false);

  /// Whether the page may see it. Every event of the window is to be told, in order.
  bool admit(const InputEvent& event);

 private:
  using Source = std::pair<Key, int>;

  bool admit_press(const InputEvent& event);

  std::int64_t from_ns_ = 0;  ///< a press counts from then on
  std::int64_t guard_ns_ = 0;
  bool needs_quiet_ = false;
  bool is_last_key_admitted_ = true;  ///< characters follow their keys
  std::set<Source> down_;
  std::set<Source> stale_;  ///< down since before the page, or pressed too early
};

/// Reads a subject's input. A press counts only if it comes after the onset of the pair, and if no other
/// answer key or button was down at that moment: a key held from before must be let go first.
class SubjectInput {
 public:
  explicit SubjectInput(const Layout& layout) : layout_(layout) {}

  /// The pair is on the screen since then; after an answer the input is closed again.
  void open(std::int64_t onset_ns);

  /// Another page is there since then.
  void open_page(std::int64_t time_ns) { guard_.open(time_ns); }

  /// What the event means on that screen; most mean nothing. Every event is to be told, in order.
  std::optional<SessionEvent> read(const InputEvent& event, Screen screen);

  /// Whether the page might see the event that was read last.
  bool is_admitted() const { return is_admitted_; }

  /// A PauseEvent once Escape has been held long enough; it must then be let go first.
  std::optional<SessionEvent> find_pause(std::int64_t now_ns);

 private:
  enum class Source { kMouse, kLeftKey, kRightKey };

  std::optional<SessionEvent> read_key_press(const InputEvent& event, Screen screen);
  std::optional<SessionEvent> turn(std::int64_t time_ns, Screen screen) const;
  std::optional<SessionEvent> turn_back(std::int64_t time_ns, Screen screen) const;
  std::optional<SessionEvent> press(Source source, std::optional<Side> side, std::int64_t time_ns);
  void release(const InputEvent& event);

  Layout layout_;
  std::set<Source> down_;
  std::optional<std::int64_t> onset_ns_;  ///< empty while closed
  PageGuard guard_;
  bool is_admitted_ = true;
  EscapeHold escape_;
};

}  // namespace equilux
