// timing.json, read.
#include "base/error.h"
#include "base/files.h"
#include "renderer/timing.h"

namespace equilux {
namespace {

// Of any machine. units: paths / s
constexpr double kSlowest = 1, kFastest = 1e12;

}  // namespace

Json load_timing(const StudyFolder& folder) {
  if (!path_exists(folder.timing())) return Json(Json::Array{});
  const Json json = parse_json(load_text(folder.timing()), folder.timing().string());
  const Json* runs = json.find("runs");
  if (!runs || !runs->is_array()) {
    throw InputError(folder.timing().string(), "/runs",
                     "an array; the file may be removed, nothing depends on it",
                     runs ? describe_json(*runs) : "none");
  }
  return *runs;
}

std::optional<double> find_speed(const StudyFolder& folder) {
  const Json runs = load_timing(folder);
  double work = 0, time = 0;
  for (const Json& run : runs.as_array()) {
    const Json *done = run.find("foreseen_work"), *seconds = run.find("seconds");
    if (!done || !done->is_number() || !(done->as_double() > 0) || !seconds || !seconds->is_object())
      continue;
    work += done->as_double();
    for (const auto& [stage, spent] : seconds->as_object())
      time += spent.is_number() && stage != "pictures" && stage != "checking" ? spent.as_double() : 0;
  }
  // Files can be edited.
  const double speed = time > 0 ? work / time : 0;
  if (!(speed >= kSlowest) || !(speed <= kFastest)) return {};
  return speed;
}

}  // namespace equilux
