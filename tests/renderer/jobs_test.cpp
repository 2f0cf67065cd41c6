// Shares of a set and their gathering: the bytes of one process, whatever is lost on the way.
#include "renderer/jobs.h"

#include <algorithm>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/mount.h>
#include <thread>
#include <unistd.h>

#include "base/error.h"
#include "base/files.h"
#include "base/folder_lock.h"
#include "renderer/set.h"
#include "renderer/submit.h"
#include "renderer/timing.h"
#include "stimuli/exr_file.h"
#include "stimuli/layers.h"
#include "tests/renderer/tiny_study.h"
#include "tests/support/failures.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;
using test::digest_products;
using testing::AllOf;
using testing::HasSubstr;

SetParams params_of(const test::TinyStudy& study, const std::string& out) {
  SetParams params;
  params.study_path = study.path();
  params.folder = study.folder() / out;
  return params;
}

SetSummary render_share(const test::TinyStudy& study, const std::string& out, int index, int count) {
  SetParams params = params_of(study, out);
  params.job = JobShare{index, count};
  return make_set(params);
}

SetSummary gather(const test::TinyStudy& study, const std::string& out) {
  SetParams params = params_of(study, out);
  params.render = false;
  return make_set(params);
}

std::vector<int> find_unfinished(const test::TinyStudy& study, const std::string& out, int count) {
  SubmitParams params;
  params.study_path = study.path();
  params.folder = study.folder() / out;
  params.count = count;
  return equilux::find_unfinished(params);
}

TEST(Jobs, AreNamedByIndexAndCount) {
  EXPECT_EQ(format_job_folder(parse_job("3/16")), "3-of-16");
  for (const char* text : {"", "3", "/", "3/", "/3", "0/3", "4/3", "-1/3", "1/3x", "x1/3", "1/3/5", "1.5/3",
                           "1/99999999999", "1/10001", " 1/3"})
    EXPECT_THAT(message_of<InputError>([&] { parse_job(text); }), HasSubstr("--job: expected I/N")) << text;
}

class EveryMethod : public testing::TestWithParam<const char*> {};

// Plain sums beside path-traced references; cuts of 30,000 VPLs beside references by VPL sets and
// compensation.
INSTANTIATE_TEST_SUITE_P(Jobs, EveryMethod, testing::Values("", "compensated-many"), [](const auto& row) {
  return std::string(row.param).empty() ? "Sums" : "CutsAndCompensation";
});

TEST_P(EveryMethod, GatheredIsByteForByteWhatOneProcessMakes) {
  const test::TinyStudy study(GetParam());
  make_set(params_of(study, "whole"));
  const auto whole = digest_products(study.folder() / "whole");
  int not_empty = 0;
  for (const int index : {2, 3, 1}) {
    const SetSummary share = render_share(study, "shares", index, 3);
    not_empty += share.layers_rendered > 0 ? 1 : 0;
    EXPECT_EQ(share.pictures_written, 0u);
  }
  EXPECT_GE(not_empty, 2) << "the set has two objects in views at least";
  EXPECT_FALSE(path_exists(study.folder() / "shares/manifest.json"));
  const SetSummary gathered = gather(study, "shares");
  EXPECT_EQ(gathered.layers_rendered, 0u);
  EXPECT_EQ(digest_products(study.folder() / "shares"), whole);
  EXPECT_FALSE(path_exists(study.folder() / "shares/jobs")) << "what is gathered is not kept twice";
  EXPECT_EQ(load_timing({study.folder() / "shares"}).as_array().size(), not_empty + 1u)
      << "of the shares and the last";
  EXPECT_EQ(gather(study, "shares").pictures_written, 0u) << "gathering again changes nothing";
}

TEST(Jobs, ThatWereLostOrDamagedAloneAreDoneAgain) {
  const test::TinyStudy study;
  make_set(params_of(study, "whole"));
  EXPECT_EQ(find_unfinished(study, "shares", 3), (std::vector<int>{1, 2, 3}));
  render_share(study, "shares", 1, 3);
  render_share(study, "shares", 3, 3);
  EXPECT_EQ(find_unfinished(study, "shares", 3), (std::vector<int>{2}));
  EXPECT_THAT(message_of<InputError>([&] { gather(study, "shares"); }),
              HasSubstr("expected every share of the set, rendered"));
  EXPECT_EQ(find_unfinished(study, "shares", 3), (std::vector<int>{2})) << "what was there is gathered";
  render_share(study, "shares", 2, 3);
  const fs::path layers = study.folder() / "shares/jobs/2-of-3/layers";
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(layers)) files.push_back(entry.path());
  const fs::path victim = *std::max_element(files.begin(), files.end());
  fs::resize_file(victim, fs::file_size(victim) / 2);
  EXPECT_EQ(find_unfinished(study, "shares", 3), (std::vector<int>{2}));
  const SetSummary again = render_share(study, "shares", 2, 3);
  EXPECT_GT(again.layers_rendered, 0u);
  EXPECT_LT(again.layers_rendered, files.size()) << "what was whole is not redone";
  EXPECT_EQ(find_unfinished(study, "shares", 3), std::vector<int>());
  gather(study, "shares");
  EXPECT_EQ(digest_products(study.folder() / "shares"), digest_products(study.folder() / "whole"));
}

TEST(Jobs, OfWhatTheSetHasAreEmpty) {
  const test::TinyStudy study;
  make_set(params_of(study, "set"));
  const auto before = digest_products(study.folder() / "set");
  const SetSummary share = render_share(study, "set", 1, 2);
  EXPECT_EQ(share.layers_rendered, 0u);
  EXPECT_GT(share.layers_adopted, 0u);
  const SetSummary most = render_share(study, "set", 50, 50);
  EXPECT_EQ(most.layers_rendered + most.layers_adopted, 0u) << "more shares than work";
  EXPECT_THAT(format_summary(most), HasSubstr("warning: share 50 of 50 holds nothing"));
  gather(study, "set");
  EXPECT_EQ(digest_products(study.folder() / "set"), before);
}

TEST(Jobs, LeaveAShareAloneThatIsBeingRendered) {
  const test::TinyStudy study;
  render_share(study, "set", 1, 2);
  const fs::path folder = study.folder() / "set/jobs/1-of-2";
  const FolderLock lock(folder);
  SetParams params = params_of(study, "set");
  const SetSummary summary = make_set(params);
  ASSERT_EQ(summary.warnings.size(), 1u);
  EXPECT_THAT(summary.warnings[0],
              HasSubstr(fmt::format("still being rendered by process {} on ", ::getpid())));
  EXPECT_EQ(summary.layers_adopted, 0u);
  EXPECT_TRUE(path_exists(folder / "layers.json"));
  SubmitParams submit;
  submit.folder = study.folder() / "set";
  submit.count = 2;
  EXPECT_EQ(find_running(submit, {1, 2}), std::vector<int>{1});
}

// Somebody's own folder, a share without records, one with damaged records, one of another scene: each is
// named and stays, and the good one beside them is gathered.
TEST(Jobs, ThatCannotBeGatheredStayAndAreNamed) {
  const test::TinyStudy study;
  const fs::path jobs = study.folder() / "set/jobs";
  for (const int index : {1, 2, 3, 4}) render_share(study, "set", index, 4);
  fs::create_directories(jobs / "notes");
  save_text(jobs / "notes/mine.txt", "precious");
  fs::remove(jobs / "1-of-4/layers.json");
  save_text(jobs / "2-of-4/layers.json", "{");
  Layers other = load_layers(jobs / "3-of-4/layers.json");
  const std::string changed = other.by_name.begin()->first;
  other.by_name.begin()->second.made_from = digest_text("another");
  save_layers(other, jobs / "3-of-4/layers.json");
  save_text(jobs / "4-of-4/timing.json", "[]");
  const std::string refusal = message_of<InputError>([&] { gather(study, "set"); });
  EXPECT_THAT(refusal,
              AllOf(HasSubstr("1-of-4: no layer is recorded there"), HasSubstr("2-of-4/layers.json: line 1"),
                    HasSubstr("3-of-4: " + changed + " is damaged or made from another"),
                    HasSubstr("4-of-4/timing.json")));
  for (const char* kept : {"notes/mine.txt", "1-of-4/layers", "2-of-4/layers", "3-of-4/layers"})
    EXPECT_TRUE(path_exists(jobs / kept)) << kept;
  const SetSummary whole = make_set(params_of(study, "set"));
  EXPECT_EQ(whole.warnings.size(), 3u);
  EXPECT_FALSE(path_exists(jobs / "1-of-4")) << "of a whole set";
  for (const int index : {2, 3}) fs::remove_all(jobs / fmt::format("{}-of-4", index));
  fs::remove(jobs / "4-of-4/timing.json");
  EXPECT_EQ(gather(study, "set").warnings, std::vector<std::string>());
  EXPECT_TRUE(path_exists(jobs / "notes/mine.txt"));
}

TEST(Jobs, ChangeNoLayerOfASetThatWasShown) {
  const test::TinyStudy study;
  make_set(params_of(study, "set"));
  render_share(study, "set", 1, 1);
  Layers layers = load_layers(study.folder() / "set/layers.json");
  layers.by_name.at("G0-GS-dir-100-C3-v0").made_from = digest_text("another");
  save_layers(layers, study.folder() / "set/layers.json");
  save_text(study.folder() / "set/responses.sqlite", "");
  SetParams params = params_of(study, "set");
  params.only = "G0-MS-ind-*";
  EXPECT_THAT(message_of<InputError>([&] { make_set(params); }),
              AllOf(HasSubstr("what its sessions have seen"), HasSubstr("another G0-GS-dir-100-C3-v0")));
  EXPECT_TRUE(path_exists(study.folder() / "set/jobs/1-of-1/layers.json"));
}

TEST(Jobs, OfAnotherStudyAreRefused) {
  const test::TinyStudy study, other(study.folder(), 2);
  render_share(study, "set", 1, 2);
  EXPECT_THAT(message_of<InputError>([&] { render_share(other, "set", 2, 2); }),
              HasSubstr("expected the folder of this study"));
}

TEST(Set, ThatAnotherProcessWritesIsRefused) {
  const test::TinyStudy study;
  fs::create_directory(study.folder() / "set");
  const FolderLock lock(study.folder() / "set");
  EXPECT_FALSE(lock.is_busy());
  EXPECT_TRUE(FolderLock(study.folder() / "set").is_busy());
  SetParams params = params_of(study, "set");
  params.patience = std::chrono::milliseconds(0);
  EXPECT_THAT(message_of<InputError>([&] { make_set(params); }),
              AllOf(HasSubstr("expected a folder that nobody else writes"),
                    HasSubstr(fmt::format("process {} on ", ::getpid()))));
  EXPECT_FALSE(path_exists(study.folder() / "set/study.json"));
}

// Who submits or gathers holds the lock of a share for an instant, to see whether it is free.
TEST(Jobs, WaitForTheLockOfAShareThatIsOnlyLookedAt) {
  const test::TinyStudy study;
  const fs::path share = study.folder() / "set/jobs/50-of-50";
  fs::create_directories(share);
  auto look = std::make_unique<FolderLock>(share);
  std::thread end([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(1500));  // set is there after half of it
    look.reset();
  });
  EXPECT_NO_THROW(render_share(study, "set", 50, 50)) << "which has no work";
  end.join();
}

// Full at 300 bytes (the first text), 2,500 (the first layer) and 20,000 (layers.json, after a family): at
// each place the error names a file, no half file stands under its name, and the set is completed later.
TEST(Set, OnAFullDiskSaysSoAndIsCompletedLater) {
  const test::TinyStudy study;
  make_set(params_of(study, "whole"));
  for (const int bytes : {300, 2500, 20000}) {
    std::string message;
    {
      const FileSizeLimit full(static_cast<rlim_t>(bytes));
      message = message_of<StoreError>([&] { make_set(params_of(study, "set")); });
    }
    EXPECT_THAT(message, AllOf(HasSubstr((study.folder() / "set").string()), HasSubstr("File too large")))
        << bytes;
    for (const auto& entry : fs::recursive_directory_iterator(study.folder() / "set")) {
      EXPECT_NE(entry.path().extension(), ".part") << entry.path();
      if (entry.path().extension() == ".exr") {
        EXPECT_NO_THROW(load_exr(entry.path()));
      }
    }
  }
  make_set(params_of(study, "set"));
  EXPECT_EQ(digest_products(study.folder() / "set"), digest_products(study.folder() / "whole"));
}

// A file system of its own, as large as one likes. Only root may have one.
class SmallDisk {
 public:
  explicit SmallDisk(const fs::path& at) : at_(at) {
    fs::create_directories(at);
    is_there_ = ::mount("tmpfs", at_.c_str(), "tmpfs", 0, "size=64k") == 0;
  }
  ~SmallDisk() {
    if (is_there_) ::umount2(at_.c_str(), MNT_DETACH);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

  bool is_there() const { return is_there_; }
  bool resize(int kib) const {
    return ::mount("tmpfs", at_.c_str(), "tmpfs", MS_REMOUNT, fmt::format("size={}k", kib).c_str()) == 0;
  }

 private:
  fs::path at_;
  bool is_there_ = false;
};

// Before the first reference, not hours later; and larger, it goes on.
TEST(Set, OnADiskThatIsTooSmallSaysSoBeforeTheWork) {
  const test::TinyStudy study;
  const SmallDisk disk(study.folder() / "disk");
  if (!disk.is_there()) GTEST_SKIP() << "no file system can be mounted here";
  for (const int kib : {128, 256, 512}) {
    ASSERT_TRUE(disk.resize(kib));
    EXPECT_THAT(message_of<InputError>([&] { make_set(params_of(study, "disk/set")); }),
                AllOf(HasSubstr("disk/set: expected about 1.1 MiB free on its disk, got 0."),
                      HasSubstr("what is rendered already stays")))
        << kib;
    for (const auto& entry : fs::recursive_directory_iterator(study.folder() / "disk"))
      EXPECT_NE(entry.path().extension(), ".exr") << entry.path();
  }
  ASSERT_TRUE(disk.resize(1 << 16));
  EXPECT_GT(make_set(params_of(study, "disk/set")).pictures_written, 0u);
}

// The same on a disk that others fill meanwhile, until no block is left.
TEST(Set, OnADiskWithoutBlocksSaysSoAndIsCompletedLater) {
  const test::TinyStudy study;
  const SmallDisk disk(study.folder() / "disk");
  if (!disk.is_there()) GTEST_SKIP() << "no file system can be mounted here";
  make_set(params_of(study, "whole"));
  ASSERT_TRUE(disk.resize(1 << 16));
  const StudyFolder folder{study.folder() / "disk/set"};
  make_set(params_of(study, "disk/set"));
  const fs::path others = study.folder() / "disk/others";
  for (const int kib : {8, 32, 128}) {
    fs::remove_all(folder.picture_folder());
    save_text(others, std::string(fs::space(folder.root).available - 1024 * static_cast<unsigned>(kib), 'x'));
    EXPECT_THAT(message_of<StoreError>([&] { tonemap_set(folder.root); }),
                HasSubstr("No space left on device"))
        << kib;
    for (const auto& entry : fs::recursive_directory_iterator(study.folder() / "disk"))
      EXPECT_NE(entry.path().extension(), ".part") << entry.path();
    fs::remove(others);
  }
  make_set(params_of(study, "disk/set"));
  EXPECT_EQ(digest_products(folder.root), digest_products(study.folder() / "whole"));
}

// As somebody whom permissions stop, which root is not.
class Nobody {
 public:
  Nobody() { EQ_CHECK(::geteuid() != 0 || ::seteuid(65534) == 0); }
  ~Nobody() {
    if (::getuid() == 0) EQ_CHECK(::seteuid(0) == 0);
  }
};

TEST(Set, InAFolderThatIsOnlyToBeReadSaysSo) {
  const test::TinyStudy study;
  fs::permissions(study.folder(), fs::perms(0755));
  fs::create_directory(study.folder() / "set");
  fs::permissions(study.folder() / "set", fs::perms(0555));
  std::string message;
  {
    const Nobody nobody;
    message = message_of<StoreError>([&] { make_set(params_of(study, "set")); });
  }
  EXPECT_THAT(message, AllOf(HasSubstr((study.folder() / "set").string()), HasSubstr("Permission denied")));
}

TEST(Set, TakesOverLayersThatAnotherStudyMadeFromTheSame) {
  const test::TinyStudy study;
  make_set(params_of(study, "set"));
  Json json = study.load().source;
  json.set("name", "other")
      .set("blocks", parse_json(R"([{"geometries":["G0"],"materials":["MS","GS","BR"],
                                   "illuminations":["ind"],"vpl_counts":["100"]}])",
                                ""));
  SetParams params;
  params.study_path = study.folder() / "other.json";
  json.set("windows", "other-windows.json").set("truth", "other-truth.json");
  Json windows{Json::Array{}}, truth{Json::Array{}};
  for (const char* column : {"G0-MS-ind-100", "G0-GS-ind-100", "G0-BR-ind-100"}) {
    windows.push(Json().set("column", column).set("first", "C2").set("origin", "placeholder"));
    truth.push(Json().set("column", column).set("artifact_free_from", "C4").set("material_same_to", "C6"));
  }
  save_text(params.study_path, format_json(json));
  Json files = parse_json(load_text(study.folder() / "windows.json"), "");
  save_text(study.folder() / "other-windows.json", format_json(files.set("windows", windows)));
  files = parse_json(load_text(study.folder() / "truth.json"), "");
  save_text(study.folder() / "other-truth.json", format_json(files.set("columns", truth)));
  params.folder = study.folder() / "alone";
  const SetSummary alone = make_set(params);
  params.folder = study.folder() / "with";
  params.reuse = {study.folder() / "set"};
  const SetSummary with = make_set(params);
  EXPECT_EQ(alone.layers_adopted, 0u);
  EXPECT_EQ(with.layers_rendered + with.layers_adopted, alone.layers_rendered);
  EXPECT_EQ(with.layers_rendered * 3, alone.layers_rendered) << "only BR is new";
  EXPECT_EQ(digest_products(study.folder() / "with/pictures"),
            digest_products(study.folder() / "alone/pictures"));
  // What is taken over is on record before anything is rendered: the run may be killed there.
  const StudyFolder stopped{params.folder = study.folder() / "stopped"};
  fs::create_directories(stopped.root / "layers/G0-BR-ind-ref-v0.background.exr/in-the-way");
  EXPECT_THROW(make_set(params), StoreError);
  EXPECT_EQ(load_layers(stopped.layers()).by_name.size(), with.layers_adopted);
  fs::rename(study.folder() / "set/layers", study.folder() / "elsewhere");
  fs::create_directory_symlink("../elsewhere", study.folder() / "set/layers");
  for (const auto& entry : fs::directory_iterator(study.folder() / "elsewhere")) {
    const fs::path file = entry.path().filename();
    fs::rename(entry.path(), study.folder() / file);
    fs::create_symlink("../" + file.string(), entry.path());
  }
  params.folder = study.folder() / "links";
  EXPECT_EQ(make_set(params).layers_adopted, with.layers_adopted);
  for (const auto& entry : fs::directory_iterator(study.folder() / "links/layers"))
    EXPECT_FALSE(entry.is_symlink()) << entry.path();
  params.reuse = {study.folder() / "none"};
  EXPECT_THAT(message_of<InputError>([&] { make_set(params); }), HasSubstr("expected a study folder"));
}

TEST(Set, ShowsLayersByAnotherToneMappingWithoutRendering) {
  const test::TinyStudy study("many");
  SetParams params = params_of(study, "set");
  params.only = "G0-MS-ind-*";
  const SetSummary first = make_set(params);
  Json json;
  json.set("extends", study.path().filename().string()).set("name", "retoned");
  json.set("tone_operator", "local").set("tone_key", 0.3).set("exposure", "whole");
  const Json by_itself = json;
  json.set("planned_tone", parse_json(R"({"tone_key":0.18,"exposure":"background"})", ""));
  const auto make = [&](const char* name, const Json& file) {
    SetParams other = params;
    other.study_path = study.folder() / (std::string(name) + ".json");
    save_text(other.study_path, format_json(file));
    other.folder = study.folder() / name;
    other.reuse = {params.folder};
    return make_set(other);
  };
  const SetSummary retoned = make("retoned", json);
  EXPECT_EQ(retoned.layers_rendered, 0u);
  EXPECT_EQ(retoned.layers_adopted, first.layers_rendered);
  EXPECT_EQ(retoned.pictures_written, first.pictures_written);
  const Manifest before = load_manifest(params.folder / "manifest.json"),
                 after = load_manifest(study.folder() / "retoned/manifest.json");
  for (const auto& [key, record] : before.pictures) EXPECT_NE(after.pictures.at(key).digest, record.digest);
  EXPECT_EQ(after.tones.at("G0-MS-ind-ref-v0").tone_operator, "local");
  EXPECT_EQ(before.tones.at("G0-MS-ind-ref-v0").tone_operator, "global");
  // A study that does not say so has layers of its own where they are planned by what is displayed; the
  // operator alone plans nothing where paths are fixed.
  EXPECT_EQ(make("by-itself", by_itself).layers_rendered, 22u);
  json = Json();
  json.set("extends", study.path().filename().string()).set("name", "local").set("tone_operator", "local");
  EXPECT_EQ(make("local", json).layers_rendered, 0u);
}

}  // namespace
}  // namespace equilux
