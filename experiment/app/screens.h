// What each screen says and asks; what follows from it is decided elsewhere.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "experiment/app/app.h"
#include "experiment/app/gui.h"
#include "experiment/app/layout.h"
#include "experiment/app/setup.h"
#include "experiment/intake.h"
#include "experiment/session.h"
#include "experiment/texts.h"

namespace equilux {

/// What is typed on the start screen.
struct StartForm {
  std::array<char, 1024> folder{};
  std::array<char, 65> participant{};
  int experiment = -1;      ///< 0 artifact, 1 material, -1 not chosen
  std::string error;        ///< why it could not start; shown until the next try
  bool takes_focus = true;  ///< the next frame puts the keyboard into the first empty field
};

StartForm make_start_form(const AppParams& params);

/// The parameters with what was typed. errors: InputError naming the first field that is empty.
AppParams read_start_form(const StartForm& form, const AppParams& params);

/// What is typed as the study folder, without blanks around it.
std::string read_folder(const StartForm& form);
void set_participant(StartForm& form, const std::string& code);
void set_experiment(StartForm& form, Experiment experiment);

/// True when the button was pressed.
bool draw_start(const Gui& gui, Size framebuffer, StartForm& form);

/// What is typed and moved on the set-up screen.
struct SetupForm {
  std::array<char, 16> diagonal_inches{};
  std::array<char, 16> distance_cm{};
  int card_px = 0;  ///< 0: no card was held to the screen
};

SetupForm make_setup_form(double diagonal_m, double distance_m);

/// Numbers that cannot be read, or are not sizes, count as not given.
SetupInput read_setup_form(const SetupForm& form);

/// What the set-up screen shows beside the form.
struct SetupView {
  const ScreenFacts* facts = nullptr;
  const ViewingSetup* setup = nullptr;
  Size least_framebuffer;
  std::string participant;
  std::string experiment;
};

/// True when the button was pressed.
bool draw_setup(const Gui& gui, Size framebuffer, const SetupView& view, SetupForm& form);

/// The choice, once a button was pressed.
std::optional<bool> draw_consent(const Gui& gui, Size framebuffer, const Texts& texts,
                                 const Consent& consent);

/// True when the button was pressed. Choices go into `intake`.
bool draw_questions(const Gui& gui, Size framebuffer, const Texts& texts, const SessionProtocol& protocol,
                    Intake& intake, bool is_reminded);

struct InstructionsText {
  Experiment experiment = Experiment::kArtifact;
  int trial_count = 0;               ///< of the main part
  int answered = 0;                  ///< before an interruption
  std::vector<std::string> remarks;  ///< for the experimenter
};

/// True when the button was pressed.
bool draw_instructions(const Gui& gui, Size framebuffer, const Texts& texts, const InstructionsText& text);

/// A thin line that is as full as the session is; it moves only from pair to pair.
void draw_progress(const Layout& layout, const TrialProgress& progress);

/// A page of a title, paragraphs and one button; true when it was pressed.
bool draw_message(const Gui& gui, Size framebuffer, const std::string& title,
                  const std::vector<std::string>& paragraphs, const std::string& button);

/// What the experimenter does with a paused session.
enum class PauseChoice { kNone, kGoOn, kEnd };

struct PauseForm {
  std::array<char, 256> reason{};
};

std::string read_reason(const PauseForm& form);

/// Why a paused session cannot go on in this framebuffer, and what to do; `way_on`: if the window is closed.
std::string describe_misfit(Size framebuffer, Size wanted, const std::string& way_on);

struct PauseView {
  TrialProgress progress;
  Size wanted;         ///< the framebuffer for which the pictures were laid out; in another none can go on
  std::string way_on;  ///< in words, if the window is closed
};

PauseChoice draw_pause(const Gui& gui, Size framebuffer, const PauseView& view, PauseForm& form);

}  // namespace equilux
