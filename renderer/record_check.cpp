// Shared by `set`, which warns of them, and `verify`, which does not let them pass.
#include "renderer/record_check.h"

#include <cmath>
#include <fmt/format.h>

namespace equilux {
namespace {

// Rare bright paths make some regions differ by more than chance of a normal distribution would; this is
// beyond that.
constexpr double kMostErrors = 7;

// Empty without a check.
Json::Array regions_of(const LayerRecord& layer) {
  const Json* check = layer.reference.is_null() ? nullptr : layer.reference.find("check");
  return check ? check->as_array() : Json::Array();
}

// Paths that met no light tell an error of 0.
bool is_unsure(const Json& region) {
  const double traced = region.at("path_traced").as_double(),
               error = region.at("path_traced_error").as_double();
  return region.at("mean").as_double() > 0 && (traced == 0 || traced < kMostErrors * error);
}

}  // namespace

std::string find_uncertified(const LayerRecord& layer, bool wanted) {
  const Json* certified = layer.vpls.is_null() ? nullptr : layer.vpls.find("certified");
  if (!certified) return wanted ? "its record does not say whether its cuts are certified" : "";
  if (certified->as_bool()) return "";
  return "not certified, more than 1 % of its points err by 1 % or more";
}

std::string find_unchecked(const LayerRecord& layer, const Study& study) {
  const Json* method = layer.reference.is_null() ? nullptr : layer.reference.find("method");
  if (!method) {
    // A record without method is older than the default.
    const bool is_asked_for =
        study.reference == ReferenceMethod::kCompensated && study.source.find("reference");
    return is_asked_for ? "its record does not say how it was made" : "";
  }
  if (method->as_string() != "compensated" || layer.reference.find("check")) return "";
  return "by VPL sets, without the path-traced check of its regions";
}

std::vector<std::string> find_failed_checks(const LayerRecord& layer) {
  std::vector<std::string> failed;
  for (const Json& region : regions_of(layer)) {
    const double z = region.at("z").as_double();
    if (std::abs(z) > kMostErrors)
      failed.push_back(fmt::format("region {} differs from its path-traced check by {:.1f} standard errors",
                                   region.at("region").as_string(), z));
  }
  return failed;
}

CheckedRegions count_checked_regions(const LayerRecord& layer) {
  CheckedRegions count;
  for (const Json& region : regions_of(layer)) {
    ++count.all;
    count.unsure += is_unsure(region);
  }
  return count;
}

}  // namespace equilux
