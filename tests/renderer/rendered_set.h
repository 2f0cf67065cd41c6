// A set that is rendered once for all tests of a suite, each of which tampers with a copy.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/digest.h"
#include "renderer/set.h"
#include "renderer/verify.h"
#include "stimuli/exr_file.h"
#include "stimuli/layers.h"
#include "stimuli/manifest.h"
#include "stimuli/origin.h"
#include "tests/renderer/tiny_study.h"
#include "tests/support/temp_folder.h"

namespace equilux::test {

class RenderedSet : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    master_ = std::make_unique<TinyStudy>();
    SetParams params;
    params.study_path = master_->path();
    params.folder = master_->folder() / "set";
    make_set(params);
  }
  static void TearDownTestSuite() { master_.reset(); }

  RenderedSet() : study_(own_.path(), 1), folder_{study_.folder() / "set"} {
    std::filesystem::copy(master_->folder() / "set", folder_.root, std::filesystem::copy_options::recursive);
  }

  std::vector<std::string> find(const std::optional<std::filesystem::path>& study = {}) const {
    std::vector<std::string> lines;
    for (const Finding& finding : verify_set(folder_.root, study).findings)
      lines.push_back(format_finding(finding));
    return lines;
  }

  // The only thing that is found.
  void expect_only(const std::string& what) const {
    const auto lines = find();
    ASSERT_EQ(lines.size(), 1u) << testing::PrintToString(lines);
    EXPECT_THAT(lines[0], testing::HasSubstr(what));
  }

  template <typename Change>
  void change_manifest(const Change& change) const {
    Manifest manifest = load_manifest(folder_.manifest());
    change(manifest);
    save_manifest(manifest, folder_.manifest());
  }

  // A layer and its record.
  template <typename Change>
  void change_layer(const std::string& name, const Change& change) const {
    const std::filesystem::path path = folder_.root / "layers" / (name + ".exr");
    ExrFile file = load_exr(path);
    change(file.image);
    save_exr(file.image, file.metadata, path);
    Layers layers = load_layers(folder_.layers());
    layers.by_name.at(name).digest = digest_file(path);
    save_records(layers);
  }

  // As if pictures had been made from what the records say.
  void save_records(const Layers& layers) const {
    save_layers(layers, folder_.layers());
    change_manifest([&](Manifest& manifest) {
      for (auto& [key, record] : manifest.pictures) {
        const bool is_reference = key.find("-ref-") != std::string::npos;
        const Family family =
            is_reference ? parse_family(key, "test") : family_of(parse_condition(key, "test"));
        const ToneRecord& tone = manifest.tones.at(format_key(family));
        record.reference = is_reference ? tell_picture_reference(layers.by_name, family) : Json();
        record.vpls = is_reference ? Json() : tell_picture_vpls(layers.by_name, parse_condition(key, "test"));
        record.made_from = is_reference ? digest_reference(layers.by_name, tone, family)
                                        : digest_picture(layers.by_name, tone, parse_condition(key, "test"));
      }
    });
  }

  static inline std::unique_ptr<TinyStudy> master_;  // rendered once
  const TempFolder own_;
  const TinyStudy study_;
  const StudyFolder folder_;
};

}  // namespace equilux::test
