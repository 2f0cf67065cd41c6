// The folder that a user carries around: names of what stands in it.
#pragma once

#include <filesystem>
#include <string>

#include "protocols/experiment.h"
#include "protocols/study.h"
#include "protocols/truth.h"
#include "protocols/windows.h"

namespace equilux {

struct StudyFolder {
  std::filesystem::path root;

  std::filesystem::path study() const { return root / "study.json"; }  ///< copy of the study file
  std::filesystem::path windows() const {
    return root / "windows.json";
  }  ///< copied once, then a person's to edit
  std::filesystem::path truth() const { return root / "truth.json"; }  ///< copy of the default planted truth
  std::filesystem::path session() const {
    return root / "session.json";
  }  ///< copied once, then a person's to edit; may be missing
  std::filesystem::path layer_folder() const { return root / "layers"; }  ///< EXR
  std::filesystem::path layers() const { return root / "layers.json"; }   ///< what was rendered
  std::filesystem::path pending_layers() const {
    return root / "layers.pending.json";
  }  ///< records that layers.json does not have yet
  std::filesystem::path rooms() const { return root / "rooms"; }         ///< stages of one being made
  std::filesystem::path timing() const { return root / "timing.json"; }  ///< outside all digests
  std::filesystem::path log() const { return root / "render.log"; }      ///< outside all digests
  std::filesystem::path jobs() const { return root / "jobs"; }           ///< shares not yet gathered
  std::filesystem::path job(const std::string& name) const { return jobs() / name; }  ///< a study folder
  std::filesystem::path picture_folder() const { return root / "pictures"; }          ///< PNG
  std::filesystem::path manifest() const { return root / "manifest.json"; }           ///< what may be shown
  std::filesystem::path verdict() const { return root / "verdict.json"; }             ///< see verdict.h
  std::filesystem::path changing() const { return root / "changing.txt"; }            ///< see change_mark.h
  std::filesystem::path responses() const { return root / "responses.sqlite"; }
  std::filesystem::path selection(SubjectKind kind) const {
    return root / ("selection-" + format_kind(kind) + ".json");
  }
  std::filesystem::path convergence_folder() const {
    return root / "convergence";
  }  ///< of equilux-render converge
  std::filesystem::path report_folder() const { return root / "report"; }
};

/// The study of a folder, its windows and truth being the folder's own. errors: InputError, also where `root`
/// is no study folder and where its study extends another.
Study load_folder_study(const StudyFolder& folder);

}  // namespace equilux
