// A set by a real slurmctld and slurmd: an array of shares of which one is killed, gathered, submitted again.
#include <algorithm>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "renderer/set.h"
#include "tests/renderer/tiny_study.h"
#include "tests/slurm/cluster.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

constexpr int kShares = 4;
// Which is killed.
const std::string kVictim = "3/4";

// Large enough that a share is still at work when it is killed.
fs::path write_study(const test::TinyStudy& tiny) {
  Json json = tiny.load().source;
  json.set("image", parse_json(R"({"width":64,"height":48})", ""));
  json.set("paths", parse_json(R"({"object_indirect":256,"object_direct":64,"background":64})", ""));
  const fs::path path = tiny.folder() / "a study.json";
  save_text(path, format_json(json));
  return path;
}

std::string quote(const fs::path& path) { return fmt::format("'{}'", path.string()); }

test::CommandResult render(const std::string& words) {
  return test::run_shell(fmt::format("{}/equilux-render {}", EQUILUX_BIN_DIR, words));
}

// The process that renders a share, by its command line; 0 where there is none.
pid_t find_worker(const std::string& share) {
  std::error_code gone;
  for (const auto& entry : fs::directory_iterator("/proc", gone)) {
    const int pid = std::atoi(entry.path().filename().c_str());
    if (pid <= 1) continue;
    std::ifstream file(entry.path() / "cmdline", std::ios::binary);
    std::string words;  // none where the process has ended meanwhile
    std::getline(file, words);
    std::replace(words.begin(), words.end(), '\0', ' ');
    if (words.starts_with(EQUILUX_BIN_DIR "/equilux-render set ") &&
        words.ends_with(fmt::format("--job {} ", share)))
      return pid;
  }
  return 0;
}

std::size_t count_layers(const fs::path& share) {
  std::error_code none;
  const auto layers = fs::directory_iterator(share / "layers", none);
  return none ? 0 : static_cast<std::size_t>(std::count_if(begin(layers), end(layers), [](const auto& entry) {
    return entry.path().extension() == ".exr";
  }));
}

// Of the set, without what the batch system leaves.
std::map<std::string, std::string> digest_set(const fs::path& folder) {
  auto products = test::digest_products(folder);
  std::erase_if(products, [](const auto& product) { return product.first.starts_with("slurm/"); });
  return products;
}

TEST(Slurm, MakesOfSharesWhatOneProcessMakesAlthoughAWorkerIsKilled) {
  const test::TinyStudy tiny;
  const fs::path study = write_study(tiny), whole = tiny.folder() / "whole", set = tiny.folder() / "the set";
  SetParams params;
  params.study_path = study;
  params.folder = whole;
  make_set(params);

  const test::Cluster cluster;
  ASSERT_TRUE(cluster.is_up()) << cluster.said();
  const std::string words = quote(study) + " --out " + quote(set);
  const std::string submit = fmt::format("submit {} --jobs {}", words, kShares);
  const test::CommandResult first = render(submit);
  ASSERT_EQ(first.exit_code, 0) << first.text;
  EXPECT_THAT(first.text, HasSubstr("4 of 4 shares to render"));

  // Between its first record and its last.
  pid_t worker = 0;
  const fs::path share = set / "jobs/3-of-4";
  ASSERT_TRUE(test::wait_for(60, [&] {
    worker = find_worker(kVictim);
    return worker > 0 && path_exists(share / "layers.json");
  }));
  ASSERT_EQ(::kill(worker, SIGKILL), 0);
  ASSERT_TRUE(test::wait_for(90, test::Cluster::is_idle)) << test::run_shell("squeue").text;
  EXPECT_FALSE(path_exists(set / "manifest.json")) << "a set with a gap has no pictures";
  const std::size_t gathered = count_layers(set), all = count_layers(whole);
  EXPECT_GT(gathered, all * 3 / 4) << "three shares, and what the fourth had whole";
  EXPECT_LT(gathered, all);

  const test::CommandResult gap = render("verify " + quote(set));
  EXPECT_EQ(gap.exit_code, 1);
  EXPECT_THAT(gap.text, HasSubstr("no pictures were made"));
  const std::string by_share =
      fmt::format("verify {} --study {} --jobs {}", quote(set), quote(study), kShares);
  const test::CommandResult lost = render(by_share);
  EXPECT_EQ(lost.exit_code, 1);
  EXPECT_THAT(lost.text, HasSubstr("share 3 of 4: not whole"));
  for (const int other : {1, 2, 4}) EXPECT_THAT(lost.text, Not(HasSubstr(fmt::format("share {} of", other))));
  const test::CommandResult again = render(submit);
  ASSERT_EQ(again.exit_code, 0) << again.text;
  EXPECT_THAT(again.text, HasSubstr("1 of 4 shares to render"));
  EXPECT_THAT(load_text(set / "slurm/array.sh"), HasSubstr("$SLURM_ARRAY_TASK_ID/4"));
  ASSERT_TRUE(test::wait_for(90, test::Cluster::is_idle)) << test::run_shell("squeue").text;
  const test::CommandResult verified = render(by_share);
  EXPECT_EQ(verified.exit_code, 0) << verified.text;
  EXPECT_EQ(digest_set(set), digest_set(whole));
  EXPECT_THAT(render(submit).text, HasSubstr("0 of 4 shares to render"));
  ASSERT_TRUE(test::wait_for(60, test::Cluster::is_idle));
}

}  // namespace
}  // namespace equilux
