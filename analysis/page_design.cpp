// The page's design: what the levels are, how a trial and a session went, and who took part before what
// screens.
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <set>

#include "analysis/markup.h"
#include "analysis/page_sections.h"
#include "analysis/participation.h"
#include "analysis/tables.h"
#include "analysis/words.h"

namespace equilux {
namespace {

constexpr const char* kOwnScene = "cafe.json";  ///< of which these notes speak; a test holds them to it

struct LevelNote {
  const char* token;
  const char* words;
};

constexpr LevelNote kGeometryNotes[] = {
    {"G0", "sphere"},
    {"G1", "spherical blob, the first of three steps of bumpiness that are about equal to the eye"},
    {"G2", "spherical blob, the second of three steps of bumpiness"},
    {"G3", "spherical blob, the last of three steps of bumpiness"},
    {"Bunny", "scan, Stanford"},
    {"Dragon", "scan, Stanford"}};

constexpr LevelNote kMaterialWords[] = {
    {"MS", "dark, strong gloss, smooth"}, {"MR", "dark, strong gloss, rough"},
    {"BS", "dark, weak gloss, smooth"},   {"BR", "dark, weak gloss, rough"},
    {"GS", "grey, weak gloss, smooth"},   {"LG", "grey, Lambertian"}};

template <std::size_t N>
std::string find_note(const LevelNote (&notes)[N], const std::string& token) {
  const auto found = std::find_if(std::begin(notes), std::end(notes),
                                  [&](const LevelNote& note) { return token == note.token; });
  return found == std::end(notes) ? "" : found->words;
}

bool has_own_scene(const Study& study) { return study.scene_path.filename() == kOwnScene; }

std::string describe_geometry(const Study& study, const std::string& token) {
  const std::string words = has_own_scene(study) ? find_note(kGeometryNotes, token) : "";
  return words.empty() ? "as the scene file says" : words;
}

std::string describe_material(const Study& study, const std::string& token) {
  const auto& own = own_scene_materials();
  const auto found =
      std::find_if(own.begin(), own.end(), [&](const auto& known) { return token == known.token; });
  if (!has_own_scene(study) || found == own.end()) return "as the scene file says";
  const std::string words = find_note(kMaterialWords, token);
  if (found->roughness_alpha == 0) return fmt::format("{}: &rho;<sub>d</sub> {:g}", words, found->rho_d);
  return fmt::format("{}: Ward-D&uuml;r, &rho;<sub>d</sub> {:g}, &rho;<sub>s</sub> {:g}, &alpha; {:g}", words,
                     found->rho_d, found->rho_s, found->roughness_alpha);
}

std::string describe_light(const Study& study, Illumination illumination) {
  if (!has_own_scene(study))
    return illumination == Illumination::kIndirect
               ? "the lights that the scene has on for indirect light alone"
               : "all lights of the scene";
  return illumination == Illumination::kIndirect
             ? "the object is lit by what the room reflects: every lamp faces away from it"
             : "the same, and an area fixture that lights the object";
}

std::string list_clamps(const Study& study) {
  std::vector<std::string> levels;
  for (const int level : study.clamp_levels)
    levels.push_back(fmt::format("{} {}", format_clamp(level), format_clamp_value(level)));
  return fmt::format("{}", fmt::join(levels, ", "));
}

Table list_levels(const Study& study) {
  Table table{{"factor", "level", "what it is"}, {}};
  std::string last;  // named once, in its first row
  const auto add = [&](const std::string& factor, const std::string& level, const std::string& words) {
    table.rows.push_back({factor == last ? "" : factor, escape_xml(level), words});
    last = factor;
  };
  for (const auto& geometry : enumerate_geometries(study))
    add("geometry", geometry, describe_geometry(study, geometry));
  for (const auto& material : enumerate_materials(study))
    add("material", material, describe_material(study, material));
  for (const Illumination illumination : enumerate_illuminations(study))
    add("illumination", describe_illumination(illumination), describe_light(study, illumination));
  std::set<std::int64_t> counts;
  for (const Column& column : enumerate_columns(study)) counts.insert(column.vpl_count);
  std::vector<std::string> names;
  for (const std::int64_t count : counts) names.push_back(format_vpl_count(count));
  add("VPL count", fmt::format("{}", fmt::join(names, ", ")),
      "virtual point lights of the room's indirect light");
  add("clamp level",
      fmt::format("{} to {}", format_clamp(study.clamp_levels.front()),
                  format_clamp(study.clamp_levels.back())),
      "least to most clamped; c, the most that BRDF &times; cosine at the VPL / distance&sup2; may be, in "
      "1/m&sup2;: " +
          list_clamps(study));
  add("view", "v0, v1", "two cameras, 15&deg; apart about the vertical through the object; counted together");
  return table;
}

std::string describe_scene(const Study& study) {
  const std::string scene = escape_xml(study.scene_path.filename().string());
  const std::string pictures = fmt::format(
      "Pictures of {} &times; {} pixels, 8-bit sRGB. Tone mapping: the {} operator of Reinhard et al. "
      "(2002), key "
      "{:g}, one curve for each object and view, from its reference, over {}.",
      study.width, study.height, study.tone.operation == ToneOperator::kGlobal ? "global" : "local",
      study.tone.key,
      study.tone.exposure == Exposure::kBackground ? "the pixels outside the object" : "all pixels");
  if (!has_own_scene(study)) {
    return fmt::format(
        "<p class=\"note\">{} Shapes and materials are those of the scene file <code>{}</code>, of which the "
        "study folder holds no copy.</p>\n",
        pictures, scene);
  }
  return fmt::format(
      "<p class=\"note\">{} Shapes and materials as in the scene <code>{}</code> that comes with the program "
      "and that the study names: the study folder holds no copy of it, so a scene edited before rendering "
      "would not show here (<code>made_from</code> in <code>layers.json</code> would differ). "
      "&rho;<sub>d</sub>, "
      "&rho;<sub>s</sub>: diffuse and specular reflectance, equal in all channels; &alpha;: roughness.</p>\n",
      pictures, scene);
}

// "1", or "1 to 4"
template <typename T>
std::string format_span(const std::set<T>& values) {
  if (values.empty()) return kDash;
  if (values.size() == 1) return fmt::format("{}", *values.begin());
  return fmt::format("{} to {}", *values.begin(), *values.rbegin());
}

std::string describe_artifact_pictures(const Study& study) {
  std::set<std::size_t> materials;
  for (const Object& object : enumerate_objects(study))
    materials.insert(enumerate_reference_materials(study, object).size());
  return fmt::format(
      "two side by side: a VPL picture and a reference of the same geometry and illumination, but of another "
      "material (of {} {}, evenly over subjects) and seen from the other view",
      format_span(materials), materials == std::set<std::size_t>{1} ? "other" : "others");
}

std::string describe_material_pictures(const Study& study) {
  return fmt::format(
      "three of the same geometry, material and illumination: a reference above, a VPL picture and a "
      "reference below; {}",
      study.view_mode == ViewMode::kReferenceTurned
          ? "the upper one from one view, both lower ones from the other"
          : "the lower reference from one view, the upper one and the VPL picture from the other");
}

std::string format_prompt(const std::string& prompt) { return "&ldquo;" + escape_xml(prompt) + "&rdquo;"; }

// The question in each language that sessions recorded; where none did, the one that is built in.
std::string describe_question(const Report& report, Experiment experiment) {
  const Prompts& prompts =
      experiment == Experiment::kArtifact ? report.artifact_prompts : report.material_prompts;
  std::vector<std::string> parts;
  for (const auto& [language, sessions] : count_languages(report.evidence.of(experiment))) {
    if (language.empty()) continue;
    const auto found = prompts.find(language);
    if (found == prompts.end() || found->second.empty()) {
      parts.push_back(fmt::format("in {}: the texts are not at hand", escape_xml(language)));
      continue;
    }
    for (const std::string& prompt : found->second)
      parts.push_back(fmt::format("{} ({})", format_prompt(prompt), escape_xml(language)));
  }
  return parts.empty() ? format_prompt(prompt_of(experiment)) : fmt::format("{}", fmt::join(parts, "; "));
}

// A token as words.
std::string format_words(std::string token) {
  std::replace(token.begin(), token.end(), '_', ' ');
  return token;
}

std::string describe_windows(const Report& report) {
  std::string text = fmt::format("{} adjacent clamp levels in each column", kWindowLevels);
  if (!report.windows) return text;
  std::map<std::string, std::size_t> origins;
  for (const auto& [column, window] : report.windows->by_column) ++origins[format_origin(window.origin)];
  std::vector<std::string> parts;
  for (const auto& [origin, columns] : origins)
    parts.push_back(fmt::format("{} {}", format_words(origin), columns));
  return fmt::format("{}, chosen before (columns by origin of the choice: {})", text, fmt::join(parts, ", "));
}

}  // namespace

std::string describe_selection_rule(const Selection& selection) {
  if (selection.rule.empty()) return "by the rule of each folder";
  return fmt::format("by the rule <i>{}</i>", escape_xml(selection.rule));
}

namespace {

std::string describe_selection(const Report& report) {
  if (!report.selection) return kDash;
  std::size_t levels = 0, columns = 0;
  for (const SelectedColumn& column : report.selection->columns) {
    levels += column.levels.size();
    columns += column.levels.empty() ? 0 : 1;
  }
  return fmt::format(
      "of the levels free of artifacts {} the first, every second and the last: {} in {} of {}",
      describe_selection_rule(*report.selection), format_count(levels, "level"), columns,
      format_count(report.selection->columns.size(), "column"));
}

std::string format_trials(const ExperimentEvidence& evidence) {
  std::set<std::int64_t> scheduled;
  for (const SessionSummary& summary : evidence.summaries) {
    if (summary.complete) scheduled.insert(summary.scheduled);
  }
  return format_span(scheduled);
}

std::string format_subjects_count(const Report& report, Experiment experiment) {
  const auto planned = report.study.subjects.find(format_experiment(experiment));
  const std::size_t finished = report.evidence.of(experiment).finished.size();
  if (planned == report.study.subjects.end()) return fmt::format("{}", finished);
  return fmt::format("{} planned, {}", planned->second, format_count(finished, "finished session"));
}

std::vector<std::string> describe_familiarisation(const SessionProtocol& protocol) {
  std::vector<std::string> parts;
  if (protocol.shows_objects) parts.push_back("all objects");
  if (protocol.examples > 0) parts.push_back(format_count(protocol.examples, "labelled example"));
  if (protocol.practice_trials > 0)
    parts.push_back(format_count(protocol.practice_trials, "practice trial") + " with feedback");
  return parts;
}

std::string describe_breaks(const SessionProtocol& protocol) {
  std::vector<std::string> parts;
  if (protocol.break_every_trials) parts.push_back(format_count(*protocol.break_every_trials, "trial"));
  if (protocol.break_every_minutes)
    parts.push_back(fmt::format("{:g} {}", *protocol.break_every_minutes,
                                choose_form(*protocol.break_every_minutes, "minute", "minutes")));
  return parts.empty() ? "no breaks" : fmt::format("a break after every {}", fmt::join(parts, " or "));
}

std::string describe_questions(const SessionProtocol& protocol) {
  std::vector<std::string> asked;
  for (const AskedQuestion& question : protocol.questions)
    asked.push_back(fmt::format("{} ({})", format_words(format_question(question.question)),
                                question.required ? "required" : "optional"));
  return asked.empty() ? "nothing was asked" : fmt::format("asked: {}", fmt::join(asked, ", "));
}

std::string describe_protocol(const SessionProtocol& protocol) {
  std::vector<std::string> parts{describe_questions(protocol)};
  const auto familiarisation = describe_familiarisation(protocol);
  if (!familiarisation.empty()) parts.push_back(fmt::format("before: {}", fmt::join(familiarisation, ", ")));
  parts.push_back(describe_breaks(protocol));
  if (protocol.catch_trials)
    parts.push_back(
        fmt::format("{} of an obvious difference, spread over the session, of which {} "
                    "should be right; not counted",
                    format_count(protocol.catch_trials->count, "catch trial"), protocol.catch_trials->pass));
  if (protocol.least_response_ms > 0)
    parts.push_back(
        fmt::format("answers in less than {} ms are kept, counted and marked", protocol.least_response_ms));
  parts.push_back(
      !protocol.may_resume ? "an interrupted session does not go on"
      : protocol.resume_within_hours
          ? fmt::format("an interrupted session may go on within {:g} hours", *protocol.resume_within_hours)
          : "an interrupted session may go on");
  return fmt::format("{}", fmt::join(parts, "; "));
}

// Of both experiments' finished sessions, those that followed the folder's session.json. The consent text is
// no part of its digest: which of its versions a person agreed to stands with the session.
std::string format_protocol(const Report& report) {
  if (!report.protocol)
    return "<p>How sessions went is not known here: there is no <code>session.json</code>, or folders have "
           "different ones.</p>\n";
  std::size_t all = 0, followed = 0, unknown = 0;
  for (const ExperimentEvidence* evidence : {&report.evidence.artifact, &report.evidence.material}) {
    for (const SessionRow& row : evidence->finished) {
      ++all;
      followed += row.digests.protocol == report.protocol->digest ? 1 : 0;
      unknown += row.digests.protocol.empty() ? 1 : 0;
    }
  }
  return fmt::format(
      "<p>A session, by <code>session.json</code>, which {} of {} followed{}: {}.{}</p>\n", followed,
      format_count(all, "finished session"),
      unknown == 0 ? "" : fmt::format(" (of {} it is not recorded)", unknown),
      describe_protocol(*report.protocol),
      report.evidence.kind == SubjectKind::kPerson
          ? ""
          : " Of this, simulated subjects have the trials alone: consent, questions, examples and breaks are "
            "for persons.");
}

// "normal 10, corrected 3, not recorded 1"
std::string format_value_counts(const std::map<std::string, std::size_t>& values) {
  std::vector<std::string> parts;
  for (const auto& [value, sessions] : values) {
    if (!value.empty()) parts.push_back(fmt::format("{} {}", escape_xml(value), sessions));
  }
  if (const auto none = values.find(""); none != values.end())
    parts.push_back(fmt::format("not recorded {}", none->second));
  return parts.empty() ? kDash : fmt::format("{}", fmt::join(parts, ", "));
}

struct FactRow {
  const char* name;
  const char* words;
};

constexpr FactRow kCountRows[] = {{"language", "language of the texts"},
                                  {"consent_version", "consent text, version"},
                                  {"age_band", "age band"},
                                  {"acuity", "acuity, as told"},
                                  {"colour_vision", "colour vision, as told"},
                                  {"ambient_light", "ambient light, as told"},
                                  {"monitor", "monitor"},
                                  {"video_mode", "video mode"},
                                  {"framebuffer", "window, pixels"},
                                  {"content_scale", "scaling by the system"},
                                  {"pixel_pitch_source", "size of a pixel, source"},
                                  {"viewing_distance_source", "viewing distance, source"}};

constexpr FactRow kRangeRows[] = {{"viewing_distance_m", "viewing distance, m"},
                                  {"degrees_wide", "width of a picture, degrees"},
                                  {"degrees_high", "height of a picture, degrees"},
                                  {"pixel_pitch_x_mm", "width of a pixel, mm"},
                                  {"refresh_hz_measured", "refresh rate, measured, Hz"}};

std::string format_days(const Participation& participation) {
  if (participation.first_day.empty()) return kDash;
  if (participation.first_day == participation.last_day) return escape_xml(participation.first_day);
  return escape_xml(participation.first_day + " to " + participation.last_day);
}

bool is_recorded(const Participation& participation, const char* name) {
  const auto found = participation.counts.find(name);
  return found != participation.counts.end() &&
         std::any_of(found->second.begin(), found->second.end(),
                     [](const auto& value) { return !value.first.empty(); });
}

std::string format_value_range(const Participation& participation, const char* name) {
  const auto found = participation.ranges.find(name);
  if (found == participation.ranges.end()) return "not recorded";
  const ValueRange& range = found->second;
  const std::string values = range.least == range.greatest
                                 ? fmt::format("{:.4g}", range.least)
                                 : fmt::format("{:.4g} to {:.4g}", range.least, range.greatest);
  return range.sessions == participation.sessions
             ? values
             : fmt::format("{} ({})", values, format_count(range.sessions, "session"));
}

std::string target_of(const Study& study, const std::string& name) {
  if (name == "viewing_distance_m") return fmt::format(" (target {:.4g})", study.viewing_distance_m);
  if (name == "degrees_wide") return fmt::format(" (target {:.4g})", study.target_degrees_wide);
  if (name == "degrees_high") return fmt::format(" (target {:.4g})", study.target_degrees_high);
  return "";
}

// One column for each experiment that has finished sessions.
Table list_facts(const Report& report, const std::vector<Participation>& all) {
  Table table{{"finished sessions"}, {}};
  for (const Experiment experiment : {Experiment::kArtifact, Experiment::kMaterial})
    table.columns.push_back(format_experiment(experiment));
  const auto add = [&](const std::string& words, const auto& text_of) {
    table.rows.push_back({words});
    for (const Participation& one : all)
      table.rows.back().push_back(one.sessions == 0 ? kDash : text_of(one));
  };
  add("dates, UTC", format_days);
  for (const FactRow& row : kCountRows) {
    if (std::none_of(all.begin(), all.end(), [&](const auto& one) { return is_recorded(one, row.name); }))
      continue;
    add(row.words, [&](const Participation& one) -> std::string {
      const auto found = one.counts.find(row.name);
      return found == one.counts.end() ? "too few sessions to tell" : format_value_counts(found->second);
    });
  }
  for (const FactRow& row : kRangeRows) {
    if (std::none_of(all.begin(), all.end(), [&](const auto& one) { return one.ranges.contains(row.name); }))
      continue;
    add(row.words + target_of(report.study, row.name),
        [&](const Participation& one) { return format_value_range(one, row.name); });
  }
  return table;
}

std::string format_spread(const Spread& spread) {
  if (spread.measured == 0) return kDash;
  return fmt::format("{} (of {}){}", spread.largest, spread.measured,
                     spread.over == 0 ? "" : fmt::format(", over one in {}", spread.over));
}

std::vector<std::string> balance_row(const Balance& balance, Experiment experiment) {
  return {format_experiment(experiment), format_spread(balance.sessions), format_spread(balance.cells),
          balance.most_answers == 0 ? kDash : fmt::format("{}", balance.most_answers)};
}

// The rule, and beside it what the trials of counted sessions were like.
std::string format_balance(const Report& report) {
  const Table table{{"largest difference", "in a session", "of a cell over sessions",
                     "most answers of a subject to a cell"},
                    {balance_row(report.artifact_balance, Experiment::kArtifact),
                     balance_row(report.material_balance, Experiment::kMaterial)}};
  return "<p>Forced choice of left or right without a time limit, by rule one answer of a subject to each "
         "picture condition, a cell. Side and view of the VPL picture are balanced together: by rule counts "
         "of the four combinations differ by at most one within a session, and for each cell over subjects "
         "in their order. The order of trials is drawn anew for each session.</p>\n" +
         format_html_table(table, 1) +
         "<p class=\"note\">As measured in finished sessions, of so many sessions and cells. From "
         "<code>test_key</code> and <code>test_side</code> of the main trials; "
         "<code>report.json</code> has it as <code>balance</code>.</p>\n";
}

std::string format_overlap(const Report& report) {
  const std::size_t artifact = count_participants(report.evidence.artifact),
                    material = count_participants(report.evidence.material);
  if (artifact == 0 || material == 0) return "";
  const std::size_t both = count_in_both(report.evidence);
  const std::string subject =
      report.evidence.kind == SubjectKind::kPerson ? "participant" : "simulated subject";
  if (both == 0)
    return fmt::format(
        "<p>No code of the {}s of one experiment is among those of the other: as far as codes tell they "
        "are other people.</p>\n",
        subject);
  return fmt::format(
      "<p>Of the {} of the material experiment {} had a finished session of the artifact experiment ({}) "
      "under "
      "the same code{}.</p>\n",
      format_count(material, subject), both, format_count(artifact, "code"),
      report.evidence.kind == SubjectKind::kPerson
          ? ": where a code is one person, the experiments are not independent samples of people"
          : ", which is only a number: what they answer in one does not depend on the other");
}

}  // namespace

const std::vector<OwnMaterial>& own_scene_materials() {
  static const std::vector<OwnMaterial> materials = {{"MS", .03F, .22F, .05F},  {"MR", .03F, .22F, .15F},
                                                     {"BS", .03F, .033F, .05F}, {"BR", .03F, .033F, .15F},
                                                     {"GS", .19F, .033F, .05F}, {"LG", .19F, 0, 0}};
  return materials;
}

std::string format_clamp_value(int level) {
  const double value = clamp_per_m2(level);
  return std::isinf(value) ? "no clamp" : fmt::format("{:.3g}", value);
}

std::string format_levels_table(const Report& report) {
  return format_html_table(list_levels(report.study), 99) + describe_scene(report.study);
}

std::string format_design(const Report& report) {
  const Study& study = report.study;
  Table table{{"", "artifact experiment", "material experiment"}, {}};
  table.rows = {{"question", describe_question(report, Experiment::kArtifact),
                 describe_question(report, Experiment::kMaterial)},
                {"pictures", describe_artifact_pictures(study), describe_material_pictures(study)},
                {"levels", describe_windows(report), describe_selection(report)},
                {"counted trials a session", format_trials(report.evidence.artifact),
                 format_trials(report.evidence.material)},
                {"subjects", format_subjects_count(report, Experiment::kArtifact),
                 format_subjects_count(report, Experiment::kMaterial)}};
  return format_html_table(table, 99) + format_balance(report) + format_protocol(report);
}

std::string format_participation(const Report& report) {
  const std::vector<Participation> all = {find_participation(report.evidence.artifact),
                                          find_participation(report.evidence.material)};
  std::string text = format_overlap(report);
  if (all[0].sessions + all[1].sessions == 0) return text;
  text += format_html_table(list_facts(report, all), 99);
  if (std::none_of(all.begin(), all.end(), [](const auto& one) { return is_recorded(one, "monitor"); }))
    text +=
        "<p class=\"note\">No screen, viewing distance or size in degrees is recorded with these "
        "sessions.</p>\n";
  return text +
         "<p class=\"note\">Counts are of finished sessions; what persons were asked is told of five and "
         "more. From tables <code>session</code> and "
         "<code>field</code> of the logs; <code>report.json</code> has them as "
         "<code>participation</code>.</p>\n";
}

}  // namespace equilux
