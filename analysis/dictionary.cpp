// What every column of the report's tables means.
#include "analysis/report_tables.h"
#include "base/error.h"

namespace equilux {
namespace {

constexpr DictionaryEntry kDictionary[] = {
    {"cells.csv thresholds.csv ee.csv subjects.csv order.csv trends.csv answers.csv", "study", "string",
     "name of the study"},
    {"cells.csv thresholds.csv ee.csv subjects.csv order.csv trends.csv answers.csv", "kind", "string",
     "whose answers: person; planted: simulated subjects whose answers were put in, which say nothing of the "
     "pictures; looking: simulated from the pixels"},
    {"cells.csv thresholds.csv subjects.csv order.csv answers.csv", "experiment", "string",
     "artifact: which image has the artifacts; material: which object differs from the reference"},
    {"cells.csv thresholds.csv ee.csv answers.csv", "geometry", "string",
     "shape of the object, by its token"},
    {"cells.csv thresholds.csv ee.csv answers.csv", "material", "string",
     "material of the object, by its token"},
    {"cells.csv thresholds.csv ee.csv answers.csv", "illumination", "string",
     "ind: no light reaches the object directly; dir: an area fixture does too"},
    {"cells.csv thresholds.csv ee.csv answers.csv", "vpls", "integer", "number of virtual point lights"},
    {"cells.csv answers.csv", "clamp", "string",
     "clamp level, least to most clamped: C0 none; Ci: BRDF x cosine at the VPL / distance^2 is at most c = "
     "10^(2.5 - (i - 1) / 2) in 1/m^2, 316 (C1) to 0.01 (C10); with n the picture is luminance-normalised"},
    {"answers.csv", "clamp_level", "integer", "the number in clamp"},
    {"cells.csv", "k", "integer", "subjects who were correct"},
    {"cells.csv", "n", "integer", "subjects who were asked"},
    {"cells.csv", "proportion", "number", "k / n; empty where n is 0"},
    {"cells.csv", "p_guess", "number",
     "probability of k or more of n at one half, exact; empty where n is 0"},
    {"cells.csv", "status", "string",
     "untested: n is 0; single: n is 1; all_wrong: k is 0; all_right: k is n; inner: neither"},
    {"cells.csv", "cp_lower", "number", "lower end of the 95 % interval of Clopper and Pearson"},
    {"cells.csv", "cp_upper", "number", "upper end of it"},
    {"cells.csv", "jeffreys_lower", "number", "lower end of the 95 % interval from Jeffreys' prior"},
    {"cells.csv", "jeffreys_upper", "number", "upper end of it"},
    {"cells.csv", "q_guess", "number",
     "false-discovery rate of Benjamini and Hochberg for p_guess over the tested cells of the experiment"},
    {"cells.csv", "posterior_over", "number",
     "posterior probability, from Jeffreys' prior, that the true proportion is 75 % or more"},
    {"thresholds.csv trends.csv", "rule", "string",
     "paper or isotonic: what decides where a column is not monotone"},
    {"thresholds.csv", "cut", "string",
     "artifact: the least clamped level from which on it is free; material: the most clamped one up to which "
     "it is "
     "unchanged; empty where there is none or where it lies below all tested levels"},
    {"thresholds.csv", "status", "string",
     "cut; censored_low, artifact: none at any tested level, so that the threshold is at the cut or less "
     "clamped; material: a change at every tested level, so that it is less clamped than the first of "
     "tested; "
     "censored_high, artifact: artifacts at the most clamped tested level, so that the threshold is at the "
     "cut, the first level beyond, or more clamped; material: no change up to the most clamped tested level, "
     "so that it is there or more clamped; there is nothing beyond where that is the study's most clamped "
     "one, nor below where the first of tested is its least clamped one; none: artifacts at the most clamped "
     "level, or a change at the least clamped one; untested"},
    {"thresholds.csv", "monotone", "boolean", "whether proportions are monotone over clamp"},
    {"thresholds.csv", "flags_monotone", "boolean", "whether flags are; where false the rule decides"},
    {"thresholds.csv", "tested", "string", "clamp levels with answers"},
    {"thresholds.csv", "untested", "string",
     "levels that the rule keeps for the material experiment, without answers"},
    {"thresholds.csv", "cut_lower", "string",
     "least clamped end of the 95 % range of cuts when subjects are drawn again, empty where they are fewer "
     "than six; none: no level; one that is "
     "more clamped than all that were tested: it or more clamped. Where material cuts lie below all tested "
     "levels the range reaches from none up to the level before them. Holds the truth less often than it "
     "says "
     "where several proportions lie just below the "
     "cut: 80.0 % (artifact), 84.7 % (material) in simulated studies"},
    {"thresholds.csv", "cut_upper", "string",
     "most clamped end of it; none: no level. Holds what cut_lower says"},
    {"ee.csv", "ee_paper", "boolean",
     "whether some clamp level is free of artifacts and of the same material; empty where status is "
     "untested"},
    {"ee.csv", "ee_isotonic", "boolean", "the same under the rule isotonic"},
    {"ee.csv", "status_paper", "string", "exists, none, untested"},
    {"ee.csv", "green_paper", "string", "equivalent levels"},
    {"ee.csv", "supported_paper", "string",
     "equivalent levels at which both experiments are shown, at 95 % one-sided, to lie below 75 %"},
    {"ee.csv", "status_isotonic", "string", "exists, none, untested"},
    {"ee.csv", "green_isotonic", "string", "equivalent levels"},
    {"ee.csv", "supported_isotonic", "string", "as supported_paper"},
    {"ee.csv", "dropped", "boolean", "whether pruning kept no level of this column"},
    {"ee.csv", "uncertainty_paper", "string",
     "estimated; untested: an experiment has no answers here; one_subject: nobody to draw again; "
     "too_few_subjects: fewer than six in an experiment, shares and flips but no range of its cuts; "
     "no_candidates: no "
     "level is free of artifacts, so that EE is false; dropped: pruning by another rule kept no level, "
     "under this one levels are free, and nobody was asked about them: EE is untested"},
    {"ee.csv", "uncertainty_isotonic", "string", "as uncertainty_paper"},
    {"ee.csv", "posterior_paper", "number",
     "posterior probability of EE: each cell's proportion drawn from its posterior, then the rule"},
    {"ee.csv", "posterior_above_half_paper", "number",
     "the same with Jeffreys' prior cut off below one half, where no proportion correct can lie: each cell's "
     "proportion drawn from its posterior on 0.5 to 1"},
    {"ee.csv", "bootstrap_paper", "number", "share of resamples of subjects in which EE is true"},
    {"ee.csv", "flips_paper", "integer",
     "subjects, of both experiments, without any one of whom EE is another; one of both is left out of both"},
    {"ee.csv", "ee70_paper", "string",
     "exists, none or untested with cells flagged at 70 % correct; a dropped column is untested where that "
     "cut would leave it a level"},
    {"ee.csv", "ee80_paper", "string", "the same at 80 %"},
    {"ee.csv", "free_posterior_paper", "number",
     "of a column with no_candidates or dropped: posterior probability, by its artifact answers, that some "
     "level is "
     "free "
     "of artifacts; EE, of which nobody was asked there, is no more probable"},
    {"ee.csv", "free_bootstrap_paper", "number",
     "of such a column: share of resamples of subjects in which some level is free of artifacts"},
    {"ee.csv", "free_flips_paper", "integer",
     "of such a column: subjects without any one of whom some level is free of artifacts if none was, or "
     "none "
     "if one was"},
    {"ee.csv", "free_posterior_isotonic", "number", "as free_posterior_paper"},
    {"ee.csv", "free_bootstrap_isotonic", "number", "as free_bootstrap_paper"},
    {"ee.csv", "free_flips_isotonic", "integer", "as free_flips_paper"},
    {"ee.csv", "posterior_isotonic", "number", "as posterior_paper"},
    {"ee.csv", "posterior_above_half_isotonic", "number", "as posterior_above_half_paper"},
    {"ee.csv", "bootstrap_isotonic", "number", "as bootstrap_paper"},
    {"ee.csv", "flips_isotonic", "integer", "as flips_paper"},
    {"ee.csv", "ee70_isotonic", "string", "as ee70_paper"},
    {"ee.csv", "ee80_isotonic", "string", "as ee80_paper"},
    {"subjects.csv answers.csv", "session", "integer",
     "number of the session: in its log where one log was read, else in the pool of logs"},
    {"subjects.csv answers.csv", "participant", "string", "the experimenter's code"},
    {"subjects.csv", "folder", "string", "study folder of the log; empty where one was read"},
    {"subjects.csv", "subject_index", "integer", "which decides sides, views and materials"},
    {"subjects.csv", "complete", "boolean", "whether the session was finished: only then it counts"},
    {"subjects.csv", "scheduled", "integer", "trials of the main phase"},
    {"subjects.csv", "answered", "integer", "of them answered"},
    {"subjects.csv", "correct", "integer", "of them correct"},
    {"subjects.csv", "left", "integer", "answers that were the left side"},
    {"subjects.csv", "p_side", "number", "two-sided exact binomial p of left at one half"},
    {"subjects.csv", "median_s", "number", "median time from onset to press, in seconds"},
    {"subjects.csv", "too_fast", "integer", "answers in less than the least time of the session's protocol"},
    {"subjects.csv", "catch_correct", "integer", "catch trials that were correct"},
    {"subjects.csv", "catch_answered", "integer", "of so many"},
    {"subjects.csv", "catch_pass", "integer",
     "so many right ones its protocol asks for; empty where that is not known"},
    {"subjects.csv", "agreement", "number",
     "share of cells where the subject was right if and only if most others were; ties left out"},
    {"subjects.csv", "marks", "string",
     "side, fast, catch, disagrees: look twice; the session counts all the same"},
    {"subjects.csv", "abort_reason", "string",
     "why the session was ended early, as the experimenter wrote it; empty otherwise"},
    {"subjects.csv", "language", "string",
     "language of the texts that the subject read, as the session recorded it; empty where it did not"},
    {"subjects.csv", "turns_paper", "string",
     "columns whose verdict is another without this person, in all sessions of both experiments; of a column "
     "with no_candidates, whether some level is free of artifacts. Of a person who has several sessions it "
     "stands at one, of the artifact experiment if there is one"},
    {"subjects.csv", "turns_isotonic", "string", "the same under the rule isotonic"},
    {"order.csv", "subjects", "integer", "persons with a finished session"},
    {"order.csv", "correct", "number",
     "mean over subjects of proportion correct, second half less first half"},
    {"order.csv", "lower", "number", "lower end of its 95 % interval, subjects drawn again"},
    {"order.csv", "upper", "number", "upper end of it"},
    {"order.csv", "p", "number", "two-sided p over sign flips of subjects' differences"},
    {"order.csv", "speed", "number", "geometric mean of median response times, second half by first half"},
    {"trends.csv", "factor", "string", "what differs; everything else is equal"},
    {"trends.csv", "from", "string", "its first level"},
    {"trends.csv", "to", "string", "its last level"},
    {"trends.csv", "status", "string",
     "tested; flat: EE never differs; too_few_subjects: fewer than six, no interval, so that no trend holds; "
     "no_pairs: nothing to compare"},
    {"trends.csv", "strata", "integer", "sets of columns that differ in this factor alone"},
    {"trends.csv", "pairs", "integer", "pairs within them"},
    {"trends.csv", "clusters", "integer",
     "objects that the pairs are of, at all their VPL counts: what p permutes as a whole"},
    {"trends.csv", "gained", "integer", "pairs with EE at the later level only"},
    {"trends.csv", "lost", "integer", "pairs with EE at the earlier level only"},
    {"trends.csv", "effect", "number", "(gained - lost) / pairs"},
    {"trends.csv", "lower", "number",
     "lower end of its 95 % interval: the effect less the farther end when subjects are drawn again. "
     "Holds the truth less often than it says of a trend that turns every verdict and is seen over two "
     "levels: 80.0 % (paper), 91.3 % (isotonic) in simulated studies"},
    {"trends.csv", "upper", "number", "upper end of it; holds what lower says"},
    {"trends.csv", "p", "number",
     "two-sided exact p: EE permuted within strata, that of an object at all its VPL counts together"},
    {"trends.csv", "p_least", "number", "the least p that any verdicts of these columns could give"},
    {"trends.csv", "p_least_holm", "number",
     "p_least after Holm's correction over the trends of the study: the least that p_holm could be were "
     "every "
     "trend as strong as it can be; 1 where nothing is compared"},
    {"trends.csv", "p_holm", "number", "p after Holm's correction over the trends of the study"},
    {"trends.csv", "holds", "boolean", "p_holm is 0.05 or less and the interval leaves out 0"},
    {"trends.csv", "sentence", "string", "the same in words"},
    {"plan.csv", "subjects", "integer", "subjects of the artifact experiment"},
    {"plan.csv", "material_subjects", "integer", "subjects of the material experiment"},
    {"plan.csv", "false_flags", "number", "share of tested cells below 75 % in truth that are flagged"},
    {"plan.csv", "false_flags_se", "number",
     "standard error of it over the simulated studies; empty where there is one, as of the others"},
    {"plan.csv", "power", "number", "share of tested cells at 75 % or above in truth that are flagged"},
    {"plan.csv", "power_se", "number", "standard error of it over the simulated studies"},
    {"plan.csv", "cuts_right", "number", "share of columns whose artifact cut is the truth's"},
    {"plan.csv", "cuts_right_se", "number", "standard error of it over the simulated studies"},
    {"plan.csv", "ee_right", "number", "share of columns whose EE is the truth's"},
    {"plan.csv", "ee_right_se", "number", "standard error of it over the simulated studies"},
    {"plan.csv", "green_width", "number", "equivalent levels of a column, on average"},
    {"plan.csv", "green_width_se", "number", "standard error of it over the simulated studies"},
    {"plan.csv", "supported", "number", "equivalent levels of a column that are supported, on average"},
    {"plan.csv", "supported_se", "number", "standard error of it over the simulated studies"},
    {"answers.csv", "correct", "integer",
     "1: the subject chose the picture that is not the reference; 0: not"},
};

bool names(std::string_view files, std::string_view file) {
  for (std::size_t begin = 0; begin < files.size();) {
    const std::size_t end = std::min(files.find(' ', begin), files.size());
    if (files.substr(begin, end - begin) == file) return true;
    begin = end + 1;
  }
  return false;
}

Json make_column_json(std::string_view file, const std::string& name) {
  const DictionaryEntry& entry = find_entry(file, name);
  Json column;
  column.set("name", name).set("titles", name).set("datatype", entry.datatype);
  column.set("dc:description", entry.meaning);
  return column;
}

}  // namespace

const DictionaryEntry& find_entry(std::string_view file, std::string_view column) {
  for (const DictionaryEntry& entry : kDictionary) {
    if (column == entry.column && names(entry.files, file)) return entry;
  }
  throw CheckFailure(fmt::format("{}: the column {} is not in the dictionary", file, column));
}

Json make_csv_metadata(const std::vector<ReportTable>& tables) {
  Json list{Json::Array{}};
  for (const ReportTable& table : tables) {
    Json columns{Json::Array{}};
    for (const std::string& name : table.table.columns) columns.push(make_column_json(table.file, name));
    Json schema;
    schema.set("columns", std::move(columns));
    Json entry;
    entry.set("url", table.file).set("tableSchema", std::move(schema));
    list.push(std::move(entry));
  }
  Json metadata;
  metadata.set("@context", "http://www.w3.org/ns/csvw").set("tables", std::move(list));
  return metadata;
}

}  // namespace equilux
