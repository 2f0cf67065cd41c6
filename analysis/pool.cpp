// What several folders have alike, and what they have not.
#include "analysis/pool.h"

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <set>
#include <utility>

#include "analysis/words.h"
#include "base/error.h"

namespace equilux {
namespace {

void keep_if_same(auto& all, const auto& part) {
  if (all != part) all = {};
}

void pool_column(SelectedColumn& all, const SelectedColumn& part) {
  all.levels.insert(all.levels.end(), part.levels.begin(), part.levels.end());
  std::sort(all.levels.begin(), all.levels.end());
  all.levels.erase(std::unique(all.levels.begin(), all.levels.end()), all.levels.end());
  keep_if_same(all.status, part.status);
  keep_if_same(all.artifact_cut, part.artifact_cut);
}

// A column is kept where either keeps a level.
void pool_selection(Selection& all, const Selection& part) {
  keep_if_same(all.rule, part.rule);
  keep_if_same(all.answers_digest, part.answers_digest);
  for (std::size_t c = 0; c < all.columns.size(); ++c) pool_column(all.columns[c], part.columns[c]);
}

// Without a selection in one of them, nothing was dropped.
void pool_selections(ReportSources& all, const std::vector<ReportSources>& parts,
                     const std::vector<std::string>& folders) {
  std::vector<FolderSelection> selections;
  std::set<std::string> digests;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (!parts[i].selection) continue;
    const Selection& selection = *parts[i].selection;
    selections.push_back({folders[i], selection.rule, digest_selection(selection), selection.answers_digest});
    digests.insert(selections.back().digest);
  }
  const bool all_have = selections.size() == parts.size();
  if (all_have && digests.size() == 1) return;
  all.selections = std::move(selections);
  if (!all_have) {
    all.selection.reset();
    return;
  }
  for (const ReportSources& part : parts) pool_selection(*all.selection, *part.selection);
}

// Pictures that both have, and those of them that differ.
struct PictureComparison {
  std::size_t common = 0, different = 0;
  std::string first;
};

PictureComparison compare_pictures(const Manifest& one, const Manifest& other) {
  PictureComparison sum;
  for (const auto& [key, picture] : one.pictures) {
    const auto same = other.pictures.find(key);
    if (same == other.pictures.end()) continue;
    ++sum.common;
    if (same->second.digest == picture.digest) continue;
    ++sum.different;
    if (sum.first.empty()) sum.first = key;
  }
  return sum;
}

bool are_same_pictures(const std::optional<Manifest>& one, const std::optional<Manifest>& other) {
  if (!one || !other) return !one && !other;
  const PictureComparison sum = compare_pictures(*one, *other);
  return one->seed == other->seed && sum.different == 0 && sum.common == one->pictures.size() &&
         sum.common == other->pictures.size();
}

// Against the first folder that has a manifest.
bool warn_of_manifests(std::vector<std::string>& warnings, const std::vector<PoolPart>& parts) {
  const PoolPart* first = nullptr;
  bool found = false;
  for (const PoolPart& part : parts) {
    if (!part.sources.manifest) continue;
    if (!first) {
      first = &part;
      continue;
    }
    const PictureComparison sum = compare_pictures(*first->sources.manifest, *part.sources.manifest);
    if (sum.different == 0) continue;
    found = true;
    warnings.push_back(
        fmt::format("Answers about different pictures are added up: of {} pictures that {} and {} both have, "
                    "{} {}, the first {}.",
                    sum.common, first->folder, part.folder, sum.different,
                    choose_form(sum.different, "differs", "differ"), sum.first));
  }
  return found;
}

// Folders by a digest, told in a sentence: "a (0123456789ab...); b, c (ba9876543210...)".
using FoldersByDigest = std::map<std::string, std::vector<std::string>>;

std::string list_folders(const FoldersByDigest& folders) {
  std::vector<std::string> groups;
  for (const auto& [digest, names] : folders)
    groups.push_back(fmt::format("{} ({}...)", fmt::join(names, ", "), digest.substr(0, 12)));
  return fmt::format("{}", fmt::join(groups, "; "));
}

// By what sessions recorded. Those that might show other pictures, by other windows or another selection, say
// nothing of one another.
void warn_of_sessions(std::vector<std::string>& warnings, const std::vector<PoolPart>& parts,
                      Experiment experiment) {
  std::map<std::string, FoldersByDigest> by_choice;
  for (const PoolPart& part : parts) {
    std::set<std::pair<std::string, std::string>> used;
    for (const SessionRow& row : part.evidence.of(experiment).finished)
      used.emplace(row.digests.windows + row.digests.selection, row.digests.manifest);
    for (const auto& [choice, digest] : used) by_choice[choice][digest].push_back(part.folder);
  }
  for (const auto& [choice, folders] : by_choice) {
    if (folders.size() < 2) continue;
    warnings.push_back(fmt::format(
        "Answers about different pictures are added up: {} sessions recorded different sets of pictures, {}.",
        format_experiment(experiment), list_folders(folders)));
  }
}

void warn_of_windows(std::vector<std::string>& warnings, const std::vector<PoolPart>& parts) {
  FoldersByDigest folders;
  for (const PoolPart& part : parts) {
    if (part.sources.windows) folders[part.sources.windows->digest].push_back(part.folder);
  }
  if (folders.size() < 2) return;
  warnings.push_back(
      fmt::format("The clamp windows differ between folders, so that levels of a column have answers of some "
                  "alone: {}.",
                  list_folders(folders)));
}

void pool_prompts(Prompts& all, const Prompts& part) {
  for (const auto& [language, prompts] : part) all[language].insert(prompts.begin(), prompts.end());
}

// What all folders have alike.
template <typename T>
void pool_if_same(std::optional<T>& all, const std::optional<T>& part) {
  if (!all || !part || all->digest != part->digest) all.reset();
}

}  // namespace

std::vector<std::string> find_pool_warnings(const std::vector<PoolPart>& parts) {
  std::vector<std::string> warnings;
  if (!warn_of_manifests(warnings, parts)) {
    for (const auto experiment : {Experiment::kArtifact, Experiment::kMaterial})
      warn_of_sessions(warnings, parts, experiment);
  }
  warn_of_windows(warnings, parts);
  return warnings;
}

ReportSources pool_sources(std::vector<ReportSources> parts, const std::vector<std::string>& folders) {
  EQ_CHECK(!parts.empty() && parts.size() == folders.size(), parts.size(), folders.size());
  ReportSources all = parts.front();
  pool_selections(all, parts, folders);
  for (std::size_t i = 1; i < parts.size(); ++i) {
    ReportSources& part = parts[i];
    pool_if_same(all.windows, part.windows);
    if (!are_same_pictures(all.manifest, part.manifest)) all.manifest.reset();
    pool_if_same(all.protocol, part.protocol);
    pool_if_same(all.truth, part.truth);
    pool_prompts(all.artifact_prompts, part.artifact_prompts);
    pool_prompts(all.material_prompts, part.material_prompts);
    for (ConvergenceExhibit& exhibit : part.convergences) all.convergences.push_back(std::move(exhibit));
  }
  return all;
}

}  // namespace equilux
