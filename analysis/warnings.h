// What is legal in answers and their sources, but a reader should know.
#pragma once

#include <string>
#include <vector>

#include "analysis/report.h"

namespace equilux {

/// What a reader should know of the answers beside these sources: sessions made from others, placeholders.
std::vector<std::string> find_source_warnings(const Study& study, const Evidence& evidence,
                                              const ReportSources& sources);

/// Codes that finished an experiment more than once.
std::vector<std::string> find_repeater_warnings(const Evidence& evidence);

/// What a reader should know of the answers of a report: uneven cells, sides out of balance, sessions left
/// out.
std::vector<std::string> find_answer_warnings(const Report& report);

}  // namespace equilux
