// kill -9 of equilux-render at random moments: nothing stands half written under its final name, and a run to
// the end gives the bytes of an undisturbed one.
#include <chrono>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <thread>

#include "base/digest.h"
#include "base/program.h"
#include "base/random.h"
#include "stimuli/exr_file.h"
#include "stimuli/png_file.h"
#include "tests/experiment/fake_study.h"
#include "tests/renderer/tiny_study.h"
#include "tests/walk/programs.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr int kKills = 10;

std::vector<fs::path> list_files(const fs::path& folder) {
  std::vector<fs::path> files;
  if (!fs::exists(folder)) return files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  return files;
}

// Without a rest: a small set's files come within milliseconds of one another.
std::size_t count_files(const fs::path& folder) {
  std::size_t count = 0;
  std::error_code gone;
  for (fs::recursive_directory_iterator entry(folder, gone), end; !gone && entry != end;
       entry.increment(gone))
    count += entry->is_regular_file(gone) ? 1 : 0;
  return count;
}

/// Everything that `set` made but times: file -> digest.
std::map<std::string, std::string> digest_products(const fs::path& folder) {
  std::map<std::string, std::string> digests;
  for (const fs::path& file : list_files(folder)) {
    if (file.filename() != "timing.json" && file.filename() != "render.log")
      digests[fs::relative(file, folder).string()] = digest_file(file);
  }
  return digests;
}

/// Loads the whole file, by its kind. errors: whatever loading throws
void load_whole(const fs::path& file) {
  if (file.extension() == ".exr") load_exr(file);
  if (file.extension() == ".png") load_png(file);
  if (file.extension() == ".json") parse_json(load_text(file), file.string());
}

/// Files that stand under their final names and are not whole.
std::vector<std::string> find_damaged(const fs::path& folder) {
  std::vector<std::string> damaged;
  for (const fs::path& file : list_files(folder)) {
    try {
      load_whole(file);
    } catch (const std::exception& error) {
      damaged.push_back(file.filename().string());
    }
  }
  return damaged;
}

int count_parts(const fs::path& folder) {
  const auto files = list_files(folder);
  return static_cast<int>(std::count_if(files.begin(), files.end(),
                                        [](const fs::path& file) { return file.extension() == ".part"; }));
}

Words set_words(const test::TinyStudy& study, const fs::path& out, int threads) {
  return {"set", study.path().string(), "--out", out.string(), "--threads", std::to_string(threads)};
}

class RenderSet : public ::testing::Test {
 protected:
  explicit RenderSet(const std::string& variant = "") : study_(variant) {}

  /// Kills a run once the folder holds this many files, and a moment later; false if it was over before.
  bool kill_at(std::size_t files, std::chrono::duration<double> moment, int threads) {
    Child child(EQUILUX_BIN_DIR "/equilux-render", set_words(study_, disturbed_, threads));
    while (count_files(disturbed_) < files && child.runs()) std::this_thread::yield();
    std::this_thread::sleep_for(moment);
    child.kill();
    return child.wait().signal == SIGKILL;
  }

  test::TinyStudy study_;
  TemporaryFolder temporary_;
  fs::path undisturbed_ = temporary_.path() / "undisturbed", disturbed_ = temporary_.path() / "disturbed";
};

// Seed 51: kills at counts of files that are even over those still missing, and up to a file's mean time
// later, at least 10 kills of running programs on 1, 2 and 3 threads by turns, 5 of them in mid-set. A run
// that ends before its kill must have made the set; a whole set is taken away.
TEST_F(RenderSet, KilledLeavesWholeFilesAndASetThatGoesOnToTheSameBytes) {
  const auto start = std::chrono::steady_clock::now();
  run_well("render", set_words(study_, undisturbed_, 2));
  const std::chrono::duration<double> whole_run = std::chrono::steady_clock::now() - start;
  const auto whole = digest_products(undisturbed_);
  ASSERT_GT(whole.size(), 100u);
  const auto all = static_cast<double>(whole.size());
  RandomStream random(51, "render kill", 0);
  int kills = 0, in_mid_set = 0;
  // Beside other work few runs are seen at the moment that is waited for: then it takes more of them.
  for (int run = 0; (kills < kKills || in_mid_set < kKills / 2) && run < 200 * kKills; ++run) {
    const auto held = static_cast<double>(list_files(disturbed_).size());
    const auto files = static_cast<std::size_t>(held + random.next_double() * std::max(0.0, all - held));
    const bool killed = kill_at(files, random.next_double() * whole_run / all, 1 + run % 3);
    ASSERT_THAT(find_damaged(disturbed_), IsEmpty()) << "run " << run;
    const auto left = digest_products(disturbed_);
    if (killed) {
      ++kills;
      in_mid_set += left.size() > 3 && left.size() < whole.size();
    } else {
      ASSERT_EQ(left, whole) << "run " << run;
    }
    if (left == whole) fs::remove_all(disturbed_);
  }
  RecordProperty("kills_in_mid_set", in_mid_set);
  EXPECT_GE(kills, kKills);
  EXPECT_GE(in_mid_set, kKills / 2) << "kills must fall while layers and pictures are being made";
  run_well("render", set_words(study_, disturbed_, 3));
  EXPECT_EQ(digest_products(disturbed_), whole);
}

// References by VPL sets and compensation, and cuts of 30,000 VPLs.
class RenderDearSet : public RenderSet {
 protected:
  RenderDearSet() : RenderSet("compensated-many") {}
};

// Seed 52: while each of the first references is made, and among the first cuts.
TEST_F(RenderDearSet, KilledAmongReferencesAndCutsGoesOnToTheSameBytes) {
  run_well("render", set_words(study_, undisturbed_, 2));
  const auto whole = digest_products(undisturbed_);
  RandomStream random(52, "render kill", 0);
  std::size_t held = 0;
  for (const std::size_t more : {0u, 6u, 6u, 15u}) {
    ASSERT_TRUE(kill_at(held + more, std::chrono::duration<double>(0.2 * random.next_double()), 2));
    ASSERT_THAT(find_damaged(disturbed_), IsEmpty()) << "from " << held;
    const std::size_t now = digest_products(disturbed_).size();
    EXPECT_GE(now, held) << "nothing that was whole is lost";
    held = now;
  }
  EXPECT_GT(held, 10u);
  EXPECT_LT(held, whole.size());
  run_well("render", set_words(study_, disturbed_, 3));
  EXPECT_EQ(digest_products(disturbed_), whole);
}

// Two objects, whose room takes more than they do.
class RenderRoom : public RenderSet {
 protected:
  RenderRoom() : RenderSet("compensated-room") {}

  using Stages = std::map<fs::path, fs::file_time_type>;

  Stages list_stages() const {
    Stages stages;
    for (const fs::path& file : list_files(disturbed_ / "rooms")) {
      if (file.extension() == ".stage") stages[file] = fs::last_write_time(file);
    }
    return stages;
  }
  std::size_t count_stages() const { return count_files(disturbed_ / "rooms/G0-ind-v0"); }
  /// Kills a run once so many stages are there; false if it was over before.
  bool kill_at_stage(std::size_t stages) {
    Child child(EQUILUX_BIN_DIR "/equilux-render", set_words(study_, disturbed_, 2));
    while (count_stages() < stages && child.runs()) std::this_thread::yield();
    child.kill();
    return child.wait().signal == SIGKILL;
  }
};

// After each few stages of the first room; a stage made again would be written again.
TEST_F(RenderRoom, KilledAmongItsStagesMakesNoneOfThemAgainAndGoesOnToTheSameBytes) {
  run_well("render", set_words(study_, undisturbed_, 2));
  Stages held;
  for (int kill = 0; kill < 3; ++kill) {
    ASSERT_TRUE(kill_at_stage(held.size() + 2)) << "before the room was made";
    ASSERT_THAT(find_damaged(disturbed_), IsEmpty());
    const Stages now = list_stages();
    EXPECT_GT(now.size(), held.size());
    for (const auto& [file, written] : held) {
      ASSERT_TRUE(now.contains(file)) << file;
      EXPECT_EQ(now.at(file), written) << file << " was made again";
    }
    held = now;
  }
  run_well("render", set_words(study_, disturbed_, 3));
  EXPECT_EQ(digest_products(disturbed_), digest_products(undisturbed_)) << "and no stage is left";
}

TEST_F(RenderSet, GivesTheSameBytesOnOneTwoAndThreeThreads) {
  run_well("render", set_words(study_, undisturbed_, 1));
  const auto whole = digest_products(undisturbed_);
  for (int threads : {2, 3}) {
    run_well("render", set_words(study_, disturbed_, threads));
    EXPECT_EQ(digest_products(disturbed_), whole) << threads;
    fs::remove_all(disturbed_);
  }
}

// What a killed writer leaves beside its file is taken away by the next run; a writer that still runs keeps
// its own.
TEST_F(RenderSet, KilledLeavesHalfWrittenFilesThatTheNextRunRemoves) {
  run_well("render", set_words(study_, disturbed_, 2));
  const auto whole = digest_products(disturbed_);
  const std::string host = find_host_name(), dead = fmt::format(".999999999@{}.part", host),
                    alive = fmt::format(".{}@{}.part", ::getpid(), host);
  for (const std::string& file :
       {std::string("manifest.json"), std::string("layers/G0-MS-ind-ref-v0.coverage.exr"),
        std::string("pictures/G0-MS-ind-ref-v0.png")}) {
    save_text(disturbed_ / (file + dead), "half");
  }
  save_text(disturbed_ / ("manifest.json" + alive), "half");
  save_text(disturbed_ / "notes.part", "a person's own");
  EXPECT_EQ(count_parts(disturbed_), 5);
  run_well("render", set_words(study_, disturbed_, 2));
  EXPECT_TRUE(fs::remove(disturbed_ / ("manifest.json" + alive)));
  EXPECT_TRUE(fs::remove(disturbed_ / "notes.part"));
  EXPECT_EQ(digest_products(disturbed_), whole);
}

// Mutants: a picture, a layer and a manifest that stop short.
TEST_F(RenderSet, IsSeenByItsCheckWhereAFileIsCutShort) {
  run_well("render", set_words(study_, disturbed_, 2));
  ASSERT_THAT(find_damaged(disturbed_), IsEmpty());
  for (const char* name :
       {"manifest.json", "layers/G0-MS-ind-ref-v0.indirect.exr", "pictures/G0-MS-ind-ref-v0.png"}) {
    const std::string bytes = load_text(disturbed_ / name);
    fs::resize_file(disturbed_ / name, bytes.size() - 20);
    EXPECT_THAT(find_damaged(disturbed_), ElementsAre(fs::path(name).filename().string()));
    save_text(disturbed_ / name, bytes);
  }
}

}  // namespace
}  // namespace equilux
