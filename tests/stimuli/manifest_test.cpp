// manifest.json: round trip, what is refused, and the digest by which a session knows its pictures.
#include "stimuli/manifest.h"

#include <gtest/gtest.h>

#include "base/digest.h"
#include "base/error.h"
#include "base/files.h"
#include "tests/support/failures.h"
#include "tests/support/json_edit.h"
#include "tests/support/temp_folder.h"

namespace equilux {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

Manifest make_manifest() {
  Manifest manifest{"pocket", digest_text("study"), 7, 280, 210, {}, {}};
  manifest.tones["G0-MS-ind-ref-v0"] = {0.1, 3.25, 1e-7, 0.18, "background"};
  Json error;
  error.set("object_mean", 0.5).set("object_p99", 2.5).set("outside_mean", 1.25);
  for (const char* key : {"G0-MS-ind-ref-v0", "G0-MS-ind-1k-C0-v0", "G0-MS-ind-1k-C1-v0"}) {
    manifest.pictures[key] = {
        std::string("pictures/") + key + ".png", digest_text(key), digest_text("from"), {}};
  }
  manifest.pictures["G0-MS-ind-ref-v0"].standard_error = error;
  manifest.noise_target = NoiseTarget{3, 6, 5};
  return manifest;
}

class ManifestFile : public testing::Test {
 protected:
  ManifestFile() {
    save_manifest(make_manifest(), folder_ / "saved.json");
    json_ = parse_json(load_text(folder_ / "saved.json"), "saved.json");
  }
  std::string refusal_of(const Json& json) {
    const auto path = folder_.write("manifest.json", format_json(json));
    const std::string message = message_of<InputError>([&] { load_manifest(path); });
    EXPECT_THAT(message, StartsWith(path.string() + ": "));
    return message.substr(std::min(message.size(), path.string().size() + 2));
  }
  const TempFolder folder_;
  Json json_;
};

TEST_F(ManifestFile, RoundTrips) {
  const Manifest saved = make_manifest(), loaded = load_manifest(folder_ / "saved.json");
  EXPECT_EQ(loaded.study_name, saved.study_name);
  EXPECT_EQ(loaded.study_digest, saved.study_digest);
  EXPECT_EQ(loaded.seed, 7u);
  EXPECT_EQ(loaded.width, 280);
  EXPECT_EQ(loaded.height, 210);
  ASSERT_TRUE(loaded.noise_target);
  EXPECT_EQ(loaded.noise_target->object_p99, 6);
  EXPECT_EQ(loaded.tones, saved.tones);
  ASSERT_EQ(loaded.pictures.size(), 3u);
  for (const auto& [key, picture] : saved.pictures) {
    const PictureRecord& back = loaded.pictures.at(key);
    EXPECT_EQ(back.file, picture.file);
    EXPECT_EQ(back.digest, picture.digest);
    EXPECT_EQ(back.made_from, picture.made_from);
    EXPECT_EQ(back.standard_error, picture.standard_error);
  }
}

TEST_F(ManifestFile, GivesTheSameBytesWhenSavedAgain) {
  save_manifest(load_manifest(folder_ / "saved.json"), folder_ / "again.json");
  EXPECT_EQ(read_bytes(folder_ / "again.json"), read_bytes(folder_ / "saved.json"));
}

TEST_F(ManifestFile, WithoutAnyOneOfItsMembersNamesIt) {
  const Json blank = without(json_, "/noise_target");
  ASSERT_NO_THROW(load_manifest(folder_.write("blank.json", format_json(blank))))
      << "this one may be left out";
  for (const auto& [name, value] : blank.as_object())
    EXPECT_EQ(refusal_of(without(blank, "/" + name)), "/: expected a member \"" + name + "\", got none");
}

TEST_F(ManifestFile, OfAnotherKindOrANewerVersionIsRefused) {
  EXPECT_EQ(refusal_of(with(json_, "/schema_version", 2)), "/schema_version: expected 1, got 2");
  EXPECT_THAT(refusal_of(with(json_, "/schema", "equilux-layers")), StartsWith("/schema: "));
  EXPECT_THAT(refusal_of(with(json_, "/more", 1)), HasSubstr("\"more\""));
}

TEST_F(ManifestFile, WithAKeyTwiceIsRefused) {
  const Json& picture = json_.at("pictures").at(std::size_t{0});
  EXPECT_THAT(refusal_of(with(json_, "/pictures/-", picture)),
              AllOf(StartsWith("/pictures/3/key: "), HasSubstr("G0-MS-ind-1k-C0-v0 again")));
  const Json& tone = json_.at("tones").at(std::size_t{0});
  EXPECT_THAT(refusal_of(with(json_, "/tones/-", tone)),
              AllOf(StartsWith("/tones/1/family: "), HasSubstr("G0-MS-ind-ref-v0 again")));
}

TEST_F(ManifestFile, WithABadDigestIsRefused) {
  for (const std::string& digest :
       {std::string(), std::string(63, 'a'), std::string(65, 'a'), std::string(64, 'A'), std::string(64, 'g'),
        std::string(64, 'a') + "\n"}) {
    EXPECT_THAT(refusal_of(with(json_, "/pictures/1/digest", digest)), StartsWith("/pictures/1/digest: "));
    EXPECT_THAT(refusal_of(with(json_, "/study_digest", digest)), StartsWith("/study_digest: "));
  }
}

TEST_F(ManifestFile, WithAPathThatLeavesTheFolderIsRefused) {
  for (const char* file : {"../x.png", "pictures/../x.png", "/etc/x.png", "pictures//x.png",
                           "pictures/a/b.png", "pictures/..png", "x.png", "pictures/x.exr",
                           "pictures/x.png\n", "pictures/.png", "../a\npictures/x.png", "pictures/x.png/"})
    EXPECT_THAT(refusal_of(with(json_, "/pictures/1/file", file)), StartsWith("/pictures/1/file: ")) << file;
}

TEST_F(ManifestFile, WithNumbersOutOfRangeIsRefused) {
  EXPECT_THAT(refusal_of(with(json_, "/width", 0)), StartsWith("/width: "));
  EXPECT_THAT(refusal_of(with(json_, "/seed", -1)), StartsWith("/seed: "));
  EXPECT_THAT(refusal_of(with(json_, "/tones/0/log_average", 0)), StartsWith("/tones/0/log_average: "));
  EXPECT_THAT(refusal_of(with(json_, "/tones/0/exposure", "all")), StartsWith("/tones/0/exposure: "));
  EXPECT_THAT(refusal_of(without(json_, "/pictures/2/standard_error/object_p99")),
              StartsWith("/pictures/2/standard_error: "));
}

TEST_F(ManifestFile, ThatCannotBeReadOrWrittenIsNamed) {
  EXPECT_THROW(load_manifest(folder_ / "missing.json"), InputError);
  EXPECT_THROW(load_manifest(folder_.path()), InputError);
  EXPECT_THAT(message_of<InputError>([&] { load_manifest(folder_.write("m.json", "{\"schema\":")); }),
              HasSubstr("m.json: line 1"));
  EXPECT_THROW(save_manifest(make_manifest(), folder_ / "missing/m.json"), StoreError);
}

// More than other files may have; the largest study's manifest has 125 MiB.
TEST_F(ManifestFile, OfManyPicturesSavesAndLoadsAgain) {
  Manifest manifest = make_manifest();
  Json check{Json::Array{}};
  for (int i = 0; i < 10; ++i) {
    Json row;
    row.set("region", "whole").set("pixels", 12345).set("mean", 0.123456789 + i).set("standard_error", 0.1);
    row.set("path_traced", 0.123456789).set("path_traced_error", 0.1).set("z", -0.123456789);
    check.push(std::move(row));
  }
  Json reference;
  reference.set("method", "compensated").set("paths", 2000).set("check", std::move(check));
  for (int i = 0; i < 23'000; ++i) {
    const std::string key = fmt::format("Geometry{}-MS-ind-ref-v0", i);
    manifest.pictures[key] = {
        "pictures/" + key + ".png", digest_text(key), digest_text("from"), {}, reference};
  }
  save_manifest(manifest, folder_ / "m.json");
  ASSERT_GT(std::filesystem::file_size(folder_ / "m.json"), std::size_t{64} << 20);
  EXPECT_EQ(load_manifest(folder_ / "m.json").pictures.size(), manifest.pictures.size());
}

TEST(DigestPictures, DependsOnThePicturesAndNotOnTheirOrder) {
  Manifest manifest = make_manifest();
  const std::string a = "G0-MS-ind-1k-C0-v0", b = "G0-MS-ind-1k-C1-v0", c = "G0-MS-ind-ref-v0";
  const std::string digest = digest_pictures(manifest, {a, b}, "m");
  EXPECT_EQ(digest_pictures(manifest, {b, a}, "m"), digest);
  EXPECT_EQ(digest_pictures(manifest, {b, a, b}, "m"), digest);
  EXPECT_NE(digest_pictures(manifest, {a, b, c}, "m"), digest);
  EXPECT_NE(digest_pictures(manifest, {a}, "m"), digest);
  manifest.pictures[c].digest = digest_text("other");
  EXPECT_EQ(digest_pictures(manifest, {a, b}, "m"), digest)
      << "a picture that is not shown has no part in it";
  manifest.pictures[b].digest = digest_text("other");
  EXPECT_NE(digest_pictures(manifest, {a, b}, "m"), digest);
}

TEST(DigestPictures, NamesTheFirstPictureThatIsMissing) {
  EXPECT_THAT(message_of<InputError>([] {
                digest_pictures(make_manifest(), {"G0-MS-ind-1k-C0-v0", "G9-MS-ind-1k-C0-v0"}, "m.json");
              }),
              AllOf(StartsWith("m.json: /pictures: "), HasSubstr("the picture G9-MS-ind-1k-C0-v0")));
}

}  // namespace
}  // namespace equilux
