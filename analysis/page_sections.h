// The parts of the page, each a function of the report. Only page.cpp includes this.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/csv.h"
#include "analysis/report.h"

namespace equilux {

std::string format_banner(const Report& report);
std::string format_warnings(const Report& report);
std::string format_summary(const Report& report);
std::string format_asked(const Report& report);
std::string format_answered(const Report& report);
std::string format_ee_squares(const Report& report);
std::string format_graphs(const Report& report);
std::string format_uncertainty(const Report& report);
/// Empty unless answers are planted and the folder has their truth.
std::string format_recovery(const Report& report);
std::string format_trends(const Report& report);
std::string format_subjects(const Report& report);
std::string format_counting(const Report& report);
std::string format_monotone(const Report& report);
std::string format_rule_differences(const Report& report);
std::string format_rule_certainty(const Report& report);
std::string format_noise(const Report& report);
std::string format_convergences(const Report& report);
std::string format_cells(const Report& report);
std::string format_provenance(const Report& report);
std::string format_tracing(const std::vector<Report>& reports);

/// Parts of format_asked and format_answered: what the levels are, how trials and sessions went, who took
/// part.
std::string format_levels_table(const Report& report);
std::string format_design(const Report& report);
std::string format_participation(const Report& report);

/// "by the rule <i>paper</i>"; of a pool whose folders pruned by several: by those.
std::string describe_selection_rule(const Selection& selection);

/// A material of the scene that comes with the program, as the page tells it.
struct OwnMaterial {
  const char* token;
  float rho_d, rho_s, roughness_alpha;  ///< the last two are 0 for Lambertian
};
const std::vector<OwnMaterial>& own_scene_materials();

/// In a field that has no value.
inline constexpr const char* kDash = "&ndash;";

/// "0.25", or the dash.
std::string format_share(const std::optional<double>& value);

/// "0.0123", "&lt; 0.0001".
std::string format_small(double p);

/// "31.6", "no clamp". units: 1/m^2
std::string format_clamp_value(int level);

/// A table with a head. `fields` are markup already; columns from `first_number` on are aligned to the right.
std::string format_html_table(const Table& table, std::size_t first_number);

}  // namespace equilux
