// How each session went: side, speed, catch trials, agreement with the rest, order. Reported, never dropped.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/probability.h"
#include "analysis/response_matrix.h"

namespace equilux {

inline constexpr std::size_t kComboCount = 4;  ///< of view and side of the test picture

/// A session in numbers, finished or not. Counts are of trials of the main phase that were answered.
struct SessionSummary {
  std::int64_t session = 0;  ///< AnswerRow::session
  std::string participant;   ///< code
  std::string uuid;          ///< of the session in any log; empty where it is not known
  std::string folder;        ///< study folder of its log; empty where there is only one
  std::string language;      ///< of the texts; empty where it was not recorded
  std::int64_t subject_index = 0;
  bool complete = false;
  std::int64_t scheduled = 0;
  std::int64_t answered = 0;
  std::int64_t left = 0;      ///< answers that were the left side
  Count first_half;           ///< correct of the first half in order of showing
  Count second_half;          ///< correct of the rest
  std::int64_t too_fast = 0;  ///< answers in less than the protocol's least time
  Count caught;               ///< catch trials: correct of those answered; 0 of 0 where the log has none
  std::optional<std::int64_t>
      catch_pass;  ///< right catch trials that its protocol asks for; empty: not known
  std::optional<std::string> abort_reason;  ///< of a session that was ended early; empty: it was not
  std::optional<double> median_response_s;  ///< from onset to press
  std::optional<double> first_half_s;       ///< median of the first half
  std::optional<double> second_half_s;      ///< median of the rest
  /// Combo of the test picture of each main trial, in order of trial, as the session's answers are, with
  /// kUnansweredCombo added where there is no answer; empty where a view is not known.
  std::vector<std::uint8_t> combos;
};

/// A combo is view (high bit) and side (low bit: right) of a picture: 0 to 3.
inline constexpr std::uint8_t kUnansweredCombo = 4;

SessionSummary summarise_session(const SessionRow& session, const std::vector<BriefTrial>& trials);

/// Why a reader should look at a session twice. It counts all the same.
enum class SubjectMark {
  kSideBias,   ///< left and right differ: two-sided exact binomial p <= kSideBiasLevel
  kFast,       ///< median response below kFastMedian
  kCatch,      ///< fewer right than its protocol asks for; where that is not known, more than a quarter of at
               ///< least four wrong
  kDisagrees,  ///< agreement more than three robust deviations below the median; one is at least 0.5 /
               ///< sqrt(cells)
};

inline constexpr double kSideBiasLevel = 0.001;
inline constexpr double kFastMedian = 0.3;  ///< units: s

struct SubjectFinding {
  SessionSummary summary;
  std::optional<double> p_side;     ///< empty without answers
  std::optional<double> agreement;  ///< share of cells where it was right iff most others were; ties left out
  std::vector<SubjectMark> marks;
};

/// One for each summary, in its order; only finished sessions are marked.
std::vector<SubjectFinding> find_subjects(const std::vector<SessionSummary>& summaries,
                                          const ResponseMatrix& matrix);

/// Second half less first half, over persons with a finished session; of one with several their mean.
struct OrderEffect {
  std::size_t subjects = 0;
  std::optional<double> correct;     ///< mean difference of proportions correct
  std::optional<Interval> interval;  ///< of it, by bootstrap over subjects
  std::optional<double> p;           ///< sign flips of subjects' differences: exact up to 16, else by draws
  std::optional<double> speed;       ///< geometric mean of median response times, second by first half
};

OrderEffect find_order_effect(const std::vector<SessionSummary>& summaries, std::uint64_t seed);

/// Agreement of each subject of a matrix. shape: one for each of its sessions; empty where no cell has a
/// majority of others.
std::vector<std::optional<double>> find_agreement(const ResponseMatrix& matrix);

std::string format_mark(SubjectMark mark);
/// "side fast"
std::string format_marks(const std::vector<SubjectMark>& marks);

}  // namespace equilux
