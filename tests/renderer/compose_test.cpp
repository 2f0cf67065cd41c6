// Layers of strangers: whole, finite, and of no picture.
#include "renderer/compose.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>

#include "base/error.h"
#include "base/files.h"
#include "base/memory.h"
#include "renderer/set.h"
#include "renderer/sheet_cells.h"
#include "tests/renderer/rendered_set.h"
#include "tests/support/failures.h"

namespace equilux {
namespace {
using testing::HasSubstr;

class Compose : public test::RenderedSet {
 protected:
  void fill(const std::string& layer, float value) const {
    change_layer(layer, [&](HdrImage& image) { image.values.assign(image.values.size(), value); });
  }
  // Of the family of MS, ind, v0, before any of its pictures is made anew.
  void expect_refused(const std::string& why) const {
    const auto before = test::digest_products(folder_.picture_folder());
    EXPECT_THAT(message_of<InputError>([&] { tonemap_set(folder_.root, "G0-MS-ind-*-v0"); }), HasSubstr(why));
    EXPECT_EQ(test::digest_products(folder_.picture_folder()), before);
    EXPECT_THAT(find(), testing::Contains(HasSubstr(why)));
  }
};

TEST_F(Compose, RefusesASumThatIsNotFinite) {
  fill("G0-MS-ind-ref-v0.background", 3e38f);
  fill("G0-MS-ind-ref-v0.direct", 3e38f);
  expect_refused(
      "layers/G0-MS-ind-ref-v0.*.exr: pixel (0, 0): expected a finite sum of background and direct, got inf");
  fill("G0-MS-ind-ref-v0.direct", 0);
  fill("G0-MS-ind-ref-v0.indirect", 3e38f);
  expect_refused("expected a finite sum of background, direct and indirect");
  fill("G0-MS-ind-ref-v0.indirect", 0);
  fill("G0-MS-ind-ref-v0.standard_error", 3e38f);
  expect_refused("expected a finite sum with the standard error");
}

TEST_F(Compose, RefusesAVplLayerWhoseSumIsNotFinite) {
  fill("G0-MS-ind-ref-v0.background", 1e38f);
  tonemap_set(folder_.root, "G0-MS-ind-ref-v0");
  fill("G0-MS-ind-100-C4-v0", 3e38f);
  change_manifest([](Manifest& manifest) { manifest.pictures.erase("G0-MS-ind-100-C4-v0"); });
  EXPECT_THAT(
      message_of<InputError>([&] { tonemap_set(folder_.root, "G0-MS-ind-100-C4-v0"); }),
      HasSubstr("layers/G0-MS-ind-100-C4-v0.exr: pixel (0, 0): expected a finite sum with its reference's"));
}

// Of a positive mean, so that a curve is made of it.
TEST_F(Compose, RefusesLightBelowNothing) {
  for (const char* content : {"background", "coverage", "direct", "indirect", "standard_error"}) {
    const std::string layer = std::string("G0-MS-ind-ref-v0.") + content;
    float before = 0;
    change_layer(layer, [&](HdrImage& image) { before = std::exchange(image.values.back(), -0.25f); });
    expect_refused(layer + ".exr: pixel (23, 17): expected a value of 0 or more, got -0.25");
    change_layer(layer, [&](HdrImage& image) { image.values.back() = before; });
  }
}

// Said with the folder's name before a layer is read. 16384 x 16384 pixels take 45 GiB.
TEST_F(Compose, AsksForTheMemoryOfAFamily) {
  Json json = parse_json(load_text(folder_.study()), "study");
  json.set("image", parse_json(R"({"width": 16384, "height": 16384})", ""));
  save_text(folder_.study(), format_json(json));
  const Study study = load_folder_study(folder_);
  const auto there = find_available_memory();
  if (!there || *there > estimate_family_memory(study)) GTEST_SKIP() << "this machine has too much";
  change_manifest([&](Manifest& manifest) {
    manifest.study_digest = study.digest;
    manifest.width = manifest.height = 16384;
  });
  const auto expect_asked = [&](const auto& body) {
    EXPECT_THAT(message_of<InputError>(body),
                HasSubstr(folder_.root.string() + ": pictures of 16384 x 16384 pixels: "
                                                  "expected about 45.0 GiB of memory, got "));
  };
  expect_asked([&] { verify_set(folder_.root, {}); });
  expect_asked([&] { tonemap_set(folder_.root); });
  const SheetSource source = open_sheet_source(folder_.root);
  expect_asked([&] {
    load_cell(source, {CellKind::kError, "G0-MS-ind-ref-v0", parse_family("G0-MS-ind-ref-v0", "test")}, {},
              {}, {});
  });
}

}  // namespace
}  // namespace equilux
