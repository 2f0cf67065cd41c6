// The tables of the study: cells, thresholds, and whether equivalence exists.
#pragma once

#include <optional>
#include <string>

#include "analysis/csv.h"
#include "analysis/equivalence.h"

namespace equilux {

/// cells.csv: every cell of the study in both experiments. Columns: experiment (artifact, material);
/// geometry, material, illumination (tokens); vpls (a number); clamp (C0 .. C10, with n normalised); k
/// correct of n subjects; proportion k / n; p_guess, the probability of k or more of n at one half. The last
/// two are empty where n is 0.
Table make_cells_table(const Study& study, const Tally& artifact, const Tally& material);

/// thresholds.csv: a row for each experiment, column and rule. cut: C0 .. C10 or empty; status: cut,
/// censored_low, censored_high, none, untested; monotone: of the proportions; flags_monotone: of the flags,
/// where false the rule decides; tested and untested: clamp levels with answers, and those that the rule
/// keeps for the material experiment without answers.
Table make_thresholds_table(const std::vector<ColumnFinding>& findings);

/// ee.csv: a row for each geometry, material, illumination and VPL count. ee_paper, ee_isotonic: true iff a
/// clamp level is artifact-free and unchanged, empty where that is untested; then for each rule status
/// (exists, none, untested), green and supported levels; dropped: the selection kept no level.
Table make_ee_table(const std::vector<ColumnFinding>& findings);

/// The EE table as text: for each illumination rows of geometries, columns of materials, a mark for each VPL
/// count from few to many, and a legend.
std::string format_ee_text(const Study& study, const std::vector<ColumnFinding>& findings, Rule rule);

/// "C4 C5 C6"
std::string format_levels(const std::vector<int>& levels);

/// Shortest exact form; empty for nothing.
std::string format_number(const std::optional<double>& value);

std::string format_verdict(Verdict verdict);

/// Factor levels that occur, in the study's order; VPL counts from few to many.
std::vector<std::string> enumerate_geometries(const Study& study);
std::vector<std::string> enumerate_materials(const Study& study);
std::vector<Illumination> enumerate_illuminations(const Study& study);
std::vector<std::int64_t> enumerate_vpl_counts(const Study& study, Illumination illumination);

/// The columns of an object from few to many VPLs; none where the study lacks it.
std::vector<const ColumnFinding*> findings_of(const std::vector<ColumnFinding>& findings,
                                              const Object& object);

/// Whose answers a figure shows: "answers of persons", "PLANTED SUBJECTS, whose answers were put in".
std::string describe_subjects(SubjectKind kind);

/// "indirect-only", "direct-and-indirect"
std::string describe_illumination(Illumination illumination);

}  // namespace equilux
