// Which presses are answers.
#include "experiment/app/input.h"

namespace equilux {

void SubjectInput::open(std::int64_t onset_ns) { onset_ns_ = onset_ns; }

std::optional<SessionEvent> SubjectInput::read(const InputEvent& event, Screen screen) {
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
  if (!escape_ns_ || now_ns - *escape_ns_ < kPauseHoldNs) return std::nullopt;
  escape_ns_.reset();
  onset_ns_.reset();
  return PauseEvent{now_ns};
}

// Pages are left by Space or Enter. Those that come right after an answer wait a moment, so that an answer
// pressed twice does not leave them unseen.
std::optional<SessionEvent> SubjectInput::turn(std::int64_t time_ns, Screen screen) const {
  switch (screen) {
    case Screen::kInstructions:
    case Screen::kFamiliar:
    case Screen::kPractice:
      return ContinueEvent{time_ns};
    case Screen::kFeedback:
    case Screen::kMain:
    case Screen::kBreak:
      if (time_ns - page_from_ns_ < kPageGuardNs) return std::nullopt;
      return ContinueEvent{time_ns};
    default:
      return std::nullopt;
  }
}

std::optional<SessionEvent> SubjectInput::read_key_press(const InputEvent& event, Screen screen) {
  switch (event.key) {
    case Key::kLeft:
      return press(Source::kLeftKey, Side::kLeft, event.time_ns);
    case Key::kRight:
      return press(Source::kRightKey, Side::kRight, event.time_ns);
    case Key::kEscape:
      escape_ns_ = event.time_ns;
      return std::nullopt;
    case Key::kSpace:
    case Key::kEnter:
      return turn(event.time_ns, screen);
    case Key::kBackspace:
      if (screen == Screen::kFamiliar) return BackEvent{event.time_ns};
      return std::nullopt;
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
  if (event.key == Key::kEscape) escape_ns_.reset();
}

}  // namespace equilux
