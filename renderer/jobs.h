// A set in shares: each rendered by itself, in a folder of its own, and gathered into the set's.
#pragma once

#include <string>
#include <vector>

#include "renderer/layer_store.h"
#include "renderer/work.h"

namespace equilux {

/// The index-th of `count` shares of a study's work, counted from 1.
struct JobShare {
  int index = 1;
  int count = 1;
};

inline constexpr int kMostJobs = 10000;

/// "3/16". errors: InputError
JobShare parse_job(const std::string& text);

/// The folder of a share: 3-of-16.
std::string format_job_folder(const JobShare& job);

/// Costs of every world of what is wanted, each made once. errors: InputError for what the scene lacks
std::map<WorldKey, WorldCosts> estimate_worlds(const Study& study, const Scene& scene, const Wanted& wanted);

/// All shares of what is wanted, the same whatever is on disk. errors: InputError for what the scene lacks
std::vector<std::vector<WorkItem>> plan_jobs(const Study& study, const Scene& scene, const Wanted& wanted,
                                             int count);

/// Names of the layers of what is wanted, each with the digest of its recipe.
std::map<std::string, std::string> list_layers(const Recipes& recipes, const Wanted& wanted);

/// The part of it whose layers are not whole in the store.
Wanted find_missing(const Recipes& recipes, const Wanted& wanted, LayerStore& store);

/// Takes over from another folder what the store lacks and what was made there from the same. Gives the
/// number of layers. errors: StoreError
std::size_t adopt_layers(const std::map<std::string, std::string>& recipes, LayerStore& store,
                         LayerStore& from);

/// Shares are rendered into a folder of the very same study, or into a new one. errors: InputError
void check_folder_of(const Study& study, const StudyFolder& folder);

/// Of a set that was shown no layer may change. errors: InputError
void check_unchanged(const StudyFolder& folder, const std::map<std::string, std::string>& recipes,
                     const LayerStore& store);

/// Names of the folders of shares in it, sorted.
std::vector<std::string> list_shares(const StudyFolder& folder);

/// Whether there are any.
bool has_shares(const StudyFolder& folder);

/// Takes over what shares have left in the folder, and removes those folders of which nothing remains that
/// the set lacks: no layer, and no stage of a room whose references it lacks. Gives warnings: of shares that
/// are still being rendered, damaged, made from something else, or cannot be read, written or removed.
/// errors: InputError for what the scene lacks, and where a set that was shown would change
std::vector<std::string> gather_jobs(const StudyFolder& folder, const Study& study, const Scene& scene,
                                     LayerStore& store);

}  // namespace equilux
