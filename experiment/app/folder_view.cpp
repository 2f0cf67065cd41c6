// Study, manifest, windows and log of a folder, as far as they are there.
#include "experiment/app/folder_view.h"

#include <fmt/format.h>

#include "base/files.h"

namespace equilux {

void read_coverage(const StudyFolder& folder, SubjectKind kind, FolderView& view) {
  view.artifact.clear();
  view.material.clear();
  if (!TrialLog::is_at(folder.responses())) return;
  const TrialLog log = TrialLog::load_snapshot(folder.responses());
  view.artifact = tally_coverage(log.load_answers(kind, Experiment::kArtifact));
  view.material = tally_coverage(log.load_answers(kind, Experiment::kMaterial));
}

FolderView read_folder_view(const StudyFolder& folder, SubjectKind kind) {
  FolderView view{load_folder_study(folder), {}, {}, {}, {}, {}};
  if (path_exists(folder.manifest())) view.manifest = load_manifest(folder.manifest());
  view.holding = find_holding(view.study, view.manifest, folder.root);
  if (path_exists(folder.windows())) view.windows = load_windows(folder.windows(), view.study);
  read_coverage(folder, kind, view);
  return view;
}

std::vector<std::int64_t> list_counts(const Study& study, const Object& object) {
  std::vector<std::int64_t> counts;
  for (const Column& column : enumerate_columns(study)) {
    if (column.object == object) counts.push_back(column.vpl_count);
  }
  return counts;
}

std::string describe_count(const Coverage& coverage, const Cell& cell, const char* name) {
  const auto found = coverage.find(cell);
  if (found == coverage.end()) return "";
  const CellCount& count = found->second;
  return fmt::format("{} {}/{}{}", name, count.right, count.answered,
                     4 * count.right >= 3 * count.answered ? "!" : "");
}

}  // namespace equilux
