// The folder of a report holds what the last report wrote, and what is not of any report.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace equilux {

/// Bytes of each file of a report, by its name within the folder.
using ReportFiles = std::map<std::string, std::string>;

/// The list of what a report wrote: every file with its digest. It stands beside the report's files.
inline constexpr const char* kReportList = "report-files.json";
inline constexpr const char* kReportPage = "index.html";

/// Writes the files, the page last, and then removes those of earlier reports that are not among them: only
/// files that the folder's list names and whose bytes are still the ones that it names. What is listed while
/// files are written is all of both reports, so that a report that was cut short is cleared up by the next.
/// Gives what else stands in the folder, sorted. errors: InputError, before anything is written, for a list
/// that cannot be read and, unless `force`, for a file that no report wrote under the name of one of these;
/// StoreError.
std::vector<std::string> save_report(const ReportFiles& files, const std::filesystem::path& folder,
                                     bool force = false);

}  // namespace equilux
