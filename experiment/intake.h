// What comes before a session: consent and questions, as a pure state machine. Nothing of it is recorded
// until the session begins, so that who declines leaves no trace.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "protocols/session_protocol.h"

namespace equilux {

enum class IntakeStep { kConsent, kQuestions, kDone, kDeclined };

struct Intake {
  IntakeStep step = IntakeStep::kDone;
  std::map<Question, std::string> answers;
};

/// Names of the answers to a question, as they are recorded.
std::vector<std::string> enumerate_choices(Question question);

Intake make_intake(const SessionProtocol& protocol);

/// Agrees to take part, or not. Ignored on other steps.
void give_consent(Intake& intake, const SessionProtocol& protocol, bool agrees);

/// Chooses an answer; an empty one takes it back. Ignored unless it is asked and is one of the choices.
void choose_answer(Intake& intake, const SessionProtocol& protocol, Question question,
                   const std::string& answer);

/// Required questions without an answer.
std::vector<Question> find_unanswered(const Intake& intake, const SessionProtocol& protocol);

/// Leaves the questions; stays where a required one has no answer.
void submit_answers(Intake& intake, const SessionProtocol& protocol);

/// Fields of the session that follows: consent_version, language, and an answer to each question that has
/// one.
std::map<std::string, std::string> find_fields(const Intake& intake, const SessionProtocol& protocol);

/// Which no name has.
bool has_digit(const std::string& code);

/// A new participant's code: six letters and digits that are not mistaken for each other, never one of
/// `taken`. From the system's entropy, so that it tells nothing of anybody.
std::string draw_code(const std::vector<std::string>& taken);

/// Codes of one person, or a slip of the keyboard: files named by them would be one on some systems.
bool is_same_but_for_case(const std::string& code, const std::string& other);
/// The code in small and in capital letters. shape: itself first
std::vector<std::string> list_spellings(const std::string& code);

}  // namespace equilux
