// The session on the screen: events from the window in, effects of the state machine carried out in order.
#pragma once

#include <optional>

#include "experiment/app/gui.h"
#include "experiment/app/input.h"
#include "experiment/app/pictures.h"
#include "experiment/app/workplace.h"

namespace equilux {

class SessionWindow {
 public:
  SessionWindow(AppWindow& window, Gui& gui, Workplace& work);

  /// Until the last screen is left or the window is closed. errors: StoreError, InputError; then nothing more
  /// is shown and the log holds all that was answered.
  void run();

 private:
  /// A trial whose pictures are in the graphics card.
  struct LoadedTrial {
    int number = 0;
    TrialPictures pictures;
  };

  void take(const SessionEvent& event);
  void carry_out(const SessionEffect& effect);
  void show(int trial);
  void load_ahead(int trial);
  void read_input();
  void ignore_early_input();
  void draw();
  void draw_trial();
  void draw_page();
  bool draw_last_page();
  bool is_over() const;

  AppWindow* window_;
  Gui* gui_;
  Workplace* work_;
  SubjectInput input_;
  std::optional<LoadedTrial> shown_;
  std::optional<LoadedTrial> next_;
  bool is_left_ = false;
};

/// A page that says what went wrong and what to do; until it is left.
void show_stop(AppWindow& window, Gui& gui, const std::string& message);

}  // namespace equilux
