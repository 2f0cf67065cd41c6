// How a person's session goes: session.json, a person's to edit. Without one a session is instructions,
// trials, thanks.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/json.h"

namespace equilux {

/// What a participant agrees to before anything else.
struct Consent {
  std::string version;            ///< recorded with each session
  std::vector<std::string> text;  ///< paragraphs
};

/// Something that is asked before a session and kept as a field of it.
enum class Question { kAgeBand, kAcuity, kColourVision, kAmbientLight };

struct AskedQuestion {
  Question question = Question::kAgeBand;
  bool required = false;
};

struct CatchTrials {
  int count = 0;  ///< trials of a difference that nobody misses, spread over the session
  int pass = 0;   ///< least number of right answers of a subject who attends
};

struct SessionProtocol {
  std::string language = "en";
  std::optional<Consent> consent;
  std::vector<AskedQuestion> questions;
  bool shows_objects = false;  ///< all objects, before the practice
  int examples = 0;            ///< labelled pairs, before the practice
  int practice_trials = 0;     ///< with feedback, in a phase of their own
  std::optional<int> break_every_trials;
  std::optional<double> break_every_minutes;
  int least_response_ms = 0;  ///< faster answers are kept and marked
  std::optional<CatchTrials> catch_trials;
  bool may_resume = true;
  std::optional<double> resume_within_hours;  ///< of the last thing recorded
  Json source;
  std::string digest;  ///< of what sessions must share: all but description, language and consent; empty
                       ///< without a file
};

/// Its name in session.json and in the log: age_band, acuity, colour_vision, ambient_light.
std::string format_question(Question question);

/// The default protocol where there is no such file. errors: InputError
SessionProtocol load_session_protocol(const std::filesystem::path& path);

}  // namespace equilux
