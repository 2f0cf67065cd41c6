// The report as a whole: banner, warnings, files, and the same bytes for the same answers.
#include "analysis/report.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <map>
#include <set>

#include "analysis/csv.h"
#include "analysis/report_tables.h"
#include "base/files.h"
#include "tests/analysis/planted_report.h"

namespace equilux::tests {
namespace {
namespace fs = std::filesystem;

class Folder {
 public:
  Folder() {
    std::string name = (fs::temp_directory_path() / "equilux-report-XXXXXX").string();
    path = mkdtemp(name.data());
  }
  ~Folder() { fs::remove_all(path); }
  fs::path path;
};

// Tags that HTML closes must nest; the void ones stand alone.
bool is_balanced(const std::string& html) {
  const std::set<std::string> alone{"meta", "!DOCTYPE"};
  std::vector<std::string> open;
  for (std::size_t at = html.find('<'); at != std::string::npos; at = html.find('<', at + 1)) {
    const std::size_t end = html.find('>', at);
    if (end == std::string::npos) return false;
    const bool closes = html[at + 1] == '/';
    const std::size_t from = at + (closes ? 2 : 1);
    const std::string name = html.substr(from, html.find_first_of(" />\n", from) - from);
    if (alone.contains(name) || html[end - 1] == '/') continue;
    if (!closes) {
      open.push_back(name);
    } else {
      if (open.empty() || open.back() != name) return false;
      open.pop_back();
    }
  }
  return open.empty();
}

TEST(Report, on_planted_answers_says_in_a_banner_that_it_tells_nothing_about_these_pictures) {
  const PlantedStudy planted = make_planted_study("pocket", 12, 14, 1, 0.02);
  EXPECT_TRUE(has(format_page({make_planted_report(planted)}), "class=\"banner\""));
  EXPECT_TRUE(has(format_page({make_planted_report(planted)}), "They tell nothing about these pictures."));
}

TEST(Report, on_answers_of_persons_has_no_banner_and_on_looking_ones_another) {
  const PlantedStudy planted = make_planted_study("pocket", 12, 14, 1, 0.02);
  EXPECT_FALSE(has(format_page({make_planted_report(planted, SubjectKind::kPerson)}), "class=\"banner\""));
  const std::string looking = format_page({make_planted_report(planted, SubjectKind::kLooking)});
  EXPECT_TRUE(has(looking, "class=\"banner\""));
  EXPECT_FALSE(has(looking, "planted. They"));
}

TEST(Report, its_page_is_balanced_and_needs_nothing_from_outside) {
  for (const char* name : {"pocket", "paper", "validation", "normalisation"}) {
    std::string page = format_page({make_planted_report(make_planted_study(name, 12, 14, 1, 0.02))});
    EXPECT_TRUE(is_balanced(page)) << name;
    for (std::size_t at; (at = page.find("http://www.w3.org/2000/svg")) != std::string::npos;)
      page.erase(at, 26);
    for (const char* outside : {"http:", "https:", "src=", "<link", "<script", "@import"}) {
      EXPECT_FALSE(has(page, outside)) << name << ": " << outside;
    }
  }
}

TEST(Report, the_check_of_balance_fails_on_a_lost_end_tag) {
  std::string page = format_page({make_planted_report(make_planted_study("pocket", 12, 14, 1, 0.02))});
  page.erase(page.find("</table>"), 8);
  EXPECT_FALSE(is_balanced(page));
}

std::map<std::string, std::string> read_folder(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    files[entry.path().filename().string()] = load_text(entry.path());
  }
  return files;
}

TEST(Report, writes_its_tables_a_graph_for_each_object_and_the_page) {
  const Folder folder;
  const Report report = make_planted_report(make_planted_study("pocket", 12, 14, 1, 0.02));
  EXPECT_TRUE(save_report(make_report_files({report}), folder.path / "report").empty());
  std::set<std::string> names;
  for (const auto& [name, text] : read_folder(folder.path / "report")) names.insert(name);
  EXPECT_EQ(names,
            (std::set<std::string>{"cells.csv", "thresholds.csv", "ee.csv", "subjects.csv", "order.csv",
                                   "trends.csv", "csv-metadata.json", "report.json", "report-files.json",
                                   "index.html", "graph-G0-MS-ind.svg", "graph-G0-GS-ind.svg",
                                   "graph-G2-MS-ind.svg", "graph-G2-GS-ind.svg"}));
  EXPECT_EQ(parse_csv(load_text(folder.path / "report" / "thresholds.csv"), "test").rows.size(),
            2U * 8U * 2U);
}

TEST(Report, has_the_same_bytes_for_the_same_answers_in_any_order) {
  PlantedStudy planted = make_planted_study("pocket", 12, 14, 4, 0.02);
  const Folder first, second;
  save_report(make_report_files({make_planted_report(planted)}), first.path);
  RandomStream random(4, "permutation", 0);
  shuffle(planted.artifact, random);
  shuffle(planted.material, random);
  save_report(make_report_files({make_planted_report(planted)}), second.path);
  EXPECT_EQ(read_folder(first.path), read_folder(second.path));
}

TEST(Report, warns_once_artifact_sessions_were_finished_after_pruning) {
  PlantedStudy planted = make_planted_study("pocket", 12, 14, 1, 0.02);
  EXPECT_TRUE(make_planted_report(planted).warnings.empty());
  planted.selection.answers_digest = std::string(64, 'f');
  const auto warnings = make_planted_report(planted).warnings;
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(has(warnings.front(), "finished after pruning"));
  EXPECT_TRUE(has(format_page({make_planted_report(planted)}), "class=\"warning\""));
}

TEST(Report, names_every_cause_of_a_selection_from_other_answers) {
  PlantedStudy planted = make_planted_study("pocket", 12, 14, 1, 0.02);
  planted.selection.answers_digest = std::string(64, 'f');
  const std::string warning = make_planted_report(planted).warnings.at(0);
  EXPECT_TRUE(has(warning, "withdrawn after it, or it was pruned elsewhere")) << warning;
}

TEST(Report, names_every_factor_once) {
  const std::string page = format_page({make_planted_report(make_planted_study("paper", 12, 14, 1, 0.02))});
  for (const char* factor : {"geometry", "material", "illumination", "VPL count", "clamp level", "view"}) {
    const std::string row = fmt::format("<tr><td>{}</td><td>", factor);
    EXPECT_TRUE(has(page, row)) << factor;
  }
  for (const char* factor : {"geometry", "illumination"}) {
    const std::string row = fmt::format("<tr><td>{}</td><td>", factor);
    EXPECT_EQ(page.find(row), page.rfind(row)) << factor;
  }
  EXPECT_TRUE(has(page, "<tr><td></td><td>G2</td>") && has(page, "<tr><td></td><td>G3</td>"));
}

TEST(Report, says_what_its_posterior_leaves_out_and_where_subjects_are_modelled) {
  const std::string page = format_page({make_planted_report(make_planted_study("pocket", 12, 14, 1, 0.02))});
  EXPECT_TRUE(has(page, "It takes the cells of a column as independent"));
  EXPECT_TRUE(has(page, "<code>analysis/r/mixed_models.R</code>"));
  EXPECT_TRUE(has(page, "Of which view each was is not known here.")) << "these have no trials";
}

// C7 to C9 look free and C10 does not: pruned by `paper`, and read under `isotonic`, which pools them.
TEST(Report, tells_a_column_that_the_other_rule_dropped_as_untested) {
  PlantedStudy planted = answer_column({{7, 0}, {8, 0}, {9, 0}, {10, 9}}, {});
  planted.selection = make_selection(planted.study, tally_answers(planted.artifact, planted.study),
                                     SubjectKind::kPlanted, Rule::kPaper, std::string(64, 'a'));
  const Report report = make_planted_report(planted, SubjectKind::kPlanted, Rule::kIsotonic);
  const std::string page = format_page({report});
  EXPECT_TRUE(has(page, "dropped by pruning; under isotonic levels are free, nobody was asked</td>"));
  EXPECT_TRUE(has(page, "Of these 1 was dropped by pruning although under this rule levels are free"));
  EXPECT_TRUE(has(page, "<td>none</td><td>untested, dropped by pruning</td>"));
  EXPECT_FALSE(has(page, "Both rules find the same equivalent levels"));
  EXPECT_FALSE(has(page, "&le; 1.00"));
  const std::string ee = make_report_files({report}).at("ee.csv");
  EXPECT_TRUE(has(ee, ",false,,none,,,untested,,,true,no_candidates,")) << ee;
  const std::string paper = format_page({make_planted_report(planted)});
  EXPECT_TRUE(has(paper, "no level is left free of artifacts</td>"));
  EXPECT_FALSE(has(paper, "dropped by pruning although"));
}

TEST(Report, warns_of_a_selection_that_is_missing_or_another_than_the_sessions_used) {
  const PlantedStudy planted = make_planted_study("pocket", 12, 14, 1, 0.02);
  Report report = make_planted_report(planted);
  Evidence evidence = report.evidence;
  EXPECT_TRUE(has(make_report(planted.study, evidence, Rule::kPaper, {}).warnings.at(0), "is missing"));
  evidence.material.finished.front().digests.selection = std::string(64, '0');
  const ReportSources sources{planted.selection, std::nullopt, std::nullopt};
  EXPECT_TRUE(
      has(make_report(planted.study, evidence, Rule::kPaper, sources).warnings.at(0), "a selection other"));
}

TEST(Report, warns_of_placeholder_windows) {
  const PlantedStudy planted = make_planted_study("pocket", 12, 14, 1, 0.02);
  const Evidence evidence{
      SubjectKind::kPerson, make_evidence(planted, Experiment::kArtifact, SubjectKind::kPerson, 0), {}};
  Windows windows = load_windows(planted.study.windows_path, planted.study);
  const auto warnings = [&] {
    return make_report(planted.study, evidence, Rule::kPaper, {std::nullopt, windows, std::nullopt}).warnings;
  };
  EXPECT_TRUE(warnings().empty()) << "the study's own were chosen by eye";
  for (auto& [column, window] : windows.by_column) window.origin = WindowOrigin::kPlaceholder;
  ASSERT_EQ(warnings().size(), 1U);
  EXPECT_TRUE(has(warnings().front(), "8 of 8 columns are placeholders"));
}

TEST(Report, before_the_material_experiment_shows_columns_as_not_tested) {
  const PlantedStudy planted = make_planted_study("pocket", 12, 14, 1, 0.02);
  const Evidence evidence{
      SubjectKind::kPlanted, make_evidence(planted, Experiment::kArtifact, SubjectKind::kPlanted, 12), {}};
  const Report report = make_report(planted.study, evidence, Rule::kPaper, {planted.selection, {}, {}});
  EXPECT_TRUE(has(format_page({report}), "8 are not tested to the end."));
  EXPECT_TRUE(report.warnings.empty());
}

TEST(Report, shows_error_against_run_time_where_it_was_measured) {
  const PlantedStudy planted = make_planted_study("pocket", 12, 14, 1, 0.02);
  Report report = make_planted_report(planted);
  EXPECT_FALSE(has(format_page({report}), "Error against run time"));
  Convergence convergence;
  convergence.condition = "G0-MS-ind-1k-C4-v0";
  convergence.reference = "path tracing, <9> paths";
  ConvergencePoint slow{"path tracing", "64 paths a pixel", 0, 0, {}, 64, 0, {{"paths", 8}}, {}, {}};
  slow.error.relative_rms = .02;
  ConvergencePoint fast = slow;
  fast.wall_s["paths"] = 2;
  fast.error.relative_rms = .01;
  fast.setting = "faster & better";
  convergence.points = {slow, fast};
  convergence.advice = {{10, 1}};
  convergence.left_out = {"lightcuts at <5M>: no memory"};
  report.convergences = {{convergence, "<svg>'plot'</svg>"}};
  const std::string page = format_page({report});
  EXPECT_TRUE(has(page, "<h2>Error against run time</h2>"));
  EXPECT_TRUE(has(
      page, "the nearest to the truth is path tracing at faster &amp; better: 1.00 ± 0.00 % rms, in 2.0 s."));
  EXPECT_TRUE(has(page, "<li>lightcuts at &lt;5M&gt;: no memory</li>"));
  EXPECT_FALSE(has(page, "64 paths a pixel")) << "a setting that is slower and worse";
  EXPECT_TRUE(has(page, "path tracing, &lt;9&gt; paths"));
  EXPECT_TRUE(has(page, "data:image/svg+xml,%3Csvg%3E%27plot%27%3C%2Fsvg%3E"));
  EXPECT_FALSE(has(page, "<svg>'plot'"));
}

TEST(Report, says_whether_the_references_met_their_noise_target) {
  const PlantedStudy planted = make_planted_study("pocket", 12, 14, 1, 0.02);
  Report report = make_planted_report(planted);
  report.manifest = Manifest{};
  Json error;
  error.set("object_mean", 2.5).set("object_p99", 9.25).set("outside_mean", 1.0);
  report.manifest->pictures["G0-MS-ind-ref-v0"] = {"pictures/x.png", "", "", error};
  const std::string page = format_page({report});
  EXPECT_TRUE(has(page, "Noise of the references"));
  EXPECT_TRUE(has(page, "<span class=\"missed\">MISSED</span></td><td class=\"number\">9.25"));
  EXPECT_TRUE(has(page, "<span class=\"met\">MET</span></td><td class=\"number\">2.50"));
}

// z of 3 and -4 of the object, and of 5 of its room: root mean square 4.08.
TEST(Report, says_how_references_by_vpl_sets_agree_with_path_tracing) {
  Report report = make_planted_report(make_planted_study("pocket", 12, 14, 1, 0.02));
  report.manifest = Manifest{};
  Json error, reference, check{Json::Array{}}, row;
  error.set("object_mean", 0.5).set("object_p99", 1.25).set("outside_mean", 1.0);
  report.manifest->pictures["G0-MS-ind-ref-v0"] = {"pictures/x.png", "", "", error};
  EXPECT_FALSE(has(format_page({report}), "independent VPL sets"));
  check.push(row.set("region", "r1c2").set("z", 3.0));
  check.push(row.set("region", "silhouettes").set("z", -4.0));
  Json room, room_check{Json::Array{}};
  room_check.push(row.set("region", "r3c3").set("z", 5.0));
  room.set("method", "compensated").set("check", std::move(room_check));
  reference.set("method", "compensated").set("check", std::move(check)).set("room", std::move(room));
  report.manifest->pictures["G0-MS-ind-ref-v0"].reference = std::move(reference);
  const std::string page = format_page({report});
  EXPECT_TRUE(has(
      page,
      "In 1 of them indirect light, of the object, the room or both, is the mean of independent VPL sets"));
  EXPECT_TRUE(has(page, "over 3 regions the differences are 4.08 standard errors"));
  EXPECT_TRUE(has(page, "at most 5.0 (G0-MS-ind-ref-v0, room, r3c3)"));
}

// G0-GS-ind-100k is planted green from C4 to C7; of its material levels C6 and C8 are neighbours.
TEST(Report, names_the_levels_to_use_and_their_clamps) {
  const Report report = make_planted_report(make_planted_study("pocket", 200, 200, 1, 0));
  const std::string page = format_page({report});
  EXPECT_TRUE(has(page, "G0-GS-ind-100k</td><td>+</td><td>C4 C5 C6 (c 10 to 1), supported: C4</td>"))
      << page.substr(page.find("G0-GS-ind-100k</td><td>+"), 200);
  EXPECT_TRUE(has(page, "G0-MS-ind-1k</td><td>&minus;</td><td>&ndash;</td>"));
}

TEST(Report, has_no_table_with_a_column_that_is_not_named) {
  Report report = make_planted_report(make_planted_study("pocket", 12, 14, 1, 0.02));
  std::string page = format_page({report});
  EXPECT_FALSE(has(page, "<th class=\"number\"></th>"));
  for (const char* corner : {"<thead><tr><th></th><th>artifact experiment", "<thead><tr><th></th><th>MS"}) {
    for (std::size_t at; (at = page.find(corner)) != std::string::npos;) page.erase(at, 20);
  }
  EXPECT_FALSE(has(page, "<th></th>")) << page.substr(page.find("<th></th>"), 200);
}

TEST(Report, explains_what_its_tables_abbreviate) {
  const std::string page = format_page({make_planted_report(make_planted_study("pocket", 12, 14, 1, 0.02))});
  for (const char* told :
       {"EE, equivalence exists", "two-sided, 95&nbsp;%, of the proportion correct",
        "one half, one-sided, exact", "Benjamini and Hochberg, over the tested cells", "Beta(1/2, 1/2)",
        "the least that the session&rsquo;s protocol", "if and only if most of the others were"})
    EXPECT_TRUE(has(page, told)) << told;
}

// The figures of the table in docs/analysis.md, which a test of coverage holds.
TEST(Report, says_where_its_ranges_hold_less_than_they_say) {
  const PlantedStudy planted = make_planted_study("pocket", 12, 14, 1, 0.02);
  const std::string docs = load_text(std::string(EQUILUX_SOURCE_DIR) + "/docs/analysis.md");
  const std::string page = format_page({make_planted_report(planted)});
  const std::string cut = find_entry("thresholds.csv", "cut_lower").meaning,
                    trend = find_entry("trends.csv", "lower").meaning;
  for (const auto& [share, percent] : {std::pair("| 0.800 | 0.800 |", "80.0"),
                                       {"| 0.847 | 0.847 |", "84.7"},
                                       {"| 0.800 | 0.913 |", "91.3"}}) {
    EXPECT_TRUE(has(docs, share)) << share;
    EXPECT_TRUE(has(page, std::string(percent) + "&nbsp;%")) << percent;
    EXPECT_TRUE(has(cut, percent) || has(trend, percent)) << percent;
  }
}

TEST(Report, claims_no_more_than_was_shown) {
  const PlantedStudy planted = make_planted_study("pocket", 12, 14, 1, 0.02);
  const std::string page = format_page({make_planted_report(planted)});
  EXPECT_FALSE(has(page, "visually equivalent"));
  EXPECT_TRUE(has(page, "some clamp level is not shown to be different from the reference in "));
  EXPECT_TRUE(has(page, "No allowance is made for two experiments, several levels or columns"));
  EXPECT_TRUE(has(page, "Only levels free of artifacts, by the rule <i>paper</i>"));
  EXPECT_TRUE(has(page, "the rules agree on every cut"));
  const Evidence evidence{
      SubjectKind::kPlanted, make_evidence(planted, Experiment::kArtifact, SubjectKind::kPlanted, 12), {}};
  const std::string half =
      format_page({make_report(planted.study, evidence, Rule::kPaper, {planted.selection, {}, {}})});
  for (const char* claim :
       {"Only levels free of artifacts", "the rules agree on every cut", "find the same equivalent levels"})
    EXPECT_FALSE(has(half, claim)) << claim;
  EXPECT_TRUE(has(half, "the rules agree on every artifact cut"));
}

// Two trends of four pairs each, of four objects along VPL counts and of two (a material each) along
// geometries: at best 2 / 2^4 and 2 / 2^2, the first twice that by Holm.
TEST(Report, says_which_trends_no_answers_could_show) {
  const Report report = make_planted_report(make_planted_study("pocket", 12, 14, 1, 0.02));
  ASSERT_EQ(report.trends.size(), 2U);
  EXPECT_EQ(report.trends[0].p_least, 0.125);
  EXPECT_EQ(report.trends[1].p_least, 0.5);
  const std::string page = format_page({report});
  EXPECT_TRUE(has(page, "2 of the 2 trends that are asked for could not be shown whatever the answers"));
  EXPECT_TRUE(has(page, "<td class=\"number\">0.2500</td></tr>"));
  EXPECT_TRUE(has(page, "<td class=\"number\">0.5000</td></tr>"));
  EXPECT_FALSE(has(format_page({make_planted_report(make_planted_study("paper", 12, 14, 1, 0.02))}),
                   "could not be shown"));
}

TEST(Report, gives_the_certainty_under_both_rules_side_by_side) {
  const Report report = make_planted_report(make_planted_study("pocket", 12, 14, 1, 0.02));
  const std::string page = format_page({report});
  EXPECT_TRUE(has(page, "How sure a verdict is can depend on the rule; here it does in "));
  for (std::size_t c = 0; c < report.findings.size(); ++c) {
    const auto share = [&](Rule rule) {
      return fmt::format("<td>{:.2f}</td><td>{:.2f}</td>",
                         *report.uncertainty.columns[c].under(rule).posterior,
                         *report.uncertainty.columns[c].under(rule).bootstrap);
    };
    const auto row =
        page.find("<tr><td>" + format_key(report.findings[c].column), page.find("How sure a verdict"));
    const std::string text = page.substr(row, page.find("</tr>", row) - row);
    EXPECT_TRUE(has(text, share(Rule::kPaper)) && has(text, share(Rule::kIsotonic))) << text;
  }
}

// Cut at 9 of 12 and 11 of 14; study.md has both probabilities.
TEST(Report, says_how_many_cells_guessing_alone_would_flag) {
  const std::string page = format_page({make_planted_report(make_planted_study("pocket", 12, 14, 1, 0.02))});
  const auto row = [](const char* experiment, int n, int cells, int k, double p) {
    return fmt::format(
        "<tr><td>{}</td><td class=\"number\">{}</td><td class=\"number\">{}</td><td class=\"number\">{}</td>"
        "<td class=\"number\">{:.4f}</td><td class=\"number\">{:.1f}</td>",
        experiment, n, cells, k, p, p * cells);
  };
  EXPECT_TRUE(has(page, row("artifact", 12, 32, 9, 299. / 4096)));
  EXPECT_TRUE(has(page, "<tr><td>material</td><td class=\"number\">14</td>"));
  EXPECT_TRUE(has(page, fmt::format("{:.4f}", 470. / 16384)));
  EXPECT_TRUE(has(page, "no verdict rests on q"));
  EXPECT_TRUE(has(page, "half its mass below one half"));
}

TEST(Report, has_planted_thresholds_beside_those_found_if_they_are_the_sessions) {
  const PlantedStudy planted = make_planted_study("pocket", 200, 200, 1, 0);
  Evidence evidence{SubjectKind::kPlanted,
                    make_evidence(planted, Experiment::kArtifact, SubjectKind::kPlanted, 200),
                    make_evidence(planted, Experiment::kMaterial, SubjectKind::kPlanted, 200)};
  ReportSources sources{planted.selection, std::nullopt, std::nullopt};
  const auto page = [&] {
    return format_page({make_report(planted.study, evidence, Rule::kPaper, sources)});
  };
  EXPECT_FALSE(has(page(), "What was planted"));
  sources.truth = planted.truth;
  EXPECT_TRUE(has(page(), "nothing is compared"));
  for (ExperimentEvidence* experiment : {&evidence.artifact, &evidence.material}) {
    for (SessionRow& row : experiment->finished) row.digests.truth = planted.truth.digest;
  }
  const std::string compared = page();
  EXPECT_TRUE(has(compared, "Artifact cuts: 8 of 8 as perfect answers would give them, 8 within"));
  EXPECT_TRUE(has(compared, "8 within one level. EE: 8 of 8 as planted"));
  EXPECT_TRUE(has(compared, "<tr><td>G0-MS-ind-1k</td><td>C10</td><td>C10</td>"));
}

// What stands in a log or a selection is text, whatever it looks like.
TEST(Report, runs_nothing_that_a_log_or_a_selection_brings) {
  const std::string script = "<script>alert(1)</script>";
  Report report = make_planted_report(make_planted_study("pocket", 12, 14, 1, 0.02));
  for (ExperimentEvidence* experiment : {&report.evidence.artifact, &report.evidence.material}) {
    for (SessionRow& row : experiment->finished) {
      row.program_version = row.participant = script;
      for (std::string SessionDigests::*digest :
           {&SessionDigests::manifest, &SessionDigests::windows, &SessionDigests::selection,
            &SessionDigests::protocol, &SessionDigests::truth})
        row.digests.*digest = script;
    }
  }
  for (SubjectsReport* subjects : {&report.artifact_subjects, &report.material_subjects}) {
    for (SubjectFinding& finding : subjects->sessions) {
      finding.summary.participant = finding.summary.folder = script;
      finding.summary.complete = false;
      finding.summary.abort_reason = script;
    }
  }
  report.selection->rule = report.selection->answers_digest = script;
  report.warnings = {script};
  report.folders = {script};
  report.study.description = script;
  std::string page = format_page({report});
  report.selections = {{script, script, script, script}};
  page += format_page({report});
  EXPECT_FALSE(has(page, "<script"));
  EXPECT_TRUE(has(page, "<dt>artifact sessions: program</dt><dd>&lt;script"));
}

TEST(Report, traces_noise_and_order_effects_too) {
  const Report report = make_planted_report(make_planted_study("pocket", 12, 14, 1, 0.02));
  const std::string page = format_page({report});
  for (const char* told :
       {"<code>analysis/order/flips</code>", "<code>analysis/order/bootstrap</code>",
        "<td>noise of the references</td><td>manifest.json</td>", "<dt>order effects</dt>"})
    EXPECT_TRUE(has(page, told)) << told;
  const std::string json = make_report_files({report}).at("report.json");
  EXPECT_TRUE(has(json, "\"order_draws\": 10000") && has(json, "\"analysis/order/bootstrap\""));
}

TEST(Report, lists_columns_whose_flags_go_back_and_forth) {
  PlantedStudy planted = make_planted_study("pocket", 12, 14, 3, 0.0);
  EXPECT_FALSE(has(format_page({make_planted_report(planted)}), "so that the rule decides"));
  for (AnswerRow& row : planted.artifact) {
    if (format_key(row.cell) == "G0-MS-ind-1k-C7") row.correct = row.subject_index < 6;
  }
  const std::string page = format_page({make_planted_report(planted)});
  EXPECT_TRUE(has(page, "so that the rule decides"));
  EXPECT_TRUE(has(page, "G0-MS-ind-1k</td><td>artifact"));
}

}  // namespace
}  // namespace equilux::tests
