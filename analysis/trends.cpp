// Columns to strata, strata to exact tests.
#include "analysis/trends.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>

#include "analysis/permutation.h"
#include "analysis/tables.h"
#include "base/error.h"

namespace equilux {
namespace {

constexpr std::size_t kAbsent = static_cast<std::size_t>(-1);

// Places of findings, level by level; kAbsent where the study lacks the column.
using Places = std::vector<std::size_t>;

struct Question {
  std::string factor, from, to;
  std::vector<Places> strata;
  std::vector<std::size_t> objects;  // a number for each stratum: those of one object at several VPL counts

  void add(const Object& object, Places places) {
    objects.push_back(numbers.try_emplace(object, numbers.size()).first->second);
    strata.push_back(std::move(places));
  }
  std::map<Object, std::size_t> numbers;
};

class Columns {
 public:
  explicit Columns(const std::vector<ColumnFinding>& findings) {
    for (std::size_t i = 0; i < findings.size(); ++i) places_[findings[i].column] = i;
  }
  std::size_t place_of(const Column& column) const {
    const auto found = places_.find(column);
    return found == places_.end() ? kAbsent : found->second;
  }

 private:
  std::map<Column, std::size_t> places_;
};

// A stratum for each column that has the first level; `set` puts another level in its place.
template <typename Level, typename Get, typename Set>
Question ask(const std::vector<ColumnFinding>& findings, const std::string& factor,
             const std::vector<Level>& levels, const std::function<std::string(const Level&)>& name,
             const Get& get, const Set& set) {
  const Columns columns(findings);
  Question question{factor, name(levels.front()), name(levels.back()), {}, {}, {}};
  std::map<Column, Places> strata;
  for (const ColumnFinding& finding : findings) {
    if (std::find(levels.begin(), levels.end(), get(finding.column)) == levels.end()) continue;
    Column key = finding.column;
    set(key, levels.front());
    Places& places = strata[key];
    if (!places.empty()) continue;
    for (const Level& level : levels) {
      Column column = key;
      set(column, level);
      places.push_back(columns.place_of(column));
    }
  }
  for (auto& [key, places] : strata) question.add(key.object, std::move(places));
  return question;
}

std::vector<std::int64_t> find_all_counts(const Study& study) {
  std::vector<std::int64_t> counts;
  for (const Column& column : enumerate_columns(study)) counts.push_back(column.vpl_count);
  std::sort(counts.begin(), counts.end());
  counts.erase(std::unique(counts.begin(), counts.end()), counts.end());
  return counts;
}

void ask_counts(std::vector<Question>& questions, const Study& study,
                const std::vector<ColumnFinding>& findings) {
  const auto counts = find_all_counts(study);
  const auto add = [&](const std::vector<std::int64_t>& levels) {
    questions.push_back(ask<std::int64_t>(
        findings, "vpls", levels, [](const std::int64_t& count) { return format_vpl_count(count); },
        [](const Column& column) { return column.vpl_count; },
        [](Column& column, std::int64_t count) { column.vpl_count = count; }));
  };
  if (counts.size() < 2) return;
  add(counts);
  for (std::size_t i = 1; counts.size() > 2 && i < counts.size(); ++i) add({counts[i - 1], counts[i]});
}

// Of G0, G1, ... their number; the others have no order.
std::optional<int> find_bumpiness(const std::string& geometry) {
  int number = 0;
  const char* const last = geometry.data() + geometry.size();
  if (!geometry.starts_with('G') || geometry.size() < 2) return std::nullopt;
  const auto [end, error] = std::from_chars(geometry.data() + 1, last, number);
  return error == std::errc() && end == last && number >= 0 ? std::optional(number) : std::nullopt;
}

void ask_geometries(std::vector<Question>& questions, const Study& study,
                    const std::vector<ColumnFinding>& findings) {
  std::vector<std::string> geometries = enumerate_geometries(study);
  std::erase_if(geometries, [](const std::string& geometry) { return !find_bumpiness(geometry); });
  std::sort(geometries.begin(), geometries.end(), [](const std::string& a, const std::string& b) {
    return *find_bumpiness(a) < *find_bumpiness(b);
  });
  if (geometries.size() < 2) return;
  questions.push_back(ask<std::string>(
      findings, "geometry", geometries, [](const std::string& text) { return text; },
      [](const Column& column) { return column.object.geometry; },
      [](Column& column, const std::string& text) { column.object.geometry = text; }));
}

void ask_materials(std::vector<Question>& questions, const Study& study,
                   const std::vector<ColumnFinding>& findings) {
  const auto materials = enumerate_materials(study);
  const auto has = [&](const std::string& name) {
    return std::find(materials.begin(), materials.end(), name) != materials.end();
  };
  for (const auto& [from, to] : std::vector<std::pair<std::string, std::string>>{
           {"MS", "MR"}, {"MS", "BS"}, {"BS", "BR"}, {"BS", "GS"}}) {
    if (!has(from) || !has(to)) continue;
    questions.push_back(ask<std::string>(
        findings, "material", {from, to}, [](const std::string& text) { return text; },
        [](const Column& column) { return column.object.material; },
        [](Column& column, const std::string& text) { column.object.material = text; }));
  }
}

void ask_illuminations(std::vector<Question>& questions, const Study& study,
                       const std::vector<ColumnFinding>& findings) {
  if (enumerate_illuminations(study).size() < 2) return;
  questions.push_back(ask<Illumination>(
      findings, "illumination", {Illumination::kIndirect, Illumination::kDirectAndIndirect},
      [](const Illumination& value) { return format_illumination(value); },
      [](const Column& column) { return column.object.illumination; },
      [](Column& column, Illumination value) { column.object.illumination = value; }));
}

// EE of a column. Open: a resample would have kept a column that was dropped, and nobody knows its EE.
enum class Outcome : std::uint8_t { kNone, kExists, kOpen, kUntested };

// What there is of EE in the columns of a stratum, those without a verdict left out.
std::vector<Outcome> find_outcomes(const Places& places,
                                   const std::function<Outcome(std::size_t)>& outcome_of) {
  std::vector<Outcome> outcomes;
  for (const std::size_t place : places) {
    if (place != kAbsent && outcome_of(place) != Outcome::kUntested) outcomes.push_back(outcome_of(place));
  }
  return outcomes;
}

struct Sums {
  std::int64_t gained = 0, lost = 0, pairs = 0;
  std::int64_t least = 0, most = 0;  ///< gained less lost, as open columns turn out
  std::int64_t strata = 0;

  double share_of(std::int64_t sum) const { return static_cast<double>(sum) / static_cast<double>(pairs); }
};

void add_pairs(Sums& sums, const std::vector<Outcome>& outcomes) {
  for (std::size_t j = 1; j < outcomes.size(); ++j) {
    for (std::size_t i = 0; i < j; ++i) {
      ++sums.pairs;
      sums.gained += outcomes[j] == Outcome::kExists && outcomes[i] == Outcome::kNone ? 1 : 0;
      sums.lost += outcomes[j] == Outcome::kNone && outcomes[i] == Outcome::kExists ? 1 : 0;
    }
  }
}

// Of m columns one with EE adds, to gained less lost, the columns before it less those behind it.
void add_bounds(Sums& sums, const std::vector<Outcome>& outcomes) {
  for (std::int64_t i = 0; i < std::ssize(outcomes); ++i) {
    const Outcome outcome = outcomes[static_cast<std::size_t>(i)];
    if (outcome == Outcome::kNone) continue;
    const std::int64_t added = 2 * i - (std::ssize(outcomes) - 1);
    sums.least += outcome == Outcome::kExists ? added : std::min<std::int64_t>(added, 0);
    sums.most += outcome == Outcome::kExists ? added : std::max<std::int64_t>(added, 0);
  }
}

Sums add_up(const Question& question, const std::function<Outcome(std::size_t)>& outcome_of) {
  Sums sums;
  for (const Places& places : question.strata) {
    const std::vector<Outcome> outcomes = find_outcomes(places, outcome_of);
    if (outcomes.size() < 2) continue;
    ++sums.strata;
    add_pairs(sums, outcomes);
    add_bounds(sums, outcomes);
  }
  return sums;
}

// The verdicts of each object at its levels and VPL counts; of those alone that have a pair.
std::vector<Cluster> find_clusters(const Question& question,
                                   const std::function<Outcome(std::size_t)>& outcome_of) {
  const auto verdict_of = [&](std::size_t place) -> std::optional<bool> {
    if (place == kAbsent || outcome_of(place) == Outcome::kUntested) return std::nullopt;
    return outcome_of(place) == Outcome::kExists;
  };
  std::vector<Cluster> clusters(question.numbers.size());
  for (std::size_t i = 0; i < question.strata.size(); ++i) {
    auto& levels = clusters[question.objects[i]].levels;
    const Places& places = question.strata[i];
    levels.resize(places.size());
    for (std::size_t level = 0; level < places.size(); ++level)
      levels[level].push_back(verdict_of(places[level]));
  }
  std::erase_if(clusters, [](const Cluster& cluster) { return !has_pairs(cluster); });
  return clusters;
}

// EE of every resample, and of how many subjects they are. shape: resamples x columns, row by row.
struct Redrawn {
  std::vector<Outcome> outcomes;
  std::size_t subjects = 0;
};

// The least and the greatest effect of each resample, sorted each by itself; equal where nothing is open.
struct Effects {
  std::vector<double> least, most;
};

Effects find_effects(const Question& question, const Redrawn& redrawn, std::size_t columns) {
  Effects effects;
  for (std::size_t row = 0; columns > 0 && row < redrawn.outcomes.size(); row += columns) {
    const Sums sums = add_up(question, [&](std::size_t place) { return redrawn.outcomes[row + place]; });
    if (sums.pairs == 0) continue;
    effects.least.push_back(sums.share_of(sums.least));
    effects.most.push_back(sums.share_of(sums.most));
  }
  std::sort(effects.least.begin(), effects.least.end());
  std::sort(effects.most.begin(), effects.most.end());
  return effects;
}

// The estimate give or take the farther end of the resamples. Chance takes EE from a column more often than
// it gives it, and in a resample once more: effects of resamples lie on one side of the estimate, which is
// itself on that side of the truth.
std::optional<Interval> find_effect_interval(double estimate, const Effects& effects, std::size_t subjects) {
  const std::size_t count = effects.least.size();
  if (count == 0 || subjects < kLeastResampled) return std::nullopt;
  const auto tail = static_cast<std::size_t>(find_bootstrap_tail(subjects) * static_cast<double>(count));
  const double reach = std::max(estimate - effects.least[tail], effects.most[count - 1 - tail] - estimate);
  return Interval{std::max(estimate - reach, -1.0), std::min(estimate + reach, 1.0)};
}

Outcome outcome_of(const ColumnFinding& finding, Rule rule) {
  switch (finding.under(rule).verdict) {
    case Verdict::kExists:
      return Outcome::kExists;
    case Verdict::kNone:
      return Outcome::kNone;
    case Verdict::kUntested:
      break;
  }
  return Outcome::kUntested;
}

// Outcomes of a column's resamples. shape: by Resampled.
using OutcomeTable = std::array<Outcome, 3>;

// A column without a verdict has none in any resample. One without EE of whose material nobody was asked,
// since no level was left, is open where a resample leaves one.
OutcomeTable make_outcome_table(const ColumnFinding& finding, Rule rule) {
  const Verdict verdict = finding.under(rule).verdict;
  if (verdict == Verdict::kUntested) return {Outcome::kUntested, Outcome::kUntested, Outcome::kUntested};
  const bool was_asked = std::any_of(finding.material.begin(), finding.material.end(),
                                     [](const LevelCount& level) { return level.count.n > 0; });
  const bool is_open = verdict == Verdict::kNone && !was_asked;
  return {Outcome::kNone, Outcome::kExists, is_open ? Outcome::kOpen : Outcome::kUntested};
}

// shape: resamples x columns, as `resamples`.
std::vector<Outcome> find_resampled_outcomes(const std::vector<Resampled>& resamples,
                                             const std::vector<ColumnFinding>& findings, Rule rule) {
  std::vector<OutcomeTable> tables;
  for (const ColumnFinding& finding : findings) tables.push_back(make_outcome_table(finding, rule));
  std::vector<Outcome> outcomes;
  outcomes.reserve(resamples.size());
  for (std::size_t i = 0; i < resamples.size(); ++i)
    outcomes.push_back(tables[i % tables.size()][static_cast<std::size_t>(resamples[i])]);
  return outcomes;
}

Trend answer(const Question& question, const std::vector<ColumnFinding>& findings, Rule rule,
             const Redrawn& redrawn) {
  const auto outcome = [&](std::size_t place) { return outcome_of(findings[place], rule); };
  const Sums sums = add_up(question, outcome);
  Trend trend;
  trend.factor = question.factor;
  trend.from = question.from;
  trend.to = question.to;
  trend.strata = sums.strata;
  trend.gained = sums.gained;
  trend.lost = sums.lost;
  trend.pairs = sums.pairs;
  if (sums.pairs == 0) return trend;
  trend.effect = sums.share_of(sums.gained - sums.lost);
  trend.status = sums.gained + sums.lost == 0         ? TrendStatus::kFlat
                 : redrawn.subjects < kLeastResampled ? TrendStatus::kTooFewSubjects
                                                      : TrendStatus::kTested;
  trend.interval =
      find_effect_interval(*trend.effect, find_effects(question, redrawn, findings.size()), redrawn.subjects);
  const std::vector<Cluster> clusters = find_clusters(question, outcome);
  trend.clusters = std::ssize(clusters);
  trend.p = eval_permutation_p(clusters, sums.gained - sums.lost);
  trend.p_least = find_least_p(clusters);
  return trend;
}

}  // namespace

std::vector<double> adjust_holm(const std::vector<double>& p_values) {
  std::vector<std::size_t> order(p_values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return p_values[a] < p_values[b]; });
  std::vector<double> adjusted(p_values.size());
  double largest = 0;
  for (std::size_t rank = 0; rank < order.size(); ++rank) {
    largest = std::max(largest, p_values[order[rank]] * static_cast<double>(order.size() - rank));
    adjusted[order[rank]] = std::min(largest, 1.0);
  }
  return adjusted;
}

std::vector<Trend> find_trends(const Study& study, const std::vector<ColumnFinding>& findings, Rule rule,
                               const Uncertainty& uncertainty) {
  std::vector<Question> questions;
  ask_counts(questions, study, findings);
  ask_geometries(questions, study, findings);
  ask_materials(questions, study, findings);
  ask_illuminations(questions, study, findings);
  const Redrawn redrawn{
      find_resampled_outcomes(uncertainty.resamples[static_cast<std::size_t>(rule)], findings, rule),
      uncertainty.subjects};
  std::vector<Trend> trends;
  for (const Question& question : questions) trends.push_back(answer(question, findings, rule, redrawn));
  adjust_trends(trends);
  return trends;
}

void adjust_trends(std::vector<Trend>& trends) {
  std::vector<double> p_values;
  std::vector<Trend*> compared;
  for (Trend& trend : trends) {
    if (trend.status == TrendStatus::kNoPairs) continue;
    p_values.push_back(trend.p);
    compared.push_back(&trend);
  }
  const auto adjusted = adjust_holm(p_values);
  for (std::size_t i = 0; i < compared.size(); ++i) {
    Trend& trend = *compared[i];
    trend.p_holm = adjusted[i];
    trend.holds = adjusted[i] <= kTrendLevel && trend.interval &&
                  (trend.interval->lower > 0 || trend.interval->upper < 0);
  }
}

Trend compare_studies(const ComparedStudy& from, const ComparedStudy& to, Rule rule) {
  Question question{"study", from.name, to.name, {}, {}, {}};
  const Columns columns(from.findings);
  std::vector<ColumnFinding> findings = from.findings;
  for (const ColumnFinding& finding : to.findings) {
    const std::size_t place = columns.place_of(finding.column);
    if (place != kAbsent) question.add(finding.column.object, {place, findings.size()});
    findings.push_back(finding);
  }
  const auto r = static_cast<std::size_t>(rule);
  const auto& earlier = from.uncertainty.resamples[r];
  const auto& later = to.uncertainty.resamples[r];
  std::vector<Resampled> rows;
  for (std::size_t a = 0, b = 0; !later.empty() && a < earlier.size();
       a += from.findings.size(), b += to.findings.size()) {
    EQ_CHECK(b + to.findings.size() <= later.size(), b, later.size());
    rows.insert(rows.end(), earlier.data() + a, earlier.data() + a + from.findings.size());
    rows.insert(rows.end(), later.data() + b, later.data() + b + to.findings.size());
  }
  const Redrawn redrawn{find_resampled_outcomes(rows, findings, rule),
                        std::min(from.uncertainty.subjects, to.uncertainty.subjects)};
  std::vector<Trend> trends{answer(question, findings, rule, redrawn)};
  adjust_trends(trends);
  return trends.front();
}

std::string describe_trend(const Trend& trend) {
  const std::string along = fmt::format("{} {} to {}", trend.factor, trend.from, trend.to);
  if (trend.status == TrendStatus::kNoPairs) return fmt::format("Along {} nothing could be compared.", along);
  if (trend.status == TrendStatus::kFlat)
    return fmt::format("Along {} equivalence was the same in all {} pairs.", along, trend.pairs);
  const std::string counts =
      fmt::format("gained in {} and lost in {} of {} pairs", trend.gained, trend.lost, trend.pairs);
  const char* way = trend.gained > trend.lost   ? "more often"
                    : trend.gained < trend.lost ? "less often"
                                                : "as often";
  return trend.holds ? fmt::format("Along {} equivalence exists {} ({}).", along, way, counts)
                     : fmt::format("Along {} no trend is shown ({}).", along, counts);
}

std::string format_trend_status(TrendStatus status) {
  switch (status) {
    case TrendStatus::kTested:
      return "tested";
    case TrendStatus::kFlat:
      return "flat";
    case TrendStatus::kTooFewSubjects:
      return "too_few_subjects";
    case TrendStatus::kNoPairs:
      break;
  }
  return "no_pairs";
}

}  // namespace equilux
