// Digests of the records, and the first of what was found.
#include "stimuli/verdict.h"

#include <algorithm>

#include "base/digest.h"
#include "base/error.h"
#include "base/files.h"
#include "base/json.h"
#include "base/version.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

constexpr const char* kSchema = "equilux-verdict";

std::string digest_if_there(const fs::path& path) { return is_file(path) ? digest_file(path) : ""; }

std::string get_text(const Json& json, const char* key, const std::string& path) {
  const Json* member = json.find(key);
  if (!member || !member->is_string())
    throw InputError(path, std::string("/") + key, "a string", member ? describe_json(*member) : "none");
  return member->as_string();
}

std::int64_t get_count(const Json& json, const char* key, const std::string& path) {
  const Json* member = json.find(key);
  if (!member || !member->is_integer())
    throw InputError(path, std::string("/") + key, "a whole number",
                     member ? describe_json(*member) : "none");
  return member->as_int();
}

void remove_verdict(const StudyFolder& folder) {
  std::error_code error;
  fs::remove(folder.verdict(), error);
  if (error)
    throw StoreError(fmt::format("{}: cannot remove: {}", folder.verdict().string(), error.message()));
}

}  // namespace

void save_verdict(const StudyFolder& folder, const std::vector<Finding>& findings) {
  if (findings.empty()) {
    remove_verdict(folder);
    return;
  }
  Json json;
  json.set("schema", kSchema).set("schema_version", 1);
  json.set("producer", std::string("equilux-render ") + kVersion);
  json.set("manifest", digest_if_there(folder.manifest())).set("layers", digest_if_there(folder.layers()));
  json.set("findings", static_cast<std::int64_t>(findings.size()));
  json.set("first", format_finding(findings.front()));
  if (std::any_of(findings.begin(), findings.end(), [](const Finding& f) { return f.by_study_file; }))
    json.set("by_study_file", true);
  save_text(folder.verdict(), format_json(json));
}

std::vector<Finding> renew_verdict(const StudyFolder& folder, std::vector<Finding> findings,
                                   bool has_study_file) {
  const auto earlier = has_study_file ? std::vector<Finding>() : find_verdict(folder);
  if (earlier.empty() || !earlier.front().by_study_file) {
    save_verdict(folder, findings);
  } else {
    findings.insert(findings.end(), earlier.begin(), earlier.end());
  }
  return findings;
}

std::vector<Finding> find_verdict(const StudyFolder& folder) {
  if (!path_exists(folder.verdict())) return {};
  const std::string path = folder.verdict().string();
  const Json json = parse_json(load_text(folder.verdict()), path);
  if (const std::string schema = get_text(json, "schema", path); schema != kSchema)
    throw InputError(path, "/schema", fmt::format("\"{}\"", kSchema), schema);
  const std::int64_t count = get_count(json, "findings", path);
  const std::string manifest = get_text(json, "manifest", path), layers = get_text(json, "layers", path),
                    first = get_text(json, "first", path);
  if (count == 0) return {};
  const bool is_same =
      manifest == digest_if_there(folder.manifest()) && layers == digest_if_there(folder.layers());
  const Json* flag = json.find("by_study_file");
  const bool by_study_file = flag && flag->is_bool() && flag->as_bool();
  const std::string when = is_same ? "which is to be run again when it is mended"
                                   : "which is to be run again: records were changed since";
  return {{fmt::format("found by `equilux-render verify{}`, {}", by_study_file ? " --study" : "", when),
           first, by_study_file}};
}

}  // namespace equilux
