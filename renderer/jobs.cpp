// Shares by cost; gathering by links.
#include "renderer/jobs.h"

#include <algorithm>
#include <charconv>
#include <fmt/format.h>

#include "base/error.h"
#include "base/files.h"
#include "base/folder_lock.h"
#include "renderer/timing.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

std::vector<fs::path> list_folders(const fs::path& parent) {
  std::vector<fs::path> folders;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(parent, none)) {
    if (entry.is_directory(none)) folders.push_back(entry.path());
  }
  std::sort(folders.begin(), folders.end());
  return folders;
}

void remove_folder(const fs::path& folder) {
  std::error_code error;
  fs::remove_all(folder, error);
  if (error) throw StoreError(fmt::format("{}: cannot remove: {}", folder.string(), error.message()));
}

// A share that nobody writes any more.
void gather_job(const StudyFolder& folder, const StudyFolder& job, const Study& study,
                const std::map<std::string, std::string>& recipes, LayerStore& store) {
  LayerStore rendered(job, study);
  adopt_layers(recipes, store, rendered);
  store.save_record();
  if (!rendered.list_lacking(store).empty()) return;
  join_timing(folder, job);
  remove_folder(job.root);
}

}  // namespace

JobShare parse_job(const std::string& text) {
  JobShare job;
  const char *end = text.data() + text.size(), *slash = std::find(text.data(), end, '/');
  const auto first = std::from_chars(text.data(), slash, job.index);
  bool good = slash != end && first.ptr == slash && first.ec == std::errc();
  if (good) {
    const auto second = std::from_chars(slash + 1, end, job.count);
    good = second.ptr == end && second.ec == std::errc() && job.index >= 1 && job.index <= job.count &&
           job.count <= kMostJobs;
  }
  if (!good)
    throw InputError("--job", "", fmt::format("I/N with I from 1 to N, N up to {}", kMostJobs), text);
  return job;
}

std::string format_job_folder(const JobShare& job) { return fmt::format("{}-of-{}", job.index, job.count); }

std::vector<std::vector<WorkItem>> plan_jobs(const Study& study, const Scene& scene, const Wanted& wanted,
                                             int count) {
  std::map<WorldKey, WorldCosts> costs;
  for (const Family& family : wanted.families) {
    const WorldKey key = world_of(family.object);
    if (!costs.contains(key))
      costs[key] = estimate_costs(study, scene, make_world(scene, key.geometry, key.illumination));
  }
  return split_work(list_work(costs, wanted), count);
}

std::map<std::string, std::string> list_layers(const Recipes& recipes, const Wanted& wanted) {
  std::map<std::string, std::string> layers;
  for (const Family& family : wanted.families) {
    const std::string recipe = digest_family_recipe(recipes, family);
    for (const char* content : kFamilyContents) layers[layer_name(family, content)] = recipe;
  }
  for (Condition condition : wanted.conditions) {
    for (const int level : needed_levels(condition)) {
      condition.cell = {condition.cell.column, level, false};
      layers[vpl_layer_name(condition)] = digest_vpl_recipe(recipes, condition);
    }
  }
  return layers;
}

Wanted find_missing(const Recipes& recipes, const Wanted& wanted, LayerStore& store) {
  Wanted missing;
  for (const Family& family : wanted.families) {
    const std::string recipe = digest_family_recipe(recipes, family);
    bool lacks = false;
    for (const char* content : kFamilyContents) lacks |= !store.is_whole(layer_name(family, content), recipe);
    if (lacks) missing.families.push_back(family);
  }
  std::set<std::string> seen;
  for (Condition condition : wanted.conditions) {
    for (const int level : needed_levels(condition)) {
      condition.cell = {condition.cell.column, level, false};
      const std::string name = vpl_layer_name(condition);
      if (seen.insert(name).second && !store.is_whole(name, digest_vpl_recipe(recipes, condition)))
        missing.conditions.push_back(condition);
    }
  }
  return missing;
}

std::size_t adopt_layers(const std::map<std::string, std::string>& recipes, LayerStore& store,
                         LayerStore& from) {
  std::size_t adopted = 0;
  for (const auto& [name, recipe] : recipes) {
    if (!store.is_whole(name, recipe)) adopted += store.adopt(name, recipe, from);
  }
  return adopted;
}

std::vector<std::string> gather_jobs(const StudyFolder& folder, const Study& study, const Scene& scene,
                                     LayerStore& store) {
  std::vector<std::string> warnings;
  const std::vector<fs::path> jobs = list_folders(folder.jobs());
  if (jobs.empty()) return warnings;
  const Wanted all = enumerate_wanted(study, "*");
  const auto layers = list_layers(make_recipes(study, scene, all), all);
  for (const fs::path& job : jobs) {
    const FolderLock lock(job);
    if (lock.is_busy()) {
      warnings.push_back(job.string() + ": still being rendered, not gathered");
    } else {
      gather_job(folder, {job}, study, layers, store);
    }
  }
  std::error_code not_empty;
  fs::remove(folder.jobs(), not_empty);
  return warnings;
}

}  // namespace equilux
