// The page's methods: what was asked, who answered, how it was counted, and where everything came from.
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <set>

#include "analysis/markup.h"
#include "analysis/order_draws.h"
#include "analysis/page_sections.h"
#include "analysis/participation.h"
#include "analysis/probability.h"
#include "analysis/tables.h"
#include "analysis/views.h"
#include "analysis/words.h"
#include "base/version.h"

namespace equilux {
namespace {

const Tally& tally_of(const Report& report, Experiment experiment) {
  return experiment == Experiment::kArtifact ? report.artifact : report.material;
}

std::set<std::int64_t> find_cell_sizes(const Tally& tally) {
  std::set<std::int64_t> sizes;
  for (const auto& [cell, count] : tally) {
    if (count.n > 0) sizes.insert(count.n);
  }
  return sizes;
}

std::string format_sizes(const std::set<std::int64_t>& sizes) {
  if (sizes.empty()) return "&ndash;";
  if (sizes.size() == 1) return fmt::format("{}", *sizes.begin());
  return fmt::format("{} to {}", *sizes.begin(), *sizes.rbegin());
}

std::size_t count_tested(const Tally& tally) {
  return static_cast<std::size_t>(
      std::count_if(tally.begin(), tally.end(), [](const auto& cell) { return cell.second.n > 0; }));
}

std::vector<std::string> answered_row(const Report& report, Experiment experiment) {
  const Tally& tally = tally_of(report, experiment);
  const ExperimentEvidence& evidence = report.evidence.of(experiment);
  const std::int64_t ended = count_ended_early(evidence);
  return {format_experiment(experiment),
          fmt::format("{}", evidence.finished.size()),
          fmt::format("{}", count_participants(evidence)),
          fmt::format("{}", ended),
          fmt::format("{}", evidence.unfinished - ended),
          fmt::format("{}", count_answers(tally)),
          fmt::format("{} of {}", count_tested(tally), tally.size()),
          format_sizes(find_cell_sizes(tally))};
}

std::vector<std::string> view_row(Experiment experiment, const std::array<Count, 2>& views) {
  std::vector<std::string> row{format_experiment(experiment)};
  for (const Count& count : views) {
    row.push_back(fmt::format("{} of {}", count.k, count.n));
    row.push_back(count.n > 0
                      ? fmt::format("{:.3f}", static_cast<double>(count.k) / static_cast<double>(count.n))
                      : kDash);
  }
  return row;
}

// Both cameras are counted together: what a reader can judge that by.
std::string format_views(const Report& report) {
  Table table{{"experiment", "v0, correct", "share", "v1, correct", "share"}, {}};
  for (const auto experiment : {Experiment::kArtifact, Experiment::kMaterial}) {
    if (const auto views = count_by_view(report.evidence.of(experiment)))
      table.rows.push_back(view_row(experiment, *views));
  }
  const std::string note =
      "<p class=\"note\">The answers of both views of a cell are counted together. {} Cells by view: "
      "<code>test_view</code> of <code>equilux-session export</code>.</p>\n";
  if (table.rows.empty()) return fmt::format(fmt::runtime(note), "Of which view each was is not known here.");
  return format_html_table(table, 1) +
         fmt::format(fmt::runtime(note),
                     "The shares are over all cells, which sessions see from either view in turn; "
                     "<code>report.json</code> has them as <code>by_view</code>.");
}

// Tested cells of an experiment by n: the cut, and what guessing alone would do.
Table list_cuts(const Report& report) {
  Table table{{"experiment", "answers per cell, n", "cells", "flagged from k", "by guessing, one cell",
               "by guessing, all cells", "flagged"},
              {}};
  for (const auto experiment : {Experiment::kArtifact, Experiment::kMaterial}) {
    std::map<std::int64_t, std::pair<std::size_t, std::size_t>> cells;  // by n: all, flagged
    for (const auto& [cell, count] : tally_of(report, experiment)) {
      if (count.n == 0) continue;
      ++cells[count.n].first;
      cells[count.n].second += is_flagged(count) ? 1 : 0;
    }
    for (const auto& [n, sizes] : cells) {
      const std::int64_t k = (3 * n + 3) / 4;
      const double chance = *eval_p_guess({k, n});
      table.rows.push_back({format_experiment(experiment), fmt::format("{}", n),
                            fmt::format("{}", sizes.first), fmt::format("{}", k),
                            fmt::format("{:.4f}", chance),
                            fmt::format("{:.1f}", chance * static_cast<double>(sizes.first)),
                            fmt::format("{}", sizes.second)});
    }
  }
  return table;
}

std::string format_rule_text(Rule rule) {
  if (rule == Rule::kPaper) {
    return "<b>paper</b>: the artifact cut lies just after the most clamped flagged level; untested levels "
           "less "
           "clamped than it count as artifacts, more clamped ones as free. The material region opens at the "
           "first "
           "changed level; an untested level counts as unchanged only between two unchanged tested ones.";
  }
  return "<b>isotonic</b>: proportions are first made monotone by pooling adjacent violators, weighted by n "
         "(falling with clamp for artifacts, rising for material); a block is flagged iff 4&Sigma;k &ge; "
         "3&Sigma;n; the rest as under <i>paper</i>.";
}

constexpr const char* kCellsNote =
    "<p class=\"note\">k of n subjects were correct; a dot: flagged, at 75&nbsp;% or more. Intervals: "
    "two-sided, "
    "95&nbsp;%, of the proportion correct, each for its cell alone. p by guessing: probability of k or more "
    "of n at one "
    "half, one-sided, exact. q: the same after Benjamini and Hochberg, over the tested cells of the "
    "experiment. "
    "P(over 75&nbsp;%): posterior probability that the true proportion is 75&nbsp;% or more, from "
    "Jeffreys&rsquo; prior, "
    "Beta(1/2, 1/2), as for the interval of that name. From <code>cells.csv</code>.</p>\n";

struct NoiseMeasure {
  const char* member;
  const char* name;
  double target;
};

std::vector<std::string> noise_row(const Report& report, const NoiseMeasure& measure) {
  double worst = 0;
  std::string worst_key = "&ndash;";
  for (const auto& [key, picture] : report.manifest->pictures) {
    if (picture.standard_error.is_null()) continue;
    const double error = picture.standard_error.at(measure.member).as_double();
    if (worst_key != "&ndash;" && error <= worst) continue;
    worst = error;
    worst_key = escape_xml(key);
  }
  const bool met = worst <= measure.target;
  return {measure.name, worst_key,
          fmt::format(R"(<span class="{}">{}</span>)", met ? "met" : "missed", met ? "MET" : "MISSED"),
          fmt::format("{:.2f}", worst), fmt::format("{}", measure.target)};
}

std::size_t count_measured_references(const Report& report) {
  if (!report.manifest) return 0;
  const auto& pictures = report.manifest->pictures;
  return static_cast<std::size_t>(std::count_if(pictures.begin(), pictures.end(), [](const auto& entry) {
    return !entry.second.standard_error.is_null();
  }));
}

std::string format_interval(const Interval& interval) {
  return fmt::format(R"(<span class="key">{:.2f} to {:.2f}</span>)", interval.lower, interval.upper);
}

std::vector<std::string> cell_fields(Experiment experiment, const Cell& cell, const Count& count,
                                     const CellEstimate& estimate) {
  return {format_experiment(experiment),
          fmt::format(R"(<span class="key">{}</span>)", escape_xml(format_key(cell))),
          is_flagged(count) ? "&#9679;" : "",
          fmt::format("{}", count.k),
          fmt::format("{}", count.n),
          fmt::format("{:.3f}", estimate.proportion),
          format_interval(estimate.clopper_pearson),
          format_interval(estimate.jeffreys),
          format_small(estimate.p_guess),
          format_small(estimate.q_guess),
          fmt::format("{:.3f}", estimate.posterior_over)};
}

class DefinitionList {
 public:
  void add(const std::string& term, const std::string& text) {
    text_ += fmt::format("<dt>{}</dt><dd>{}</dd>\n", term, text);
  }
  void add_digests(const std::string& term, const std::set<std::string>& digests) {
    std::string text;
    for (const std::string& digest : digests) {
      if (!digest.empty()) text += fmt::format(R"(<span class="digest">{}</span> )", escape_xml(digest));
    }
    if (!text.empty()) add(term, text);
  }
  std::string finish() const { return "<dl class=\"provenance\">\n" + text_ + "</dl>\n"; }

 private:
  std::string text_;
};

template <typename Get>
auto collect(const ExperimentEvidence& evidence, const Get& get) {
  std::set<std::decay_t<decltype(get(evidence.finished.front()))>> values;
  for (const SessionRow& session : evidence.finished) values.insert(get(session));
  return values;
}

void add_sessions(DefinitionList& list, const ExperimentEvidence& evidence, Experiment experiment) {
  if (evidence.finished.empty()) return;
  const std::string name = format_experiment(experiment) + " sessions";
  list.add(
      name + ": program",
      escape_xml(fmt::format(
          "{}", fmt::join(collect(evidence, [](const auto& row) { return row.program_version; }), ", "))));
  list.add(name + ": seeds",
           fmt::format("{}", fmt::join(collect(evidence, [](const auto& row) { return row.seed; }), ", ")));
  list.add_digests(name + ": answers", {evidence.digest});
  list.add_digests(name + ": pictures",
                   collect(evidence, [](const auto& row) { return row.digests.manifest; }));
  list.add_digests(name + ": windows",
                   collect(evidence, [](const auto& row) { return row.digests.windows; }));
  list.add_digests(name + ": selection",
                   collect(evidence, [](const auto& row) { return row.digests.selection; }));
  list.add_digests(name + ": session protocol",
                   collect(evidence, [](const auto& row) { return row.digests.protocol; }));
  list.add_digests(name + ": planted truth",
                   collect(evidence, [](const auto& row) { return row.digests.truth; }));
}

}  // namespace

std::string format_html_table(const Table& table, std::size_t first_number) {
  std::string text = "<div class=\"grid\"><table><thead><tr>";
  const auto style = [&](std::size_t i) { return i >= first_number ? " class=\"number\"" : ""; };
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    text += fmt::format("<th{}>{}</th>", style(i), table.columns[i]);
  }
  text += "</tr></thead><tbody>\n";
  for (const auto& row : table.rows) {
    text += "<tr>";
    for (std::size_t i = 0; i < row.size(); ++i) text += fmt::format("<td{}>{}</td>", style(i), row[i]);
    text += "</tr>\n";
  }
  return text + "</tbody></table></div>\n";
}

std::string format_asked(const Report& report) {
  const Study& study = report.study;
  return (study.description.empty() ? "" : fmt::format("<p>{}</p>\n", escape_xml(study.description))) +
         fmt::format("<p>{} (a geometry, material, illumination and VPL count) of {}: {}.{}</p>\n",
                     format_count(report.findings.size(), "column"),
                     format_count(study.clamp_levels.size(), "clamp level"),
                     format_count(enumerate_cells(study).size(), "cell"),
                     study.normalise ? " All pictures were luminance-normalised." : "") +
         format_design(report) + format_levels_table(report);
}

std::string format_answered(const Report& report) {
  Table table{{"experiment", "finished sessions", "of so many codes", "ended early", "unfinished", "answers",
               "cells tested", "answers per cell"},
              {}};
  for (const auto experiment : {Experiment::kArtifact, Experiment::kMaterial}) {
    table.rows.push_back(answered_row(report, experiment));
  }
  return format_html_table(table, 1) +
         fmt::format(
             "<p class=\"note\">Only finished sessions of the kind <i>{}</i> count: those ended early or "
             "left "
             "unfinished are left out, and kinds never mix.</p>\n",
             format_kind(report.evidence.kind)) +
         format_views(report) + format_participation(report);
}

std::string describe_pruning(const Report& report) {
  if (report.evidence.material.finished.empty()) return "<p>No material session is finished yet.</p>\n";
  if (!report.selection && !report.selections.empty())
    return "<p>Some of the folders kept levels for the material experiment by a selection, and some have "
           "none: the provenance of the study lists them.</p>\n";
  if (!report.selection)
    return "<p>By which selection levels went on to the material experiment is not known: the file is "
           "missing.</p>\n";
  return fmt::format(
      "<p>Only levels free of artifacts, {}, went on to the material experiment: the "
      "first, every "
      "second, and the last. So the material cut is uncertain by one clamp level, and the green region is "
      "conservative "
      "to it.</p>\n",
      describe_selection_rule(*report.selection));
}

std::string format_counting(const Report& report) {
  std::string text =
      "<p>A cell is one picture condition, both views together; k of n subjects were correct. It is flagged "
      "iff 4k &ge; "
      "3n, in integers. 75&nbsp;% correct between two pictures is 50&nbsp;% detection after correction for "
      "guessing.</p>\n" +
      format_html_table(list_cuts(report), 1) +
      fmt::format(
          "<p class=\"note\">By guessing: the probability that a cell in which nobody sees anything is "
          "flagged, and how "
          "many flags that makes on average were all cells such. p and q of a cell ask whether anything was "
          "seen, against "
          "one half; a flag asks whether half of the subjects saw it, at 75&nbsp;%. So a cell may have a "
          "small q and no "
          "flag: no verdict rests on q.</p>\n<p>The levels of a column were cut by a named rule; this page "
          "shows "
          "<i>{}</i>, the files <code>thresholds.csv</code> and <code>ee.csv</code> both.</p>\n<ul>\n",
          format_rule(report.rule));
  for (const Rule rule : kRules) text += "<li>" + format_rule_text(rule) + "</li>\n";
  return text + "</ul>\n" + describe_pruning(report);
}

// How the references by VPL sets agree with their path-traced checks.
struct ReferenceChecks {
  std::size_t references = 0, regions = 0;
  double squares = 0, largest = 0;  // of z
  std::string where;
};

void add_checks(const Json& made, const std::string& where, ReferenceChecks& sum) {
  const Json* check = made.find("check");
  if (!check) return;
  for (const Json& region : check->as_array()) {
    const double z = region.at("z").as_double();
    ++sum.regions;
    sum.squares += z * z;
    if (std::abs(z) <= std::abs(sum.largest)) continue;
    sum.largest = z;
    sum.where = where + region.at("region").as_string();
  }
}

ReferenceChecks sum_checks(const Manifest& manifest) {
  ReferenceChecks sum;
  for (const auto& [key, picture] : manifest.pictures) {
    if (picture.reference.is_null()) continue;
    const Json* room = picture.reference.find("room");
    if (!room && !picture.reference.find("check")) continue;
    ++sum.references;
    add_checks(picture.reference, key + ", ", sum);
    if (room) add_checks(*room, key + ", room, ", sum);
  }
  return sum;
}

std::string format_checks(const Report& report) {
  const ReferenceChecks checks = sum_checks(*report.manifest);
  if (checks.regions == 0) return "";
  return fmt::format(
      "<p>In {} of them indirect light, of the object, the room or both, is the mean of independent VPL sets "
      "with what their clamp takes given back by paths. Each was compared with path tracing, which knows "
      "nothing of VPLs, in up to ten regions of its object and nine of its room: over {} regions the "
      "differences are {:.2f} standard errors (root mean "
      "square; 1 where both are right; rooms of one view share most of their light, and so differ alike), at "
      "most {:.1f} ({}).</p>\n",
      checks.references, checks.regions, std::sqrt(checks.squares / static_cast<double>(checks.regions)),
      std::abs(checks.largest), escape_xml(checks.where));
}

std::string format_noise(const Report& report) {
  const std::size_t references = count_measured_references(report);
  if (references == 0) return "";
  Table table{{"standard error, display steps of 255", "noisiest reference", "verdict", "measured", "target"},
              {}};
  const NoiseTarget& target = report.study.noise_target;
  for (const NoiseMeasure& measure :
       {NoiseMeasure{"object_mean", "object, mean", target.object_mean},
        NoiseMeasure{"object_p99", "object, 99th percentile", target.object_p99},
        NoiseMeasure{"outside_mean", "outside the object, mean", target.outside_mean}}) {
    table.rows.push_back(noise_row(report, measure));
  }
  return fmt::format(
      "<section>\n<h2>Noise of the references</h2>\n<p>The noisiest of {} references against the "
      "study&rsquo;s target.</p>\n{}<p class=\"note\">Of a pixel: half the difference that one standard "
      "error to "
      "either side makes on the screen, in the channel where it is largest; then mean and percentile over "
      "the pixels "
      "of the object, or the rest. From <code>manifest.json</code>.</p>\n{}</section>\n",
      references, format_html_table(table, 3), format_checks(report));
}

struct PriorChange {
  double change = 0;  // of the posterior of EE
  std::string where;  // the column and the rule
};

// The column in which cutting the prior off changes the posterior of EE most, either way.
std::optional<PriorChange> find_most_changed(const Report& report) {
  std::optional<PriorChange> most;
  for (std::size_t c = 0; c < report.findings.size(); ++c) {
    for (const Rule rule : kRules) {
      const RuleUncertainty& under = report.uncertainty.columns[c].under(rule);
      if (!under.posterior || !under.posterior_above_half) continue;
      const double change = *under.posterior_above_half - *under.posterior;
      if (most && std::abs(change) <= std::abs(most->change)) continue;
      most = {change, fmt::format("{}, {}", format_key(report.findings[c].column), format_rule(rule))};
    }
  }
  return most;
}

// Of the cells of an experiment alone nothing follows for EE.
std::string format_prior_change(const Report& report) {
  const auto most = find_most_changed(report);
  if (!most) return "";
  return fmt::format(
      " The posterior of EE stands both ways in <code>ee.csv</code>; cutting the prior off changes it by "
      "{:+.3f} where it does most ({}).",
      most->change, escape_xml(most->where));
}

std::string format_prior_note(const Report& report) {
  return fmt::format(
      "<p class=\"note\">Jeffreys&rsquo; prior has half its mass below one half, where no proportion correct "
      "should "
      "lie: it is kept as it is so that interval, posterior and their coverage are the known ones. Cut off "
      "below one half "
      "it would divide P(over 75&nbsp;%) by P(over 50&nbsp;%): in these cells that adds at most {:.3f} "
      "(<code>report.json</code>: <code>prior_cut_off_adds_at_most</code> of each experiment).{}</p>\n",
      std::max(find_most_by_truncation(report.artifact), find_most_by_truncation(report.material)),
      format_prior_change(report));
}

std::string format_cells(const Report& report) {
  Table table{{"experiment", "cell", "flagged", "k", "n", "proportion correct", "Clopper-Pearson", "Jeffreys",
               "p by guessing", "q", "P(over 75 %)"},
              {}};
  for (const auto experiment : {Experiment::kArtifact, Experiment::kMaterial}) {
    const Tally& tally = tally_of(report, experiment);
    for (const Cell& cell : enumerate_cells(report.study)) {
      const auto& cells = experiment == Experiment::kArtifact ? report.artifact_cells : report.material_cells;
      const auto& estimate = cells.at(cell).estimate;
      if (estimate) table.rows.push_back(cell_fields(experiment, cell, tally.at(cell), *estimate));
    }
  }
  return fmt::format(
             "<details><summary>The {} tested cells; <code>cells.csv</code> has the untested ones "
             "too</summary>\n{}</details>\n",
             table.rows.size(), format_html_table(table, 3)) +
         kCellsNote + format_prior_note(report);
}

std::string format_provenance(const Report& report) {
  DefinitionList list;
  list.add("report made by", fmt::format("equilux-analyze {}", kVersion));
  list.add("draws", fmt::format("seed {}, {} posterior draws, {} resamples of subjects", report.params.seed,
                                report.params.posterior_draws, report.params.resamples));
  list.add("order effects",
           fmt::format("{} draws each, streams <code>{}</code> and <code>{}</code> of that seed", kOrderDraws,
                       kOrderFlipStream, kOrderBootstrapStream));
  list.add("study", fmt::format("{}, seed {}", escape_xml(report.study.name), report.study.seed));
  list.add_digests("study digest", {report.study.digest});
  if (report.manifest) list.add("rendering seed", fmt::format("{}", report.manifest->seed));
  if (report.windows) list.add_digests("windows in the folder", {report.windows->digest});
  for (const FolderSelection& selection : report.selections) {
    const std::string of = fmt::format("selection of {}", escape_xml(selection.folder));
    list.add(of, fmt::format("rule {}", escape_xml(selection.rule)));
    list.add_digests(of + ": digest", {selection.digest});
    list.add_digests(of + ": made from answers", {selection.answers_digest});
  }
  if (report.selection && report.selections.empty()) {
    list.add("selection", fmt::format("rule {}, kind {}", escape_xml(report.selection->rule),
                                      format_kind(report.selection->kind)));
    list.add_digests("selection digest", {digest_selection(*report.selection)});
    list.add_digests("selection made from answers", {report.selection->answers_digest});
  }
  for (const auto experiment : {Experiment::kArtifact, Experiment::kMaterial}) {
    add_sessions(list, report.evidence.of(experiment), experiment);
  }
  return list.finish();
}

}  // namespace equilux
