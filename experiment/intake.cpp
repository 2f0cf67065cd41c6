// Consent, then questions.
#include "experiment/intake.h"

#include <algorithm>
#include <cctype>
#include <random>
#include <string_view>

#include "base/json.h"

namespace equilux {
namespace {

constexpr std::size_t kCodeLength = 6;
// Without 0 and O, 1 and I and L, 2 and Z, 5 and S, 8 and B; without U and vowels no words come out.
constexpr std::string_view kCodeLetters = "CDFGHJKMNPQRTVWXY34679";

IntakeStep find_questions_step(const SessionProtocol& protocol) {
  return protocol.questions.empty() ? IntakeStep::kDone : IntakeStep::kQuestions;
}

bool is_asked(const SessionProtocol& protocol, Question question) {
  return std::any_of(protocol.questions.begin(), protocol.questions.end(),
                     [&](const AskedQuestion& asked) { return asked.question == question; });
}

}  // namespace

std::vector<std::string> enumerate_choices(Question question) {
  switch (question) {
    case Question::kAgeBand:
      return {"under-18", "18-24", "25-34", "35-44", "45-54", "55-64", "65-or-more"};
    case Question::kAcuity:
      return {"normal", "corrected", "reduced"};
    case Question::kColourVision:
      return {"normal", "deficient", "not-known"};
    case Question::kAmbientLight:
      break;
  }
  return {"dark", "dim", "office", "daylight"};
}

Intake make_intake(const SessionProtocol& protocol) {
  return {protocol.consent ? IntakeStep::kConsent : find_questions_step(protocol), {}};
}

void give_consent(Intake& intake, const SessionProtocol& protocol, bool agrees) {
  if (intake.step != IntakeStep::kConsent) return;
  intake.step = agrees ? find_questions_step(protocol) : IntakeStep::kDeclined;
}

void choose_answer(Intake& intake, const SessionProtocol& protocol, Question question,
                   const std::string& answer) {
  if (intake.step != IntakeStep::kQuestions || !is_asked(protocol, question)) return;
  if (answer.empty()) {
    intake.answers.erase(question);
    return;
  }
  const auto choices = enumerate_choices(question);
  if (std::find(choices.begin(), choices.end(), answer) != choices.end()) intake.answers[question] = answer;
}

std::vector<Question> find_unanswered(const Intake& intake, const SessionProtocol& protocol) {
  std::vector<Question> unanswered;
  for (const AskedQuestion& asked : protocol.questions) {
    if (asked.required && !intake.answers.contains(asked.question)) unanswered.push_back(asked.question);
  }
  return unanswered;
}

void submit_answers(Intake& intake, const SessionProtocol& protocol) {
  if (intake.step == IntakeStep::kQuestions && find_unanswered(intake, protocol).empty())
    intake.step = IntakeStep::kDone;
}

std::map<std::string, std::string> find_fields(const Intake& intake, const SessionProtocol& protocol) {
  std::map<std::string, std::string> fields{{"language", protocol.language}};
  if (protocol.consent) {
    fields["consent_version"] = protocol.consent->version;
    // Of the text itself, were it changed under its version.
    fields["consent_digest"] = digest_json(make_json(protocol.consent->text));
  }
  for (const auto& [question, answer] : intake.answers) fields[format_question(question)] = answer;
  return fields;
}

bool has_digit(const std::string& code) {
  return std::any_of(code.begin(), code.end(), [](char c) { return c >= '0' && c <= '9'; });
}

std::string draw_code(const std::vector<std::string>& taken) {
  std::random_device entropy;
  std::uniform_int_distribution<std::size_t> letter(0, kCodeLetters.size() - 1);
  std::string code;
  do {
    code.clear();
    while (code.size() < kCodeLength) code += kCodeLetters[letter(entropy)];
  } while (!has_digit(code) || std::find(taken.begin(), taken.end(), code) != taken.end());
  return code;
}

bool is_same_but_for_case(const std::string& code, const std::string& other) {
  return std::equal(code.begin(), code.end(), other.begin(), other.end(),
                    [](unsigned char a, unsigned char b) { return std::tolower(a) == std::tolower(b); });
}

std::vector<std::string> list_spellings(const std::string& code) {
  std::string small = code, capital = code;
  for (char& c : small) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (char& c : capital) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return {code, small, capital};
}

}  // namespace equilux
