// Which presses are answers.
#include "experiment/app/input.h"

namespace equilux {

void HeldKeys::lose_focus(std::int64_t time_ns) {
  if (has_focus_ && time_ns - gained_ns_ >= kRefocusNs) held_.clear();
  held_.insert(down_.begin(), down_.end());
  has_focus_ = false;
}

void HeldKeys::gain_focus(std::int64_t time_ns) {
  has_focus_ = true;
  gained_ns_ = time_ns;
}

InputKind HeldKeys::read(InputKind kind, int code, std::int64_t time_ns) {
  if (kind == InputKind::kKeyRelease) {
    down_.erase(code);
    if (has_focus_) held_.erase(code);
    return kind;
  }
  down_.insert(code);
  const bool is_held = held_.erase(code) > 0 && time_ns - gained_ns_ < kRefocusNs;
  return is_held ? InputKind::kKeyRepeat : kind;
}

void EscapeHold::read(const InputEvent& event) {
  if (event.key != Key::kEscape) return;
  if (event.kind == InputKind::kKeyPress) since_ns_ = event.time_ns;
  if (event.kind == InputKind::kKeyRelease) since_ns_.reset();
}

bool EscapeHold::take(std::int64_t now_ns) {
  if (!since_ns_ || now_ns - *since_ns_ < kPauseHoldNs) return false;
  since_ns_.reset();
  return true;
}

void PageGuard::open(std::int64_t time_ns, std::int64_t guard_ns, bool needs_quiet) {
  from_ns_ = time_ns + guard_ns;
  guard_ns_ = guard_ns;
  needs_quiet_ = needs_quiet;
  stale_ = down_;
  is_last_key_admitted_ = stale_.empty();
}

bool PageGuard::admit(const InputEvent& event) {
  const Source source{event.key, event.code};
  switch (event.kind) {
    case InputKind::kKeyPress:
      return is_last_key_admitted_ = admit_press(event);
    case InputKind::kMousePress:
      return admit_press(event);
    case InputKind::kKeyRepeat:
      return is_last_key_admitted_ = !stale_.contains(source);
    case InputKind::kCharacter:
      return is_last_key_admitted_;
    case InputKind::kScroll:
      return event.time_ns >= from_ns_;
    case InputKind::kKeyRelease:
    case InputKind::kMouseRelease:
      down_.erase(source);
      stale_.erase(source);
      return true;
  }
  return true;
}

bool PageGuard::admit_press(const InputEvent& event) {
  const Source source{event.key, event.code};
  const bool is_new = down_.insert(source).second;
  if (is_new && event.time_ns >= from_ns_) return true;
  stale_.insert(source);
  if (needs_quiet_ && event.time_ns < from_ns_) from_ns_ = event.time_ns + guard_ns_;
  return false;
}

void SubjectInput::open(std::int64_t onset_ns) { onset_ns_ = onset_ns; }

std::optional<SessionEvent> SubjectInput::read(const InputEvent& event, Screen screen) {
  is_admitted_ = guard_.admit(event);
  escape_.read(event);
  switch (event.kind) {
    case InputKind::kKeyPress:
      return read_key_press(event, screen);
    case InputKind::kMousePress:
      if (event.code != kAnswerButton) return std::nullopt;
      if (screen == Screen::kFeedback) {
        down_.insert(Source::kMouse);
        return turn(event.time_ns, screen);
      }
      return press(Source::kMouse, find_side(layout_, event.x, event.y), event.time_ns);
    case InputKind::kKeyRelease:
    case InputKind::kMouseRelease:
      release(event);
      return std::nullopt;
    default:
      return std::nullopt;
  }
}

std::optional<SessionEvent> SubjectInput::find_pause(std::int64_t now_ns) {
  if (!escape_.take(now_ns)) return std::nullopt;
  onset_ns_.reset();
  return PauseEvent{now_ns};
}

// Pages are left by Space or Enter, once they can have been seen.
std::optional<SessionEvent> SubjectInput::turn(std::int64_t time_ns, Screen screen) const {
  if (!is_admitted_) return std::nullopt;
  switch (screen) {
    case Screen::kInstructions:
    case Screen::kFamiliar:
    case Screen::kPractice:
    case Screen::kFeedback:
    case Screen::kMain:
    case Screen::kBreak:
      return ContinueEvent{time_ns};
    default:
      return std::nullopt;
  }
}

std::optional<SessionEvent> SubjectInput::turn_back(std::int64_t time_ns, Screen screen) const {
  if (!is_admitted_ || screen != Screen::kFamiliar) return std::nullopt;
  return BackEvent{time_ns};
}

std::optional<SessionEvent> SubjectInput::read_key_press(const InputEvent& event, Screen screen) {
  switch (event.key) {
    case Key::kLeft:
      return press(Source::kLeftKey, Side::kLeft, event.time_ns);
    case Key::kRight:
      return press(Source::kRightKey, Side::kRight, event.time_ns);
    case Key::kSpace:
    case Key::kEnter:
      return turn(event.time_ns, screen);
    case Key::kBackspace:
      return turn_back(event.time_ns, screen);
    default:
      return std::nullopt;
  }
}

std::optional<SessionEvent> SubjectInput::press(Source source, std::optional<Side> side,
                                                std::int64_t time_ns) {
  const bool is_fresh = down_.empty();
  down_.insert(source);
  if (!is_fresh || !side || !onset_ns_ || time_ns <= *onset_ns_) return std::nullopt;
  onset_ns_.reset();
  return AnswerEvent{*side, time_ns};
}

void SubjectInput::release(const InputEvent& event) {
  if (event.kind == InputKind::kMouseRelease && event.code == kAnswerButton) down_.erase(Source::kMouse);
  if (event.kind != InputKind::kKeyRelease) return;
  if (event.key == Key::kLeft) down_.erase(Source::kLeftKey);
  if (event.key == Key::kRight) down_.erase(Source::kRightKey);
}

}  // namespace equilux
