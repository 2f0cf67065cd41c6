// The session on the screen: events from the window in, effects of the state machine carried out in order.
#pragma once

#include <future>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "experiment/app/gui.h"
#include "experiment/app/input.h"
#include "experiment/app/pictures.h"
#include "experiment/app/screens.h"
#include "experiment/app/workplace.h"
#include "experiment/planted.h"

namespace equilux {

/// A planted subject that takes the person's place in front of the window.
struct PlantedPilot {
  Truth truth;
  PlantedSubject subject;
  double pace = 1;  ///< of the planted response times; 0 answers at once
};

/// Whether and how a session that ends here can go on later, by the protocol, which binds persons alone.
std::string describe_way_on(const SessionInputs& inputs);

class SessionWindow {
 public:
  SessionWindow(AppWindow& window, Gui& gui, const Workplace& work, Seat& seat,
                const std::optional<PlantedPilot>& pilot = {});

  /// Until the last screen is left or the window is closed. errors: StoreError, InputError; then nothing more
  /// is shown and the log holds all that was answered.
  void run();

 private:
  /// A trial whose pictures are in the graphics card.
  struct LoadedTrial {
    int number = 0;
    TrialPictures pictures;
  };
  /// A trial whose pictures are being read.
  struct LoadingTrial {
    int number = 0;
    std::future<std::vector<LdrImage>> images;
  };
  /// A page of the familiarisation likewise.
  struct LoadedPage {
    int number = 0;
    FamiliarPictures pictures;
  };

  Session& session() const { return seat_->open.session; }
  void take(const SessionEvent& event);
  void carry_out(const SessionEffect& effect);
  void show(int trial);
  void load_ahead(int trial);
  void finish_loading();
  void upload_ahead();
  void read_input();
  void read_page_key(const InputEvent& event);
  void read_pause_key(const InputEvent& event);
  void note_changes();
  void fly();
  void ignore_early_input();
  void open_new_page();
  void draw();
  void draw_pair(const std::string& line, bool shows_progress);
  void draw_trial();
  void draw_feedback();
  void draw_familiar();
  void draw_page();
  void draw_pause_page();
  bool lay_out_page();
  bool lay_out_message(const std::string& title, const std::vector<std::string>& paragraphs,
                       const std::string& button) const;
  bool lay_out_last_page() const;
  void check_screen() const;
  bool fits() const;
  void pause_unless_it_fits();
  bool is_over() const;

  AppWindow* window_;
  Gui* gui_;
  const Workplace* work_;
  Seat* seat_;
  std::optional<PlantedPilot> pilot_;
  std::optional<std::int64_t> answered_ns_;  ///< while the answer is being taken
  SubjectInput input_;
  std::optional<LoadedTrial> shown_;
  std::optional<LoadedTrial> next_;
  std::optional<LoadingTrial> loading_;
  std::optional<LoadedPage> page_;
  PauseForm pause_;
  bool is_new_page_ = true;
  bool shows_summary_ = false;
  bool is_left_ = false;
};

/// What the experimenter should know of a sitting that is over: answers, catch trials, too fast answers, what
/// happened to the screen. One sentence each.
std::vector<std::string> summarise(const Session& session, const SessionProtocol& protocol,
                                   const std::map<std::string, int>& notes);

}  // namespace equilux
