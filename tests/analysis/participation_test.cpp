// Who took part, as counts: ranges and dates right, nothing of one person.
#include "analysis/participation.h"

#include <algorithm>
#include <gtest/gtest.h>

#include "analysis/page_sections.h"
#include "base/files.h"
#include "stimuli/scene.h"
#include "tests/analysis/columns.h"
#include "tests/support/temp_folder.h"

namespace equilux::tests {
namespace {

SessionRow make_person(const std::string& code, const std::string& started, double degrees_wide,
                       const std::map<std::string, std::string>& fields) {
  SessionRow row;
  row.participant = code;
  row.complete = true;
  row.started_utc = started;
  row.screen = {"DELL U2410", 1920, 1200, 0.45, degrees_wide, 12};
  row.fields = fields;
  return row;
}

Evidence make_people() {
  Evidence evidence;
  evidence.artifact.finished = {
      make_person("K7QX3C", "2026-03-02T09:00:00.000Z", 16.2, {{"age_band", "25-34"}, {"acuity", "normal"}}),
      make_person("M4TR9W", "2026-02-27T16:00:00.000Z", 15.5,
                  {{"age_band", "25-34"}, {"acuity", "corrected"}}),
      make_person("P6VN3J", "2026-03-01T11:00:00.000Z", 15.9, {{"refresh_hz_measured", "59.950"}}),
      make_person("Q2XW8H", "2026-03-01T13:00:00.000Z", 15.9, {{"consent_version", "2"}}),
      make_person("T9DK4F", "2026-03-01T15:00:00.000Z", 15.9, {{"consent_version", "1"}})};
  evidence.material.finished = {
      make_person("M4TR9W", "2026-03-05T10:00:00.000Z", 16.0, {{"refresh_hz_measured", "no number"}})};
  return evidence;
}

TEST(Participation, counts_answers_by_value_and_tells_dates_and_ranges) {
  const Participation sum = find_participation(make_people().artifact);
  EXPECT_EQ(sum.sessions, 5U);
  EXPECT_EQ(sum.first_day, "2026-02-27");
  EXPECT_EQ(sum.last_day, "2026-03-02");
  EXPECT_EQ(sum.counts.at("age_band"), (std::map<std::string, std::size_t>{{"", 3}, {"25-34", 2}}));
  EXPECT_EQ(sum.counts.at("consent_version"),
            (std::map<std::string, std::size_t>{{"", 3}, {"1", 1}, {"2", 1}}));
  EXPECT_EQ(sum.counts.at("framebuffer"), (std::map<std::string, std::size_t>{{"1920x1200", 5}}));
  EXPECT_EQ(sum.ranges.at("degrees_wide").least, 15.5);
  EXPECT_EQ(sum.ranges.at("degrees_wide").greatest, 16.2);
  EXPECT_EQ(sum.ranges.at("refresh_hz_measured").sessions, 1U);
}

TEST(Participation, takes_no_measure_from_what_is_no_number) {
  EXPECT_FALSE(find_participation(make_people().material).ranges.contains("refresh_hz_measured"));
  EXPECT_TRUE(find_participation({}).ranges.empty());
}

TEST(Participation, knows_who_sat_in_both_experiments_by_code) {
  Evidence evidence = make_people();
  EXPECT_EQ(count_in_both(evidence), 1U);
  EXPECT_EQ(count_participants(evidence.artifact), 5U);
  evidence.material.finished[0].participant = "R3WM9D";
  EXPECT_EQ(count_in_both(evidence), 0U);
}

// Beside the code of a single session its age band would be that of a person.
TEST(Participation, tells_of_a_few_sessions_nothing_that_persons_were_asked) {
  const Evidence evidence = make_people();
  const Participation few = find_participation(evidence.material);
  for (const char* name : {"age_band", "acuity", "colour_vision"})
    EXPECT_FALSE(few.counts.contains(name)) << name;
  EXPECT_EQ(few.counts.at("monitor").size(), 1U);
  const Report report = make_report(load_protocol("pocket"), evidence, Rule::kPaper, {}, {1, 10, 10});
  EXPECT_NE(format_participation(report).find("too few sessions to tell"), std::string::npos);
}

TEST(Participation, names_nobody) {
  const Evidence evidence = make_people();
  Report report = make_report(load_protocol("pocket"), evidence, Rule::kPaper, {}, {1, 10, 10});
  const std::string page = format_participation(report);
  const std::string json = format_json(make_participation_json(find_participation(evidence.artifact)));
  for (const SessionRow& row : evidence.artifact.finished) {
    EXPECT_EQ(page.find(row.participant), std::string::npos);
    EXPECT_EQ(json.find(row.participant), std::string::npos);
    EXPECT_EQ(json.find(row.started_utc), std::string::npos) << "a day is enough";
  }
  EXPECT_NE(page.find("2026-02-27 to 2026-03-02"), std::string::npos);
  EXPECT_NE(page.find("25-34 2, not recorded 3"), std::string::npos);
  EXPECT_NE(page.find("degrees (target 16)</td><td>15.5 to 16.2"), std::string::npos);
  EXPECT_NE(page.find("not independent samples of people"), std::string::npos);
}

// The page's words about materials stand in for a file that a study folder has no copy of.
TEST(Design, tells_the_materials_as_the_scene_of_the_program_has_them) {
  const Scene scene = load_scene(std::string(EQUILUX_SOURCE_DIR) + "/stimuli/scenes/cafe.json");
  for (const OwnMaterial& own : own_scene_materials()) {
    const MaterialSpec& spec = find_material(scene, own.token);
    EXPECT_EQ(spec.rho_d.x, own.rho_d) << own.token;
    EXPECT_EQ(spec.rho_d.z, own.rho_d) << own.token;
    EXPECT_EQ(spec.rho_s.y, own.rho_s) << own.token;
    EXPECT_EQ(spec.roughness_alpha, own.roughness_alpha) << own.token;
    EXPECT_EQ(spec.model, GlossModel::kWardDuer) << own.token;
  }
  for (const char* geometry : {"G0", "G1", "G2", "G3", "Bunny", "Dragon"})
    EXPECT_TRUE(scene.geometries.contains(geometry)) << geometry;
}

TEST(Design, says_of_another_scene_only_that_the_file_says_it) {
  Report report = make_report(load_protocol("pocket"), {}, Rule::kPaper, {}, {1, 10, 10});
  EXPECT_NE(format_levels_table(report).find("&rho;<sub>s</sub> 0.22, &alpha; 0.05"), std::string::npos);
  report.study.scene_path = "scenes/other.json";
  EXPECT_EQ(format_levels_table(report).find("0.22"), std::string::npos);
  EXPECT_NE(format_levels_table(report).find("<code>other.json</code>"), std::string::npos);
}

TEST(Design, tells_every_clamp_in_numbers) {
  const Report report = make_report(load_protocol("paper"), {}, Rule::kPaper, {}, {1, 10, 10});
  EXPECT_NE(format_levels_table(report).find(
                "C0 no clamp, C1 316, C2 100, C3 31.6, C4 10, C5 3.16, C6 1, C7 0.316, "
                "C8 0.1, C9 0.0316, C10 0.01"),
            std::string::npos);
}

TEST(Participation, counts_languages_and_warns_where_they_differ) {
  Evidence evidence = make_people();
  for (SessionRow& row : evidence.artifact.finished) row.fields["language"] = "en";
  const auto warns = [&] {
    const Report report = make_report(load_protocol("pocket"), evidence, Rule::kPaper, {}, {1, 10, 10});
    return std::any_of(report.warnings.begin(), report.warnings.end(), [](const std::string& warning) {
      return warning.starts_with("The finished sessions were held in 2 languages (de 1, en 5)");
    });
  };
  EXPECT_FALSE(warns());
  evidence.material.finished[0].fields["language"] = "de";
  EXPECT_TRUE(warns());
  const Report report = make_report(load_protocol("pocket"), evidence, Rule::kPaper, {}, {1, 10, 10});
  EXPECT_NE(format_participation(report).find("<td>language of the texts</td><td>en 5</td><td>de 1</td>"),
            std::string::npos);
}

// English is built in, German a file of the folder, French nowhere.
TEST(Design, quotes_the_question_in_each_language_whose_texts_are_there) {
  const TempFolder folder;
  save_text(folder / "texts-de.json",
            R"({"texts": {"prompt_artifact": "W\u00e4hle das Bild mit den Fehlern."}})");
  Evidence evidence = make_people();
  const char* languages[] = {"en", "de", "fr", "../x", ""};
  for (std::size_t i = 0; i < 5; ++i) evidence.artifact.finished[i].fields["language"] = languages[i];
  ReportSources sources;
  sources.artifact_prompts = load_prompts(folder.path(), evidence.artifact, Experiment::kArtifact);
  const std::string design =
      format_design(make_report(load_protocol("pocket"), evidence, Rule::kPaper, sources, {1, 10, 10}));
  for (const char* told : {"&ldquo;Select the image that has the artifacts.&rdquo; (en)",
                           "&ldquo;W\u00e4hle das Bild mit den Fehlern.&rdquo; (de)",
                           "in fr: the texts are not at hand", "in ../x: the texts are not at hand",
                           "&ldquo;Which object&#39;s material is different from the reference?&rdquo;</td>"})
    EXPECT_NE(design.find(told), std::string::npos) << told << "\n" << design;
}

// What stood on the screen counts, whatever became of the texts.
TEST(Design, quotes_the_question_that_a_session_recorded) {
  const TempFolder folder;
  save_text(folder / "texts-de.json", R"({"texts": {"prompt_artifact": "today"}})");
  Evidence evidence = make_people();
  for (SessionRow& row : evidence.artifact.finished)
    row.fields = {{"language", "de"}, {"prompt", "as it was then"}};
  const auto load = [&] { return load_prompts(folder.path(), evidence.artifact, Experiment::kArtifact); };
  EXPECT_EQ(load(), (Prompts{{"de", {"as it was then"}}}));
  evidence.artifact.finished[1].fields["prompt"] = "as it was later";
  EXPECT_EQ(load(), (Prompts{{"de", {"as it was then", "as it was later"}}}));
}

// Some sessions recorded what they read, some did not; which of them sat first changes nothing.
TEST(Design, quotes_the_same_questions_whatever_the_order_of_subjects) {
  const TempFolder folder;
  save_text(folder / "texts-de.json", R"({"texts": {"prompt_artifact": "today"}})");
  Evidence evidence = make_people();
  for (SessionRow& row : evidence.artifact.finished) row.fields = {{"language", "de"}};
  evidence.artifact.finished.front().fields["prompt"] = "as it was then";
  const auto load = [&] { return load_prompts(folder.path(), evidence.artifact, Experiment::kArtifact); };
  const Prompts expected{{"de", {"as it was then", "today"}}};
  EXPECT_EQ(load(), expected);
  std::swap(evidence.artifact.finished.front(), evidence.artifact.finished.back());
  EXPECT_EQ(load(), expected);
}

TEST(Participation, warns_where_sessions_of_one_language_recorded_different_questions) {
  Evidence evidence = make_people();
  const auto find_warning = [&] {
    const Report report = make_report(load_protocol("pocket"), evidence, Rule::kPaper, {}, {1, 10, 10});
    const auto found =
        std::find_if(report.warnings.begin(), report.warnings.end(), [](const std::string& warning) {
          return warning.find("different questions: subjects read different ones") != std::string::npos;
        });
    return found == report.warnings.end() ? "" : *found;
  };
  auto& sessions = evidence.artifact.finished;
  for (SessionRow& row : sessions) row.fields = {{"language", "en"}, {"prompt", "which?"}};
  sessions[0].fields = {{"language", "de"}, {"prompt", "welches?"}};
  sessions[1].fields = {{"language", "en"}};
  EXPECT_EQ(find_warning(), "");
  sessions[2].fields["prompt"] = "which one?";
  EXPECT_EQ(find_warning(),
            "The finished artifact sessions in the language en recorded 2 different questions: subjects read "
            "different ones.");
}

// A log of schema 1 did not say which session.json its sessions followed.
TEST(Design, takes_an_unrecorded_protocol_for_no_other_one) {
  const Study study = load_protocol("pocket");
  ReportSources sources;
  sources.protocol = load_session_protocol(study.session_path);
  Evidence evidence = make_people();
  for (SessionRow& row : evidence.artifact.finished) row.digests.protocol = sources.protocol->digest;
  evidence.artifact.finished[0].digests.protocol = "";
  const auto count_warnings = [&] {
    const Report report = make_report(study, evidence, Rule::kPaper, sources, {1, 10, 10});
    return std::count_if(report.warnings.begin(), report.warnings.end(), [](const std::string& warning) {
      return warning.find("session.json other than") != std::string::npos ||
             warning.find("session protocols") != std::string::npos;
    });
  };
  EXPECT_EQ(count_warnings(), 0);
  const std::string design = format_design(make_report(study, evidence, Rule::kPaper, sources, {1, 10, 10}));
  EXPECT_NE(design.find("which 4 of 6 finished sessions followed (of 2 it is not recorded):"),
            std::string::npos)
      << design;
  evidence.artifact.finished[1].digests.protocol = "another";
  EXPECT_EQ(count_warnings(), 2);
}

TEST(Design, tells_pictures_trials_and_the_sessions_protocol) {
  const Study study = load_protocol("pocket");
  ReportSources sources;
  sources.windows = load_windows(study.windows_path, study);
  sources.protocol = load_session_protocol(study.session_path);
  Evidence evidence = make_people();
  evidence.artifact.finished[0].digests.protocol = sources.protocol->digest;
  SessionSummary summary;
  summary.complete = true;
  summary.scheduled = 32;
  evidence.artifact.summaries = {summary};
  const std::string design = format_design(make_report(study, evidence, Rule::kPaper, sources, {1, 10, 10}));
  for (const char* told :
       {"of another material (of 1 other,", "seen from the other view", "the upper one from one view",
        "4 adjacent clamp levels", "by eye 8", "<td>32</td>", "12 planned, 5 finished",
        "which 1 of 6 finished", "a break after every 20 trials or 10 minutes", "4 catch trials",
        "acuity (required)"})
    EXPECT_NE(design.find(told), std::string::npos) << told << "\n" << design;
}

}  // namespace
}  // namespace equilux::tests
