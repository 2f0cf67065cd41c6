// The layers of a study folder: which are whole, and writing the others.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "stimuli/exr_file.h"
#include "stimuli/layers.h"
#include "stimuli/study_folder.h"

namespace equilux {

/// What a VPL layer's record says beside its file, see LayerRecord.
struct VplRecord {
  std::int64_t count = 0;
  Json vpls, errors_1e5;
};

/// Keeps the records in step with the files. Those of the last groups that were saved stand in
/// layers.pending.json, each before its file has its name: whatever stands when a run is killed is on record.
class LayerStore {
 public:
  /// Opens what an earlier run left, pending records of files that they are true of with it. errors:
  /// InputError if layers.json is damaged.
  LayerStore(StudyFolder folder, const Study& study);

  /// True if the layer is on disk as recorded and was made from this recipe. Its file is
  /// read, the first time, to check its digest; of one that cannot be read there is a warning.
  bool is_whole(const std::string& name, const std::string& recipe);

  /// True if a layer of this name is recorded with another recipe.
  bool is_other(const std::string& name, const std::string& recipe) const;

  void save(const std::string& name, const std::string& recipe, const HdrImage& image, ExrMetadata metadata,
            const VplRecord& vpls = {}, Json reference = {});

  /// Takes over a layer that is whole in another folder and was made from this recipe, as a hard link where
  /// the file system has them. False where there is none. errors: StoreError
  bool adopt(const std::string& name, const std::string& recipe, LayerStore& from);

  const StudyFolder& folder() const { return folder_; }

  /// Layers recorded here, by name.
  const std::map<std::string, LayerRecord>& records() const { return layers_.by_name; }

  /// Writes layers.json. Called at the end.
  void save_record();

  /// The same after a group of layers, where those that are pending are more than the root of all:
  /// layers.json grows with the set, and to write it after each would take time that goes with the set's
  /// square.
  void save_group();

  /// errors: InputError if it is not there, its bytes are not those recorded, or its size not the study's
  HdrImage load(const std::string& name) const;
  const LayerRecord& record(const std::string& name) const;

  /// Of layers whose files could not be read, which count as missing.
  std::vector<std::string> warnings() const;

 private:
  bool has_digest(const std::string& name, const LayerRecord& layer);
  void take_up_pending();

  StudyFolder folder_;
  int width_, height_;
  Layers layers_, pending_;
  std::set<std::string> whole_;                    // whose files were read
  std::map<std::string, std::string> unreadable_;  // why, by layer
};

}  // namespace equilux
