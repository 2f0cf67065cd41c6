// Logs of one study from several folders, added up.
#pragma once

#include <string>
#include <vector>

#include "analysis/report.h"

namespace equilux {

/// A folder of a pool: its name, what was answered there and about what.
struct PoolPart {
  std::string folder;
  const Evidence& evidence;
  const ReportSources& sources;
};

/// What a reader should know of answers that are added up: pictures or clamp windows of one folder are not
/// those of another.
std::vector<std::string> find_pool_warnings(const std::vector<PoolPart>& parts);

/// The sources of several folders of one study as one: a column is dropped iff every selection drops it, and
/// what is not the same in all is left out. `folders` names them.
ReportSources pool_sources(std::vector<ReportSources> parts, const std::vector<std::string>& folders);

}  // namespace equilux
