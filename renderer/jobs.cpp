// Shares by cost; gathering by links.
#include "renderer/jobs.h"

#include <algorithm>
#include <charconv>
#include <fmt/format.h>

#include "base/error.h"
#include "base/files.h"
#include "base/folder_lock.h"
#include "renderer/picture_store.h"
#include "renderer/reference.h"
#include "renderer/room_stages.h"
#include "renderer/timing.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

// Of shares whose layers are all in the set, and that are to be removed.
constexpr const char* kDone = ".done-";

bool is_share(const std::string& name) {
  const auto of = name.find("-of-");
  if (of == std::string::npos) return false;
  const std::string first = name.substr(0, of), second = name.substr(of + 4);
  const auto is_number = [](const std::string& text) {
    return !text.empty() && text.size() < 6 && text.find_first_not_of("0123456789") == std::string::npos;
  };
  return is_number(first) && is_number(second);
}

std::vector<fs::path> list_folders(const fs::path& parent) {
  std::vector<fs::path> folders;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(parent, none)) {
    if (entry.is_directory(none)) folders.push_back(entry.path());
  }
  std::sort(folders.begin(), folders.end());
  return folders;
}

// The first layer of a share that the set does not have as it would be made today; empty if it has them all.
std::string find_lacking(const std::map<std::string, std::string>& recipes, LayerStore& store,
                         const LayerStore& share) {
  for (const auto& [name, layer] : share.records()) {
    const auto today = recipes.find(name);
    if (today == recipes.end() || today->second != layer.made_from || !store.is_whole(name, today->second))
      return name;
  }
  return "";
}

// A share's folder from which all was taken, under a name that no share has; there may be others of it.
fs::path find_done_name(const fs::path& share) {
  const std::string name = kDone + share.filename().string();
  fs::path done = share.parent_path() / name;
  for (int count = 2; path_exists(done); ++count)
    done = share.parent_path() / fmt::format("{}.{}", name, count);
  return done;
}

// Its times first, which count once however often they are joined: where they cannot be kept the share stays.
// Then under another name, by which no run gathers it again. What is in it is removed by whoever lets go of
// its lock: NFS keeps the names of files that are open.
fs::path retire_share(const StudyFolder& folder, const StudyFolder& share) {
  join_timing(folder, share);
  const fs::path done = find_done_name(share.root);
  std::error_code error;
  fs::rename(share.root, done, error);
  if (error) throw StoreError(fmt::format("{}: cannot rename: {}", share.root.string(), error.message()));
  join_log(folder, {done});
  return done;
}

// Nothing is lost with a folder that stays: the next gathering tries again.
void remove_done(const fs::path& done, std::vector<std::string>& warnings) {
  std::error_code error;
  fs::remove_all(done, error);
  if (error)
    warnings.push_back(
        fmt::format("{}: cannot remove: {}; all that it held is in the set, and gathering again "
                    "removes it",
                    done.string(), error.message()));
}

// What shares are gathered into, and what of: all that the study wants, and its layers.
struct Gathering {
  const StudyFolder& folder;
  const Study& study;
  const Wanted& wanted;
  const std::map<std::string, std::string>& layers;
  LayerStore& store;
};

// The first layer that the set lacks, of a reference or of all; empty if it has them all.
std::string find_missing_layer(const Gathering& job, const Family& family) {
  for (const char* content : kFamilyContents) {
    const std::string name = layer_name(family, content);
    if (!job.store.is_whole(name, job.layers.at(name))) return name;
  }
  return "";
}

std::string find_missing_layer(const Gathering& job) {
  for (const auto& [name, recipe] : job.layers) {
    if (!job.store.is_whole(name, recipe)) return name;
  }
  return "";
}

// Stages go with the share's folder, and a room with them whose references nobody has made.
std::string find_room_to_keep(const Gathering& job, const StudyFolder& share) {
  for (const std::string& room : list_rooms(share.rooms())) {
    for (const Family& family : job.wanted.families) {
      if (name_background_stream(family) != room) continue;
      const std::string missing = find_missing_layer(job, family);
      if (!missing.empty())
        return fmt::format(
            "{}: stages of a room of which the set lacks {}; the share is kept, `set --job` "
            "goes on from them",
            (share.rooms() / room).string(), missing);
    }
  }
  return "";
}

// Why a share stays from which all was taken that could be; empty if it may go.
std::string find_reason_to_keep(const Gathering& job, const StudyFolder& share, const LayerStore& rendered) {
  const std::string lacking = find_lacking(job.layers, job.store, rendered);
  if (!lacking.empty())
    return fmt::format(
        "{}: {} is damaged or made from another study, scene or estimator; the share is kept, "
        "`set --job` makes it anew",
        share.root.string(), lacking);
  std::string room = find_room_to_keep(job, share);
  if (!room.empty()) return room;
  if (path_exists(share.layers()) || !rendered.records().empty()) return "";
  const std::string missing = find_missing_layer(job);
  if (missing.empty()) return "";
  return fmt::format("{}: no layer is recorded there; the share is kept while the set lacks {}",
                     share.root.string(), missing);
}

// What became of a share: retired, its folder has another name and is to be removed; else a warning says why
// it stays.
struct GatheredShare {
  fs::path done;
  std::vector<std::string> warnings;
};

// A share that nobody writes any more.
GatheredShare gather_share(const Gathering& job, const StudyFolder& share) {
  LayerStore rendered(share, job.study);
  adopt_layers(job.layers, job.store, rendered);
  job.store.save_record();
  GatheredShare gathered{{}, rendered.warnings()};
  std::string reason = find_reason_to_keep(job, share, rendered);
  if (!reason.empty()) {
    gathered.warnings.push_back(std::move(reason));
    return gathered;
  }
  gathered.done = retire_share(job.folder, share);
  return gathered;
}

// Whoever waits for the lock of a share that was retired finds its folder moved.
GatheredShare lock_share(const Gathering& job, const StudyFolder& share) {
  const FolderLock lock(share.root);
  if (!lock.is_busy()) return gather_share(job, share);
  const std::string by = lock.holder().empty() ? "" : " by " + lock.holder();
  return {{}, {fmt::format("{}: still being rendered{}, not gathered", share.root.string(), by)}};
}

// What is damaged in one share, or cannot be written of it, keeps no other from being gathered.
void try_share(const Gathering& job, const StudyFolder& share, std::vector<std::string>& warnings) {
  try {
    const GatheredShare gathered = lock_share(job, share);
    warnings.insert(warnings.end(), gathered.warnings.begin(), gathered.warnings.end());
    if (!gathered.done.empty()) remove_done(gathered.done, warnings);
  } catch (const InputError& error) {
    warnings.push_back(fmt::format("{}; the share was left alone: where it cannot be mended, remove {}",
                                   error.what(), share.root.string()));
  } catch (const StoreError& error) {
    warnings.push_back(fmt::format("{}; {} was not gathered", error.what(), share.root.string()));
  }
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

std::map<WorldKey, WorldCosts> estimate_worlds(const Study& study, const Scene& scene, const Wanted& wanted) {
  std::map<WorldKey, WorldCosts> costs;
  const std::vector<Family> references = pick_references(study);
  const auto add = [&](const Object& object) {
    const WorldKey key = world_of(object);
    if (!costs.contains(key))
      costs[key] =
          estimate_costs(study, scene, make_world(scene, key.geometry, key.illumination), references);
  };
  for (const Family& family : wanted.families) add(family.object);
  for (const Condition& condition : wanted.conditions) add(condition.cell.column.object);
  return costs;
}

std::vector<std::vector<WorkItem>> plan_jobs(const Study& study, const Scene& scene, const Wanted& wanted,
                                             int count) {
  return split_work(list_work(estimate_worlds(study, scene, wanted), wanted), count);
}

void check_folder_of(const Study& study, const StudyFolder& folder) {
  if (path_exists(folder.study()) && load_study(folder.study()).digest != study.digest)
    throw InputError(folder.root.string(), "", "the folder of this study",
                     "that of another, or of an older version");
}

void check_unchanged(const StudyFolder& folder, const std::map<std::string, std::string>& recipes,
                     const LayerStore& store) {
  if (!has_sessions(folder)) return;
  for (const auto& [name, recipe] : recipes) {
    if (store.is_other(name, recipe)) refuse_change(folder, fmt::format("another {}", name));
  }
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

std::vector<std::string> list_shares(const StudyFolder& folder) {
  std::vector<std::string> shares;
  for (const fs::path& path : list_folders(folder.jobs())) {
    if (is_share(path.filename().string())) shares.push_back(path.filename().string());
  }
  return shares;
}

bool has_shares(const StudyFolder& folder) { return !list_shares(folder).empty(); }

std::vector<std::string> gather_jobs(const StudyFolder& folder, const Study& study, const Scene& scene,
                                     LayerStore& store) {
  std::vector<std::string> warnings;
  for (const fs::path& done : list_folders(folder.jobs())) {
    if (done.filename().string().starts_with(kDone)) remove_done(done, warnings);
  }
  const std::vector<std::string> shares = list_shares(folder);
  if (!shares.empty()) {
    const Wanted all = enumerate_wanted(study, "*");
    const auto layers = list_layers(make_recipes(study, scene, all), all);
    check_unchanged(folder, layers, store);
    for (const std::string& share : shares)
      try_share({folder, study, all, layers, store}, {folder.job(share)}, warnings);
  }
  std::error_code not_empty;
  fs::remove(folder.jobs(), not_empty);
  return warnings;
}

}  // namespace equilux
