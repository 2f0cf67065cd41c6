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
bool draw_start(Gui& gui, Size framebuffer, StartForm& form);

/// What is typed and moved on the set-up screen.
struct SetupForm {
  std::array<char, 16> diagonal_inches{};
  std::array<char, 16> distance_cm{};
  int card_px = 0;                  ///< of the bar; 0: none is shown
  bool was_card_matched = false;    ///< the bar was changed: until then it says nothing of this screen
  bool takes_focus = false;         ///< the next frame puts the keyboard into the first field that is wrong
  std::string wanted_monitor = {};  ///< to which everything is to move; empty: stays
  std::string tried_monitor = {};   ///< the last one that was wanted
  std::string error = {};           ///< why it did not
};

/// What is 0 is left to be typed.
SetupForm make_setup_form(double diagonal_m, double viewing_distance_m = 0);

/// What is wrong with what was typed, a sentence for each field; empty where it is right, or nothing.
struct SetupErrors {
  std::string diagonal;
  std::string distance;
};
SetupErrors find_errors(const SetupForm& form);
bool is_right(const SetupForm& form);
/// True where the form is right; else the keyboard goes to what is wrong.
bool leave_setup(SetupForm& form);

/// The monitor after the one that is used, in their order and round; empty where there is no other.
std::string find_next_monitor(const std::vector<std::string>& names, const std::string& used);

/// Another monitor is used from now on: what was measured on the one before holds no longer.
void forget_monitor(SetupForm& form);

/// Shows the bar to which a card is held, or takes it away.
void switch_card(SetupForm& form);

/// Numbers that cannot be read, or are not sizes, count as not given; so does a card to which the bar was not
/// matched.
SetupInput read_setup_form(const SetupForm& form);

/// What the set-up screen shows beside the form.
struct SetupView {
  const ScreenFacts* facts = nullptr;
  const ViewingSetup* setup = nullptr;
  double target_distance_m = 0;
  Size least_framebuffer;
  std::string participant;
  std::string experiment;
  std::string goes_on_with;           ///< empty for a session that begins
  std::string clock;                  ///< what is wrong with the computer's; empty where nothing is
  std::vector<std::string> monitors;  ///< that are connected
};

/// True when the button was pressed and the form is right.
bool draw_setup(Gui& gui, Size framebuffer, const SetupView& view, SetupForm& form);

/// What the consent page knows between frames; the choices are to agree (true) or not.
struct ConsentForm {
  bool is_read = false;         ///< the end of the text has been on the screen
  std::optional<bool> focused;  ///< the choice whose button has the keyboard's frame
  int frames = 0;               ///< in which it was laid out
};

/// What a press comes to: nobody agrees to a text whose end was never on the screen.
std::optional<bool> take_choice(const ConsentForm& form, bool agrees);

/// What a key means: Enter the choice that has the frame, and to agree where none has it; Backspace declines.
std::optional<bool> find_choice(const ConsentForm& form, Key key);

/// The choice, once a button was pressed.
std::optional<bool> draw_consent(Gui& gui, Size framebuffer, const Texts& texts, const Consent& consent,
                                 ConsentForm& form);

/// True when the button was pressed. Choices go into `intake`.
bool draw_questions(Gui& gui, Size framebuffer, const Texts& texts, const SessionProtocol& protocol,
                    Intake& intake, bool is_reminded);

struct InstructionsText {
  Experiment experiment = Experiment::kArtifact;
  int trial_count = 0;               ///< of the main part
  int answered = 0;                  ///< before an interruption
  std::vector<std::string> remarks;  ///< for the experimenter
};

/// True when the button was pressed.
bool draw_instructions(Gui& gui, Size framebuffer, const Texts& texts, const InstructionsText& text);

/// A thin line that is as full as the session is; it moves only from pair to pair.
void draw_progress(const Layout& layout, const TrialProgress& progress);

struct MessageText {
  std::string title;
  std::vector<std::string> paragraphs;
  std::string button;
  std::string read_on;  ///< below a page that is longer than the screen
};

/// A page of a title, paragraphs and one button; true when it was pressed.
bool draw_message(Gui& gui, Size framebuffer, const MessageText& text);

/// What the experimenter does with a paused session.
enum class PauseChoice { kNone, kGoOn, kEnd };

struct PauseForm {
  std::array<char, 256> reason{};
};

std::string read_reason(const PauseForm& form);

/// Why a paused session cannot go on in this framebuffer, and what to do; `way_on`: if the window is closed.
std::string describe_misfit(Size framebuffer, Size wanted, const std::string& way_on);

/// The same where the monitor of that name is gone.
std::string describe_lost_monitor(const std::string& monitor, const std::string& way_on);

struct PauseView {
  TrialProgress progress;
  bool shows_pair_again = true;  ///< it was a pair that was on the screen, and no page
  Size wanted;         ///< the framebuffer for which the pictures were laid out; in another none can go on
  std::string way_on;  ///< in words, if the window is closed
  std::optional<std::string> lost_monitor = {};  ///< the session's, where it is gone: then none can go on
};

/// How far the session is, and what comes when it goes on.
std::string describe_pause(const PauseView& view);

PauseChoice draw_pause(Gui& gui, Size framebuffer, const PauseView& view, PauseForm& form);

}  // namespace equilux
