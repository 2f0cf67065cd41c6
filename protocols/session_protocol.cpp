// From session.json to the course of a session.
#include "protocols/session_protocol.h"

#include <fmt/format.h>

#include "base/error.h"
#include "base/files.h"

namespace equilux {

extern const char kSessionSchema[];

namespace {

std::optional<Consent> read_consent(const Json& json) {
  const Json* consent = json.find("consent");
  if (!consent) return std::nullopt;
  return Consent{consent->at("version").as_string(), consent->at("text").as_strings()};
}

std::vector<AskedQuestion> read_questions(const Json& json) {
  const Json* asked = json.find("questions");
  std::vector<AskedQuestion> questions;
  for (const Question question :
       {Question::kAgeBand, Question::kAcuity, Question::kColourVision, Question::kAmbientLight}) {
    const Json* mode = asked ? asked->find(format_question(question)) : nullptr;
    if (mode) questions.push_back({question, mode->as_string() == "required"});
  }
  return questions;
}

void read_familiarisation(const Json& json, SessionProtocol& protocol) {
  const Json* part = json.find("familiarisation");
  if (!part) return;
  const auto count = [&](const char* member) {
    const Json* value = part->find(member);
    return value ? static_cast<int>(value->as_int()) : 0;
  };
  const Json* objects = part->find("objects");
  protocol.shows_objects = objects && objects->as_bool();
  protocol.examples = count("examples");
  protocol.practice_trials = count("practice_trials");
}

void read_breaks(const Json& json, SessionProtocol& protocol) {
  const Json* breaks = json.find("breaks");
  if (!breaks) return;
  if (const Json* trials = breaks->find("every_trials"))
    protocol.break_every_trials = static_cast<int>(trials->as_int());
  if (const Json* minutes = breaks->find("every_minutes"))
    protocol.break_every_minutes = minutes->as_double();
}

std::optional<CatchTrials> read_catch_trials(const Json& json, const std::string& source) {
  const Json* part = json.find("catch_trials");
  if (!part) return std::nullopt;
  const CatchTrials trials{static_cast<int>(part->at("count").as_int()),
                           static_cast<int>(part->at("pass").as_int())};
  if (trials.pass > trials.count) {
    throw InputError(source, "/catch_trials/pass", fmt::format("at most count, {}", trials.count),
                     fmt::format("{}", trials.pass));
  }
  return trials;
}

void read_resume(const Json& json, SessionProtocol& protocol) {
  const Json* resume = json.find("resume");
  if (!resume) return;
  if (const Json* allowed = resume->find("allowed")) protocol.may_resume = allowed->as_bool();
  if (const Json* hours = resume->find("within_hours")) protocol.resume_within_hours = hours->as_double();
}

// A consent form may get a new version, or be translated, while a study runs.
std::string digest_shared_part(const Json& source) {
  Json shared;
  for (const auto& [member, value] : source.as_object()) {
    if (member != "description" && member != "language" && member != "consent") shared.set(member, value);
  }
  return digest_json(shared);
}

}  // namespace

std::string format_question(Question question) {
  switch (question) {
    case Question::kAgeBand:
      return "age_band";
    case Question::kAcuity:
      return "acuity";
    case Question::kColourVision:
      return "colour_vision";
    case Question::kAmbientLight:
      break;
  }
  return "ambient_light";
}

SessionProtocol load_session_protocol(const std::filesystem::path& path) {
  SessionProtocol protocol;
  if (!path_exists(path)) return protocol;
  protocol.source = load_json(path, kSessionSchema);
  const Json& json = protocol.source;
  protocol.digest = digest_shared_part(json);
  if (const Json* language = json.find("language")) protocol.language = language->as_string();
  protocol.consent = read_consent(json);
  protocol.questions = read_questions(json);
  read_familiarisation(json, protocol);
  read_breaks(json, protocol);
  if (const Json* least = json.find("least_response_ms"))
    protocol.least_response_ms = static_cast<int>(least->as_int());
  protocol.catch_trials = read_catch_trials(json, path.string());
  read_resume(json, protocol);
  return protocol;
}

}  // namespace equilux
