// The page's doubts: how sure verdicts are, which trends hold, and where numbers come from.
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <set>

#include "analysis/markup.h"
#include "analysis/order_draws.h"
#include "analysis/page_sections.h"
#include "analysis/report_tables.h"
#include "analysis/tables.h"
#include "analysis/trend_bounds.h"
#include "analysis/words.h"

namespace equilux {
namespace {

// Levels that an experiment tested in a column.
std::vector<int> find_tested(const ColumnCounts& counts) {
  std::vector<int> tested;
  for (const LevelCount& level : counts) {
    if (level.count.n > 0) tested.push_back(level.level);
  }
  return tested;
}

// "&ge; C8" where no tested level bounds a cut from there on: it may be more clamped.
std::string format_end(int place, const std::vector<int>& tested, Experiment experiment, const Study& study) {
  const std::string level = format_place(place, study);
  if (tested.empty() || level == "none") return level;
  if (experiment == Experiment::kArtifact) {
    if (place > tested.back()) return "&ge; " + level;
    return place <= tested.front() && place > study.clamp_levels.front() ? "&le; " + level : level;
  }
  return place >= tested.back() && place < study.clamp_levels.back() ? "&ge; " + level : level;
}

// "&lt; C7 to C9" where a material cut may lie below all tested levels.
std::string format_range(const std::optional<CutRange>& range, const ColumnCounts& counts,
                         Experiment experiment, const Study& study) {
  if (!range) return kDash;
  const std::vector<int> tested = find_tested(counts);
  if (experiment == Experiment::kMaterial && !tested.empty() && range->lower < tested.front() &&
      tested.front() > study.clamp_levels.front()) {
    const std::string below = "&lt; " + format_clamp(tested.front());
    return range->upper < tested.front()
               ? below
               : fmt::format("{} to {}", below, format_end(range->upper, tested, experiment, study));
  }
  const std::string lower = format_end(range->lower, tested, experiment, study),
                    upper = format_end(range->upper, tested, experiment, study);
  return range->lower == range->upper ? lower : fmt::format("{} to {}", lower, upper);
}

// The range, and whether the cut may lie beyond the tested levels.
std::string format_cut_range(const std::optional<CutRange>& range, const ColumnCounts& counts,
                             const Threshold& threshold, Experiment experiment, const Study& study) {
  const bool is_censored =
      threshold.status == CutStatus::kCensoredLow || threshold.status == CutStatus::kCensoredHigh;
  const bool is_beyond = is_censored && !is_at_scale_end(threshold, experiment, counts);
  return format_range(range, counts, experiment, study) +
         (is_beyond ? fmt::format(" <span class=\"note\">{}</span>", format_status(threshold.status)) : "");
}

// Whether a verdict stands on levels alone that were not tested for artifacts: no level that is equivalent
// was asked about in both experiments, or none is and the levels that might be are less clamped than the
// window, where the rule takes artifacts for granted. There are none where the window begins the scale.
bool rests_on_untested(const ColumnFinding& column, Rule rule) {
  const RuleFinding& finding = column.under(rule);
  if (finding.verdict == Verdict::kNone) {
    return finding.artifact.status == CutStatus::kCensoredLow &&
           !is_at_scale_end(finding.artifact, Experiment::kArtifact, column.artifact);
  }
  for (std::size_t i = 0; i < finding.regions.size(); ++i) {
    if (finding.regions[i] == Region::kEquivalent && is_observed(column, Region::kEquivalent, i))
      return false;
  }
  return true;
}

std::string format_interval(const std::optional<Interval>& interval) {
  return interval ? fmt::format("{:+.2f} to {:+.2f}", interval->lower, interval->upper) : kDash;
}

const char* mark_verdict(const RuleFinding& finding) {
  return finding.verdict == Verdict::kExists ? "+" : finding.verdict == Verdict::kNone ? "&minus;" : "?";
}

std::string format_clamp_or_none(int level) { return level == 0 ? "&infin;" : format_clamp_value(level); }

// "C7 C8 (c 0.316 to 0.1), supported: C8"
std::string format_green(const RuleFinding& finding) {
  if (finding.green.empty()) return kDash;
  const std::string first = format_clamp_or_none(finding.green.front()),
                    last = format_clamp_or_none(finding.green.back());
  return fmt::format("{} (c {}){}", format_levels(finding.green),
                     first == last ? first : fmt::format("{} to {}", first, last),
                     finding.supported.empty() ? "" : ", supported: " + format_levels(finding.supported));
}

// Why a column has no numbers of uncertainty, or not all.
std::string explain_status(UncertaintyStatus status, Rule rule) {
  switch (status) {
    case UncertaintyStatus::kEstimated:
      return "";
    case UncertaintyStatus::kUntested:
      return "an experiment has no answers here";
    case UncertaintyStatus::kOneSubject:
      return "one subject: nobody to draw again";
    case UncertaintyStatus::kTooFewSubjects:
      return "too few subjects for ranges";
    case UncertaintyStatus::kNoCandidates:
      return "no level is left free of artifacts";
    case UncertaintyStatus::kDropped:
      break;
  }
  return fmt::format("dropped by pruning; under {} levels are free, nobody was asked", format_rule(rule));
}

// The share, or a bound of it, rounded up: that of a level that is free of artifacts where none was left to
// ask about.
std::string format_bounded(const RuleUncertainty& under, const std::optional<double>& value,
                           const std::optional<double>& bound) {
  if (value || !bound || under.status != UncertaintyStatus::kNoCandidates) return format_share(value);
  return fmt::format("&le; {:.2f}", std::ceil(*bound * 100) / 100);
}

// The subject numbers of a column whose leaving out turns the verdict, both experiments.
std::string count_flips(const ColumnUncertainty& column, Rule rule) {
  const RuleUncertainty& under = column.under(rule);
  if (under.status == UncertaintyStatus::kNoCandidates && under.free_bootstrap)
    return fmt::format("{}", under.free_flips.size());
  if (!is_resampled(under.status)) return kDash;
  return fmt::format("{}", under.artifact_flips.size() + under.material_flips.size());
}

std::vector<std::string> confidence_row(const Report& report, std::size_t c) {
  const ColumnFinding& finding = report.findings[c];
  const ColumnUncertainty& column = report.uncertainty.columns[c];
  const RuleUncertainty& under = column.under(report.rule);
  return {escape_xml(format_key(finding.column)),
          mark_verdict(finding.under(report.rule)),
          format_green(finding.under(report.rule)),
          format_bounded(under, under.posterior, under.free_posterior),
          format_share(under.posterior_above_half),
          format_bounded(under, under.bootstrap, under.free_bootstrap),
          count_flips(column, report.rule),
          mark_verdict(report.at_other_percents[0][c].under(report.rule)),
          mark_verdict(report.at_other_percents[1][c].under(report.rule)),
          format_cut_range(under.artifact_cut, finding.artifact, finding.under(report.rule).artifact,
                           Experiment::kArtifact, report.study),
          format_cut_range(under.material_cut, finding.material, finding.under(report.rule).material,
                           Experiment::kMaterial, report.study),
          explain_status(under.status, report.rule)};
}

double eval_share_error(double share, int draws) { return std::sqrt(share * (1 - share) / draws); }

struct Firmness {
  std::size_t firm = 0, assumed = 0, exists = 0, supported = 0, by_one = 0, by_cut = 0, judged = 0,
              of_one_subject = 0;
};

constexpr double kFirmShare = 0.95;  ///< of draws from either prior, and of resamples, for a firm verdict

bool is_shared(const RuleFinding& finding, const RuleUncertainty& under) {
  if (under.status != UncertaintyStatus::kEstimated) return false;
  if (!under.posterior || !under.posterior_above_half || !under.bootstrap) return false;
  const bool exists = finding.verdict == Verdict::kExists;
  const auto sure = [&](double share) { return exists ? share >= kFirmShare : share <= 1 - kFirmShare; };
  return sure(*under.posterior) && sure(*under.posterior_above_half) && sure(*under.bootstrap);
}

// Verdicts that nineteen of twenty resamples and draws share, and those that a trifle turns.
Firmness count_firm(const Report& report, Rule rule) {
  Firmness sum;
  for (std::size_t c = 0; c < report.findings.size(); ++c) {
    const RuleFinding& finding = report.findings[c].under(rule);
    const RuleUncertainty& under = report.uncertainty.columns[c].under(rule);
    if (finding.verdict == Verdict::kExists) ++sum.exists;
    if (!finding.supported.empty()) ++sum.supported;
    sum.of_one_subject += under.status == UncertaintyStatus::kOneSubject ? 1 : 0;
    if (!under.posterior || !under.bootstrap) continue;
    ++sum.judged;
    if (is_shared(finding, under)) ++(rests_on_untested(report.findings[c], rule) ? sum.assumed : sum.firm);
    sum.by_one += under.artifact_flips.empty() && under.material_flips.empty() ? 0 : 1;
    sum.by_cut += report.at_other_percents[0][c].under(rule).verdict != finding.verdict ||
                          report.at_other_percents[1][c].under(rule).verdict != finding.verdict
                      ? 1
                      : 0;
  }
  return sum;
}

std::string format_assumed(std::size_t columns) {
  if (columns == 0) return "";
  return fmt::format(
      " ({} more would, but {} on levels alone that were never tested for artifacts, of which the rule "
      "allows no doubt)",
      columns, choose_form(columns, "stands", "stand"));
}

std::string describe_judged(const Firmness& sum) {
  std::string text = fmt::format(
      "Of {} with answers of two or more subjects in both experiments, {} {} a verdict that at "
      "least 95&nbsp;% of posterior draws from either prior and of resamples of subjects share{}; in {} "
      "leaving out a single subject turns it, and in {} a cut at 70 or 80&nbsp;% correct instead of "
      "75&nbsp;% does.",
      format_count(sum.judged, "column"), sum.firm, choose_form(sum.firm, "has", "have"),
      format_assumed(sum.assumed), sum.by_one, sum.by_cut);
  if (sum.judged == 0) text = "No column has answers of two or more subjects in both experiments.";
  if (sum.of_one_subject == 0) return text;
  return text + fmt::format(
                    " In {} an experiment has one subject alone: nothing was resampled there, and "
                    "nobody could be left out.",
                    format_count(sum.of_one_subject, "column"));
}

// Flagged iff 4 k >= 3 n: what leaving one out makes of the cell that is nearest to being flagged.
std::string describe_leaving_out(const Report& report) {
  std::set<std::int64_t> sizes;
  for (const Tally* tally : {&report.artifact, &report.material}) {
    for (const auto& [cell, count] : *tally) {
      if (count.n > 1) sizes.insert(count.n);
    }
  }
  std::vector<std::string> texts;
  for (const std::int64_t n : sizes) {
    const std::int64_t k = (3 * n + 3) / 4 - 1;
    if (is_flagged({k, n - 1}) || texts.size() == 4) continue;
    texts.push_back(fmt::format("{} of {} becomes {} of {} at most", k, n, k, n - 1));
  }
  if (texts.empty()) return "";
  return fmt::format(
      " Leaving one out cannot see how near a cell is to being flagged that is not: {}, not flagged either, "
      "though one more right answer would flag it.",
      fmt::join(texts, "; "));
}

std::string describe_unattainable(const std::vector<Trend>& trends, const std::vector<double>& least) {
  std::size_t asked = 0, beyond = 0;
  for (std::size_t i = 0; i < trends.size(); ++i) {
    if (trends[i].status == TrendStatus::kNoPairs) continue;
    ++asked;
    beyond += least[i] > kTrendLevel ? 1 : 0;
  }
  if (beyond == 0) return "";
  return fmt::format(
      "{} of the {} that {} asked for could not be shown whatever the answers: so few objects give "
      "no "
      "p by Holm of "
      "{:g} or less. That nothing is shown there says nothing against a trend.",
      beyond, format_count(asked, "trend"), choose_form(asked, "is", "are"), kTrendLevel);
}

std::vector<std::string> trend_fields(const Trend& trend, double least_holm) {
  const std::string name = fmt::format("{}, {} to {}", trend.factor, trend.from, trend.to);
  if (trend.status == TrendStatus::kNoPairs)
    return {escape_xml(name), "nothing to compare", kDash, kDash, kDash, kDash, kDash, kDash, kDash, kDash};
  return {escape_xml(name),
          trend.holds ? R"(<span class="met">HOLDS</span>)" : "not shown",
          fmt::format("{}", trend.pairs),
          fmt::format("{}", trend.clusters),
          fmt::format("{} / {}", trend.gained, trend.lost),
          trend.effect ? fmt::format("{:+.2f}", *trend.effect) : kDash,
          trend.status == TrendStatus::kTooFewSubjects ? "too few subjects" : format_interval(trend.interval),
          format_small(trend.p),
          format_small(trend.p_holm),
          format_small(least_holm)};
}

}  // namespace

std::string format_share(const std::optional<double>& value) {
  return value ? fmt::format("{:.2f}", *value) : kDash;
}

std::string format_small(double p) { return p < 0.0001 ? "&lt; 0.0001" : fmt::format("{:.4f}", p); }

std::string format_uncertainty(const Report& report) {
  Table table{{"column", "EE", "levels", "posterior", "cut off at &frac12;", "resampled", "turned by one",
               "EE at 70 %", "EE at 80 %", "artifact cut", "material cut", "remark"},
              {}};
  for (std::size_t c = 0; c < report.findings.size(); ++c) table.rows.push_back(confidence_row(report, c));
  const Firmness sum = count_firm(report, report.rule);
  return fmt::format("<p>{} EE is found in {}, of which {} {} supported at some level.</p>\n",
                     describe_judged(sum), format_count(sum.exists, "column"), sum.supported,
                     choose_form(sum.supported, "is", "are")) +
         fmt::format("<details><summary>Each of the {}</summary>\n{}</details>\n",
                     format_count(table.rows.size(), "column"), format_html_table(table, 99)) +
         fmt::format(
             "<p class=\"note\">EE, equivalence exists: + at some level, &minus; at none, ? not tested to "
             "the end. "
             "Levels: those found equivalent, with their greatest and least c in 1/m&sup2;; the first takes "
             "the least "
             "light from the object. Posterior: probability that equivalence exists, each cell&rsquo;s "
             "proportion "
             "drawn "
             "{} times from its posterior (Jeffreys&rsquo; prior) and judged by the same rule; levels beyond "
             "the window it takes as the rule does, less clamped ones to have artifacts and more clamped "
             "ones to be free of them, without doubt. It takes the cells of a column as independent, "
             "although the same "
             "people answered them: where people differ it may be surer than it should; resampled shares "
             "keep "
             "a person&rsquo;s answers together. Cut off at &frac12;: the same with Jeffreys&rsquo; prior "
             "cut off below one half, where no proportion correct can lie. Resampled: share of {} samples of "
             "subjects, drawn "
             "again with "
             "replacement in "
             "each experiment, in which it exists; the cuts are 95&nbsp;% ranges over them, under paper "
             "widened to those under isotonic, and "
             "&ldquo;none&rdquo; stands for no level, &ldquo;&ge; C8&rdquo; for C8 and more clamped, not "
             "tested, &ldquo;&le;&rdquo; for less clamped, &ldquo;&lt; C7&rdquo; for a material cut below "
             "C7, the "
             "first "
             "level tested, where that looks changed already; censored_low and censored_high: the cut itself "
             "may lie beyond the tested levels; no such mark where these reach the end of the scale. Of "
             "fewer than six subjects in an experiment no range is given for its cuts, and no verdict counts "
             "as shared. Turned by one: subjects without any one of whom the verdict "
             "is another, by name in <code>subjects.csv</code>. Where no level is left free of artifacts "
             "nobody was "
             "asked about the material: &le; is the share in which some level is free, more cannot be "
             "equivalent, "
             "and turned by one counts the subjects without whom that is another.{} Seed {}. From "
             "<code>ee.csv</code> and "
             "<code>thresholds.csv</code>.</p>\n"
             "<p class=\"note\">Supported is said of one level: in each experiment by itself, one-sided at "
             "95&nbsp;%, "
             "its proportion lies below 75&nbsp;%. No allowance is made for two experiments, several levels "
             "or columns. "
             "Posterior and resampled are of the whole column, where chance at any level may move a cut: so "
             "a supported "
             "column may well have less than 0.95 there. Drawn by chance, a share s of N draws has a "
             "standard error of "
             "&radic;(s(1&minus;s)/N): at most {:.3f} of posterior and {:.3f} of resampled shares, at 0.95 "
             "{:.3f} and "
             "{:.3f}. The levels of the material experiment were chosen by flags at 75&nbsp;%: EE at 70 and "
             "80&nbsp;% "
             "rests on those.</p>\n",
             report.params.posterior_draws, report.params.resamples, describe_leaving_out(report),
             report.params.seed, eval_share_error(0.5, report.params.posterior_draws),
             eval_share_error(0.5, report.params.resamples),
             eval_share_error(0.95, report.params.posterior_draws),
             eval_share_error(0.95, report.params.resamples));
}

std::string format_rule_certainty(const Report& report) {
  Table table{{"column", "EE, paper", "posterior", "resampled", "EE, isotonic", "posterior", "resampled"},
              {}};
  std::size_t differ = 0;
  for (std::size_t c = 0; c < report.findings.size(); ++c) {
    std::vector<std::string> row{escape_xml(format_key(report.findings[c].column))};
    std::set<bool> firm;
    for (const Rule rule : kRules) {
      const RuleFinding& finding = report.findings[c].under(rule);
      const RuleUncertainty& under = report.uncertainty.columns[c].under(rule);
      const bool stands = is_shared(finding, under) && !rests_on_untested(report.findings[c], rule);
      firm.insert(stands);
      row.insert(row.end(), {std::string(mark_verdict(finding)) + (stands ? " firm" : ""),
                             format_bounded(under, under.posterior, under.free_posterior),
                             format_bounded(under, under.bootstrap, under.free_bootstrap)});
    }
    differ += firm.size() > 1 ? 1 : 0;
    table.rows.push_back(std::move(row));
  }
  const Firmness paper = count_firm(report, Rule::kPaper), isotonic = count_firm(report, Rule::kIsotonic);
  if (paper.judged + isotonic.judged == 0) return "";
  return fmt::format(
             "<p>How sure a verdict is can depend on the rule; here it does in {}. Firm, that is "
             "shared by at "
             "least 95&nbsp;% of draws from either prior and of resamples and does not stand on untested "
             "levels alone, are {} of {} verdicts under <i>paper</i> and {} "
             "of {} under "
             "<i>isotonic</i>. Under <i>paper</i> one level flagged by chance moves the cut; under "
             "<i>isotonic</i> it is "
             "pooled with its neighbours first.</p>\n",
             format_count(differ, "column"), paper.firm, paper.judged, isotonic.firm, isotonic.judged) +
         format_html_table(table, 99) + "<p class=\"note\">From <code>ee.csv</code>.</p>\n";
}

std::string format_trends(const Report& report) {
  if (report.trends.empty())
    return "<p>No trend is asked for in this study. Trends are asked along VPL counts, the blobs G0, G1, "
           "..., the steps MS-MR, MS-BS, BS-BR and BS-GS, and illumination, where a study has both "
           "ends.</p>\n";
  Table table{{"along", "verdict", "pairs", "objects", "gained / lost", "effect", "95 % interval", "p",
               "p, Holm", "least p, Holm"},
              {}};
  std::string sentences;
  const std::vector<double> least = find_least_holm(report.trends);
  for (std::size_t i = 0; i < report.trends.size(); ++i) {
    const Trend& trend = report.trends[i];
    table.rows.push_back(trend_fields(trend, least[i]));
    if (trend.holds) sentences += fmt::format("{} ", escape_xml(describe_trend(trend)));
  }
  if (sentences.empty()) sentences = "No trend is shown. ";
  return fmt::format("<p>{}{}</p>\n", sentences, describe_unattainable(report.trends, least)) +
         format_html_table(table, 2) +
         "<p class=\"note\">Columns that differ in one factor alone are compared in pairs: gained, "
         "equivalence at "
         "the later level only; lost, at the earlier only; effect, their difference by all pairs. p is "
         "exact, two-"
         "sided: verdicts permuted within such a set of columns, those of an object at all its VPL counts "
         "together, since they go up and down together: so the number of objects and not of pairs says how "
         "much "
         "can be shown; Holm&rsquo;s allows for the number of "
         "trends; the least is what verdicts all at one end, along every trend, would give. p speaks of the "
         "columns of this study, the interval of its subjects, neither of other scenes. The interval is the "
         "effect give or take the farther end of what subjects drawn again give; a column that was dropped, "
         "and in "
         "such a sample would not be, counts as what takes the effect farther. A trend "
         "holds iff p by Holm is 0.05 or less and "
         "the "
         "interval leaves out 0; fewer than six subjects have no interval. From "
         "<code>trends.csv</code>.</p>\n";
}

std::string format_tracing(const std::vector<Report>& reports) {
  Table table{{"what", "file", "made from"}, {}};
  table.rows = {
      {"k and n of a cell", "cells.csv",
       "<code>SELECT cell, sum(answer = test_side), count(*) FROM trial JOIN session ON session.id = session "
       "WHERE kind = KIND AND experiment = EXPERIMENT AND complete = 1 AND phase = 'main' "
       "AND answer IS NOT NULL "
       "GROUP BY cell</code> in each log; added up over logs"},
      {"intervals, p, q, posterior", "cells.csv",
       "k and n alone; q from the p of all tested cells of the experiment"},
      {"cuts, regions, EE", "thresholds.csv, ee.csv", "k and n of a column&rsquo;s cells, by the rule named"},
      {"resampled shares and cuts, turned by one", "ee.csv, thresholds.csv",
       "answers by subject, streams <code>analysis/bootstrap/EXPERIMENT/STUDY</code> of the seed"},
      {"posterior of EE", "ee.csv",
       "k and n, streams <code>analysis/posterior/EXPERIMENT/CELL</code> of the seed; cut off below one "
       "half, "
       "also <code>analysis/posterior-above-half/EXPERIMENT/CELL</code>"},
      {"trends", "trends.csv", "verdicts of ee.csv and the resamples"},
      {"dates, screens, answers to questions", "report.json (<code>participation</code>)",
       "<code>SELECT * FROM session LEFT JOIN field ON field.session = session.id WHERE kind = KIND AND "
       "experiment "
       "= EXPERIMENT AND complete = 1</code>, counted"},
      {"verdicts without the marked sessions", "report.json (<code>flipped_without_marked</code>)",
       "counts less those of the sessions with <code>marks</code> in <code>subjects.csv</code>, by the same "
       "rule"},
      {"what a prior cut off below one half would add",
       "report.json (<code>prior_cut_off_adds_at_most</code>)", "k and n of every tested cell"},
      {"design", "study.json, session.json, windows.json, selection-KIND.json",
       "the study folder; digests below"},
      {"order effects", "order.csv",
       fmt::format("trials by session; {} draws, streams <code>{}</code> and <code>{}</code> of the seed",
                   kOrderDraws, kOrderFlipStream, kOrderBootstrapStream)},
      {"noise of the references", "manifest.json",
       "<code>standard_error</code> and <code>reference</code> of each reference picture; targets from "
       "study.json"},
      {"sessions, sides, times", "subjects.csv",
       "<code>SELECT * FROM trial WHERE session = SESSION ORDER BY trial</code>; where logs are pooled, the "
       "session of that participant in the log of the folder beside it"}};
  std::string folders;
  for (const Report& report : reports) {
    for (const std::string& folder : report.folders)
      folders += fmt::format("<li><code>{}</code></li>\n", escape_xml(folder));
  }
  return format_html_table(table, 99) +
         (folders.empty() ? "" : "<p>Logs were read from:</p><ul>" + folders + "</ul>\n") +
         "<p class=\"note\">What each column means stands in <code>csv-metadata.json</code>; "
         "<code>report.json</code> holds all of it with versions, digests, seeds and rules.</p>\n";
}

}  // namespace equilux
