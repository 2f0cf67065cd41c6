// Trials to summaries, summaries to marks.
#include "analysis/subjects.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <span>

#include "analysis/order_draws.h"
#include "base/below.h"
#include "base/error.h"
#include "base/random_run.h"

namespace equilux {
namespace {

constexpr std::size_t kExactFlips = 16;  ///< subjects up to whom all sign flips are tried

std::optional<double> find_median(std::vector<double> values) {
  if (values.empty()) return std::nullopt;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return (*middle + *std::max_element(values.begin(), middle)) / 2;
}

std::vector<std::uint8_t> find_combos(const std::vector<const BriefTrial*>& main) {
  std::vector<std::uint8_t> combos;
  combos.reserve(main.size());
  for (const BriefTrial* trial : main) {
    if (!trial->view) return {};
    combos.push_back(static_cast<std::uint8_t>(2 * *trial->view + (trial->test_side == Side::kRight ? 1 : 0) +
                                               (trial->answer ? 0 : kUnansweredCombo)));
  }
  return combos;
}

bool is_correct(const BriefTrial& trial) { return trial.answer == trial.test_side; }

void add_main_trials(SessionSummary& summary, const std::vector<const BriefTrial*>& main) {
  std::vector<double> first, second;
  for (std::size_t i = 0; i < main.size(); ++i) {
    const BriefTrial& trial = *main[i];
    if (!trial.answer) continue;
    const bool is_first = 2 * i < main.size();
    Count& half = is_first ? summary.first_half : summary.second_half;
    ++half.n;
    half.k += is_correct(trial) ? 1 : 0;
    summary.left += *trial.answer == Side::kLeft ? 1 : 0;
    summary.too_fast += trial.too_fast ? 1 : 0;
    (is_first ? first : second).push_back(static_cast<double>(trial.response_time_ns) * 1e-9);
  }
  summary.scheduled = std::ssize(main);
  summary.answered = summary.first_half.n + summary.second_half.n;
  summary.first_half_s = find_median(first);
  summary.second_half_s = find_median(second);
  first.insert(first.end(), second.begin(), second.end());
  summary.median_response_s = find_median(std::move(first));
}

// Median and 1.4826 times the median absolute deviation, which is never less than a coin's over as many
// cells.
struct RobustScale {
  double median = 0;
  double deviation = 0;
};

std::optional<RobustScale> find_scale(const std::vector<double>& values, std::size_t cells) {
  const auto median = find_median(values);
  if (!median) return std::nullopt;
  std::vector<double> distances;
  for (const double value : values) distances.push_back(std::abs(value - *median));
  const double least = 0.5 / std::sqrt(static_cast<double>(cells));
  return RobustScale{*median, std::max(1.4826 * *find_median(distances), least)};
}

bool is_inattentive(const SessionSummary& summary) {
  if (summary.catch_pass) return summary.caught.k < *summary.catch_pass;
  return summary.caught.n >= 4 && !is_flagged(summary.caught);
}

std::vector<SubjectMark> find_marks(const SubjectFinding& finding, const std::optional<RobustScale>& scale) {
  std::vector<SubjectMark> marks;
  const SessionSummary& summary = finding.summary;
  if (!summary.complete) return marks;
  if (finding.p_side && *finding.p_side <= kSideBiasLevel) marks.push_back(SubjectMark::kSideBias);
  if (summary.median_response_s && *summary.median_response_s < kFastMedian)
    marks.push_back(SubjectMark::kFast);
  if (is_inattentive(summary)) marks.push_back(SubjectMark::kCatch);
  if (finding.agreement && scale && *finding.agreement < scale->median - 3 * scale->deviation) {
    marks.push_back(SubjectMark::kDisagrees);
  }
  return marks;
}

// Second half less first half; empty where one of them has no answers.
std::optional<double> find_difference(const SessionSummary& summary) {
  const Count &first = summary.first_half, &second = summary.second_half;
  if (!summary.complete || first.n == 0 || second.n == 0) return std::nullopt;
  return static_cast<double>(second.k) / static_cast<double>(second.n) -
         static_cast<double>(first.k) / static_cast<double>(first.n);
}

double sum_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

// One for each person: the mean over sessions of one code. A session without a code is a person's own.
std::vector<double> find_differences(const std::vector<SessionSummary>& summaries) {
  std::map<std::string, std::vector<double>> by_code;
  std::vector<double> differences;
  for (const SessionSummary& summary : summaries) {
    const auto difference = find_difference(summary);
    if (!difference) continue;
    (summary.participant.empty() ? differences : by_code[summary.participant]).push_back(*difference);
  }
  for (const auto& [code, values] : by_code)
    differences.push_back(sum_of(values) / static_cast<double>(values.size()));
  std::sort(differences.begin(), differences.end());
  return differences;
}

double sum_flipped(std::span<const double> values, std::uint64_t signs) {
  double sum = 0;
  for (std::size_t i = 0; i < values.size(); ++i) sum += (signs >> i & 1) != 0 ? values[i] : -values[i];
  return sum;
}

// Share of sign flips whose sum is as far from zero; rounding of equal sums must not decide.
double find_flip_p(const std::vector<double>& values, std::uint64_t seed) {
  const double seen = std::abs(sum_of(values)) - 1e-12;
  if (values.size() <= kExactFlips) {
    const std::uint64_t all = std::uint64_t{1} << values.size();
    std::uint64_t far = 0;
    for (std::uint64_t signs = 0; signs < all; ++signs)
      far += std::abs(sum_flipped(values, signs)) >= seen ? 1 : 0;
    return static_cast<double>(far) / static_cast<double>(all);
  }
  RandomRun random(seed, kOrderFlipStream, 0);
  int far = 1;
  for (int draw = 0; draw < kOrderDraws; ++draw) {
    double sum = 0;
    for (std::size_t first = 0; first < values.size(); first += 64)
      sum += sum_flipped(std::span(values).subspan(first, std::min<std::size_t>(64, values.size() - first)),
                         random.next_u64());
    far += std::abs(sum) >= seen ? 1 : 0;
  }
  return static_cast<double>(far) / (kOrderDraws + 1);
}

Interval find_mean_interval(const std::vector<double>& values, std::uint64_t seed) {
  RandomRun random(seed, kOrderBootstrapStream, 0);
  const Below below(values.size());
  std::vector<double> means(kOrderDraws);
  for (double& mean : means) {
    for (std::size_t i = 0; i < values.size(); ++i) mean += values[below(random)];
    mean /= static_cast<double>(values.size());
  }
  std::sort(means.begin(), means.end());
  const auto tail = static_cast<std::size_t>(find_bootstrap_tail(values.size()) * kOrderDraws);
  return {means[tail], means[means.size() - 1 - tail]};
}

std::optional<double> find_speed_ratio(const std::vector<SessionSummary>& summaries) {
  double sum = 0;
  int count = 0;
  for (const SessionSummary& summary : summaries) {
    if (!summary.complete || !summary.first_half_s || !summary.second_half_s) continue;
    sum += std::log(*summary.second_half_s / *summary.first_half_s);
    ++count;
  }
  if (count == 0) return std::nullopt;
  return std::exp(sum / count);
}

}  // namespace

SessionSummary summarise_session(const SessionRow& session, const std::vector<BriefTrial>& trials) {
  SessionSummary summary;
  summary.session = session.id;
  summary.participant = session.participant;
  summary.uuid = session.uuid;
  if (const auto language = session.fields.find("language"); language != session.fields.end())
    summary.language = language->second;
  summary.subject_index = session.subject_index;
  summary.complete = session.complete;
  std::vector<const BriefTrial*> main;
  for (const BriefTrial& trial : trials) {
    const Phase phase = trial.phase;
    if (phase == Phase::kMain) main.push_back(&trial);
    if (phase != Phase::kCatch || !trial.answer) continue;
    ++summary.caught.n;
    summary.caught.k += is_correct(trial) ? 1 : 0;
  }
  std::sort(main.begin(), main.end(), [](const auto* a, const auto* b) { return a->number < b->number; });
  add_main_trials(summary, main);
  summary.combos = find_combos(main);
  return summary;
}

std::vector<std::optional<double>> find_agreement(const ResponseMatrix& matrix) {
  const std::vector<Count> all = count_weighted(matrix, std::vector<std::uint32_t>(matrix.subjects(), 1));
  std::vector<std::optional<double>> agreement(matrix.subjects());
  for (std::size_t s = 0; s < matrix.subjects(); ++s) {
    std::int64_t agreed = 0, cells = 0;
    for (std::size_t c = 0; c < all.size(); ++c) {
      const std::size_t at = s * all.size() + c;
      const std::int64_t right = 2 * (all[c].k - matrix.correct[at]), others = all[c].n - matrix.asked[at];
      if (!matrix.asked[at] || right == others) continue;
      ++cells;
      agreed += (right > others) == (matrix.correct[at] != 0) ? 1 : 0;
    }
    if (cells > 0) agreement[s] = static_cast<double>(agreed) / static_cast<double>(cells);
  }
  return agreement;
}

std::vector<SubjectFinding> find_subjects(const std::vector<SessionSummary>& summaries,
                                          const ResponseMatrix& matrix) {
  const auto agreement = find_agreement(matrix);
  std::map<std::int64_t, std::optional<double>> by_session;
  std::vector<double> known;
  for (std::size_t s = 0; s < matrix.subjects(); ++s) {
    by_session[matrix.sessions[s]] = agreement[s];
    if (agreement[s]) known.push_back(*agreement[s]);
  }
  const auto scale = find_scale(known, matrix.cells.size());
  std::vector<SubjectFinding> findings;
  for (const SessionSummary& summary : summaries) {
    SubjectFinding finding{summary, eval_p_two_sided({summary.left, summary.answered}), {}, {}};
    if (const auto found = by_session.find(summary.session); summary.complete && found != by_session.end())
      finding.agreement = found->second;
    finding.marks = find_marks(finding, scale);
    findings.push_back(std::move(finding));
  }
  return findings;
}

OrderEffect find_order_effect(const std::vector<SessionSummary>& summaries, std::uint64_t seed) {
  const std::vector<double> differences = find_differences(summaries);
  OrderEffect effect;
  effect.subjects = differences.size();
  effect.speed = find_speed_ratio(summaries);
  if (differences.empty()) return effect;
  effect.correct = sum_of(differences) / static_cast<double>(differences.size());
  if (differences.size() < 2) return effect;
  effect.interval = find_mean_interval(differences, seed);
  effect.p = find_flip_p(differences, seed);
  return effect;
}

std::string format_mark(SubjectMark mark) {
  switch (mark) {
    case SubjectMark::kSideBias:
      return "side";
    case SubjectMark::kFast:
      return "fast";
    case SubjectMark::kCatch:
      return "catch";
    case SubjectMark::kDisagrees:
      break;
  }
  return "disagrees";
}

std::string format_marks(const std::vector<SubjectMark>& marks) {
  std::vector<std::string> names;
  for (const SubjectMark mark : marks) names.push_back(format_mark(mark));
  return fmt::format("{}", fmt::join(names, " "));
}

}  // namespace equilux
