// What control groups leave, by files like the kernel's.
#include "base/memory.h"

#include <gtest/gtest.h>

#include "base/files.h"
#include "tests/support/temp_folder.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

class GroupMemory : public testing::Test {
 protected:
  fs::path mount() const { return folder_.path() / "cgroup"; }
  void put(const fs::path& file, const std::string& text) const {
    fs::create_directories((mount() / file).parent_path());
    save_text(mount() / file, text);
  }
  std::optional<std::uint64_t> find(const std::string& own) const {
    const fs::path file = folder_.path() / "own";
    save_text(file, own);
    return find_group_memory(mount(), file);
  }

  TempFolder folder_;
};

TEST_F(GroupMemory, IsTheLeastThatAGroupOrOneAboveItLeaves) {
  put("job/step/memory.max", "max\n");
  put("job/step/memory.current", "50\n");
  put("job/memory.max", "1000\n");
  put("job/memory.current", "700\n");
  put("job/memory.stat", "anon 300\ninactive_file 150\nactive_file 250\n");
  EXPECT_EQ(find("0::/job/step\n"), 450u) << "the job's, of whose use 150 gives way";
  put("job/step/memory.max", "400\n");
  EXPECT_EQ(find("0::/job/step\n"), 350u) << "the step's own";
  put("memory.max", "720\n");
  put("memory.current", "710\n");
  EXPECT_EQ(find("0::/job/step\n"), 10u) << "that of all";
  put("memory.current", "900\n");
  EXPECT_EQ(find("0::/job/step\n"), 0u) << "over its limit";
}

TEST_F(GroupMemory, IsFoundByVersion1WhereItStandsBesideVersion2) {
  put("memory/slurm/job/memory.limit_in_bytes", "2000\n");
  put("memory/slurm/job/memory.usage_in_bytes", "900\n");
  put("memory/slurm/job/memory.stat", "cache 500\ntotal_inactive_file 100\n");
  EXPECT_EQ(find("5:devices:/\n4:cpu,memory:/slurm/job\n1:name=systemd:/\n0::/\n"), 1200u);
  EXPECT_FALSE(find("5:devices:/\n4:memoryless:/slurm/job\n0::/\n"));
}

TEST_F(GroupMemory, IsUnknownWithoutALimitOrGroups) {
  EXPECT_FALSE(find("0::/\n"));
  EXPECT_FALSE(find("0::/of/another/host\n"));
  EXPECT_FALSE(find("no group\n"));
  EXPECT_FALSE(find_group_memory(mount(), folder_.path() / "none"));
  put("memory.max", "max\n");
  put("memory.current", "5\n");
  EXPECT_FALSE(find("0::/\n"));
}

TEST(FormatBytes, TellsMebibytesWhereThereIsNoTenthOfAGibibyte) {
  EXPECT_EQ(format_bytes(0), "0.0 MiB");
  EXPECT_EQ(format_bytes(std::uint64_t{20} << 20), "20.0 MiB");
  EXPECT_EQ(format_bytes(std::uint64_t{103} << 20), "0.1 GiB");
  EXPECT_EQ(format_bytes((std::uint64_t{7} << 30) / 2), "3.5 GiB");
}

}  // namespace
}  // namespace equilux
