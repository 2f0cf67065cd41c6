// timing.json, read and added to.
#include "renderer/timing.h"

#include "base/error.h"
#include "base/files.h"
#include "base/program.h"
#include "base/version.h"
#include "renderer/isa.h"
#include "renderer/parallel.h"

namespace equilux {
namespace {

Json make_run(const std::map<std::string, double>& seconds_by_stage, std::size_t layers_rendered,
              std::size_t pictures_written) {
  Json seconds;
  for (const auto& [stage, time] : seconds_by_stage) seconds.set(stage, time);
  Json run;
  run.set("producer_version", kVersion).set("finished_utc", format_utc_now()).set("host", find_host_name());
  run.set("isa", format_isa(current_isa())).set("threads", count_threads());
  run.set("layers_rendered", layers_rendered).set("pictures_written", pictures_written);
  run.set("seconds", std::move(seconds));
  return run;
}

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

void append_timing(const StudyFolder& folder, const std::map<std::string, double>& seconds,
                   std::size_t layers_rendered, std::size_t pictures_written) {
  Json runs = load_timing(folder);
  runs.push(make_run(seconds, layers_rendered, pictures_written));
  Json json;
  json.set("schema", "equilux-timing").set("schema_version", 1).set("runs", std::move(runs));
  save_text(folder.timing(), format_json(json));
}

}  // namespace equilux
