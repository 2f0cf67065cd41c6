// The parts of the page, each a function of the report. Only page.cpp includes this.
#pragma once

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
std::string format_trends(const Report& report);
std::string format_subjects(const Report& report);
std::string format_counting(const Report& report);
std::string format_monotone(const Report& report);
std::string format_rule_differences(const Report& report);
std::string format_noise(const Report& report);
std::string format_convergences(const Report& report);
std::string format_cells(const Report& report);
std::string format_provenance(const Report& report);
std::string format_tracing(const std::vector<Report>& reports);

/// A table with a head. `fields` are markup already; columns from `first_number` on are aligned to the right.
std::string format_html_table(const Table& table, std::size_t first_number);

}  // namespace equilux
