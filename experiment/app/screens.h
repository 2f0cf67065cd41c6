// What each screen says and asks; what follows from it is decided elsewhere.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "experiment/app/app.h"
#include "experiment/app/gui.h"
#include "experiment/app/layout.h"

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

/// True when the button was pressed.
bool draw_start(const Gui& gui, Size framebuffer, StartForm& form);

struct InstructionsText {
  Experiment experiment = Experiment::kArtifact;
  int trial_count = 0;
  int answered = 0;                  ///< before an interruption
  std::vector<std::string> remarks;  ///< for the experimenter
};

/// True when the button was pressed.
bool draw_instructions(const Gui& gui, Size framebuffer, const InstructionsText& text);

/// The question at its place among the pictures.
void draw_question(const Gui& gui, const Layout& layout, Experiment experiment);

/// A page of a title, paragraphs and one button; true when it was pressed.
bool draw_message(const Gui& gui, Size framebuffer, const std::string& title,
                  const std::vector<std::string>& paragraphs, const std::string& button);

}  // namespace equilux
