// What becomes of shares: gathered, cleared away, or kept and named.
#include <dlfcn.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/error.h"
#include "base/files.h"
#include "base/folder_lock.h"
#include "base/program.h"
#include "renderer/jobs.h"
#include "renderer/set.h"
#include "renderer/timing.h"
#include "stimuli/layers.h"
#include "tests/renderer/tiny_study.h"
#include "tests/support/failures.h"

namespace {

// While it is set, names of files that this process has open go the way they do on NFS.
bool is_nfs = false;

bool is_open(int folder, const char* name) {
  struct stat named, open;
  if (::fstatat(folder, name, &named, AT_SYMLINK_NOFOLLOW) != 0 || !S_ISREG(named.st_mode)) return false;
  for (int descriptor = 3; descriptor < 256; ++descriptor) {
    if (::fstat(descriptor, &open) == 0 && open.st_ino == named.st_ino && open.st_dev == named.st_dev)
      return true;
  }
  return false;
}

}  // namespace

// In this program in place of the system's. A client of NFS gives a file that it has open another name in
// place of removing it, and that name cannot be removed.
extern "C" int unlinkat(int folder, const char* name, int flags) noexcept {
  if (is_nfs && (flags & AT_REMOVEDIR) == 0 && is_open(folder, name)) {
    if (std::string_view(name).starts_with(".nfs")) {
      errno = EBUSY;
      return -1;
    }
    return ::renameat(folder, name, folder, ".nfs0000000000000001");
  }
  using Unlink = int (*)(int, const char*, int);
  static const auto real = reinterpret_cast<Unlink>(dlsym(RTLD_NEXT, "unlinkat"));
  return real(folder, name, flags);
}

namespace equilux {
namespace {
namespace fs = std::filesystem;
using test::digest_products;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

// A tiny study, its set in one process, and one in shares.
class Gather : public testing::Test {
 protected:
  ~Gather() override { is_nfs = false; }

  SetParams params_of(const std::string& out) const {
    SetParams params;
    params.study_path = study_.path();
    params.folder = study_.folder() / out;
    return params;
  }
  SetSummary render_share(int index, int count) const {
    SetParams params = params_of("set");
    params.job = JobShare{index, count};
    return make_set(params);
  }
  void render_shares(int count) const {
    for (int index = 1; index <= count; ++index) render_share(index, count);
  }
  SetSummary gather() const {
    SetParams params = params_of("set");
    params.render = false;
    return make_set(params);
  }
  fs::path share(const std::string& name) const { return study_.folder() / "set/jobs" / name; }
  fs::path jobs() const { return study_.folder() / "set/jobs"; }

  test::TinyStudy study_;
};

TEST_F(Gather, ClearsSharesAwayWhereOpenFilesKeepTheirNames) {
  render_shares(2);
  is_nfs = true;
  EXPECT_EQ(gather().warnings, std::vector<std::string>());
  EXPECT_FALSE(path_exists(jobs()));
}

TEST_F(Gather, WarnsOfWhatCannotBeRemovedAndRemovesItTheNextTime) {
  render_shares(2);
  const std::string held = (share("1-of-2") / "render.log").string();
  is_nfs = true;
  const int descriptor = ::open(held.c_str(), O_RDONLY);
  ASSERT_GE(descriptor, 0);
  EXPECT_THAT(gather().warnings, ElementsAre(AllOf(HasSubstr("jobs/.done-1-of-2: cannot remove: "),
                                                   HasSubstr("gathering again"))));
  EXPECT_FALSE(has_shares({study_.folder() / "set"}));
  EXPECT_FALSE(path_exists(share("2-of-2"))) << "the share after it is gathered";
  render_share(1, 2);
  EXPECT_EQ(gather().warnings.size(), 1u) << "still held";
  EXPECT_FALSE(has_shares({study_.folder() / "set"})) << "a second one of that name is cleared away too";
  ::close(descriptor);
  EXPECT_EQ(gather().warnings, std::vector<std::string>());
  EXPECT_FALSE(path_exists(jobs()));
}

// A share whose lock cannot be opened is a share that the file system fails for.
TEST_F(Gather, GoesOnAfterAShareThatTheFileSystemFailsFor) {
  render_shares(2);
  fs::remove(share("1-of-2") / ".lock");
  fs::create_directory(share("1-of-2") / ".lock");
  const SetSummary whole = make_set(params_of("set"));
  EXPECT_THAT(whole.warnings, ElementsAre(AllOf(HasSubstr("1-of-2/.lock: cannot open: "),
                                                HasSubstr("1-of-2 was not gathered"))));
  EXPECT_TRUE(path_exists(share("1-of-2") / "layers.json"));
  EXPECT_FALSE(path_exists(share("2-of-2")));
  fs::remove(share("1-of-2") / ".lock");
  EXPECT_EQ(gather().warnings, std::vector<std::string>());
  EXPECT_FALSE(path_exists(jobs()));
}

TEST_F(Gather, KeepsAShareWhoseTimesCannotBeKept) {
  render_shares(1);
  const StudyFolder set{study_.folder() / "set"};
  const auto runs = load_timing({share("1-of-1")});
  const fs::path part = set.timing().string() + fmt::format(".{}@{}.part", ::getpid(), find_host_name());
  fs::create_directory(part);  // where the new file is written first
  message_of<StoreError>([&] { gather(); });
  EXPECT_TRUE(path_exists(share("1-of-1")));
  EXPECT_EQ(load_timing(set).as_array().size(), 0u);
  fs::remove(part);
  EXPECT_EQ(gather().warnings, std::vector<std::string>());
  EXPECT_EQ(load_timing(set).as_array().front(), runs.as_array().front());
  EXPECT_FALSE(path_exists(jobs()));
}

TEST_F(Gather, CountsTheTimesOfAShareOnce) {
  render_shares(1);
  const StudyFolder set{study_.folder() / "set"};
  join_timing(set, {share("1-of-1")});  // by a run that was killed before it renamed the share
  gather();
  EXPECT_EQ(load_timing(set).as_array().size(), 2u) << "the share's and that of the pictures";
}

TEST_F(Gather, SaysBeforeItRendersThatAShareCannotBeGathered) {
  render_shares(2);
  SetParams params = params_of("set");
  const StudyFolder set{params.folder};
  std::vector<std::string> remarks;
  std::size_t gathered = 0;
  params.remark = [&](const std::string& line) {
    remarks.push_back(line);
    gathered = load_layers(set.layers()).by_name.size();
  };
  {
    const FolderLock lock(share("1-of-2"));
    const SetSummary summary = make_set(params);
    EXPECT_EQ(summary.warnings.size(), 1u);
    EXPECT_EQ(gathered + summary.layers_rendered, load_layers(set.layers()).by_name.size())
        << "before the first layer";
    EXPECT_THAT(remarks, ElementsAre(AllOf(HasSubstr("still being rendered by process"),
                                           HasSubstr("is rendered now"))));
    make_set(params);
    EXPECT_EQ(remarks.size(), 1u) << "nothing is missing then";
  }
}

// A share that was killed: its reference of G0-MS-ind-v0 is whole, and of its room a stage.
class KilledShare : public Gather {
 protected:
  KilledShare() {
    SetParams params = params_of("set");
    params.job = JobShare{1, 1};
    params.only = "G0-MS-ind-ref-v0";
    make_set(params);
    const fs::path room = share("1-of-1") / "rooms/G0-ind-v0";
    fs::create_directories(room);
    save_text(room / "plan.stage", "of minutes");
  }
  fs::path stage() const { return share("1-of-1") / "rooms/G0-ind-v0/plan.stage"; }
};

TEST_F(KilledShare, IsKeptWithTheStagesOfRoomsThatTheSetLacks) {
  EXPECT_THAT(message_of<InputError>([&] { gather(); }),
              AllOf(HasSubstr("1-of-1/rooms/G0-ind-v0: stages of a room of which the set lacks"),
                    HasSubstr("7 references and")))
      << "the first reference is gathered";
  EXPECT_TRUE(path_exists(stage()));
  EXPECT_GT(render_share(1, 1).layers_rendered, 0u);
  EXPECT_EQ(gather().warnings, std::vector<std::string>());
  EXPECT_FALSE(path_exists(jobs()));
}

TEST_F(KilledShare, GoesOnceTheSetIsWhole) {
  EXPECT_EQ(make_set(params_of("set")).warnings, std::vector<std::string>());
  EXPECT_FALSE(path_exists(jobs()));
}

TEST_F(KilledShare, IsNotKeptForRoomsThatNoReferenceLacks) {
  SetParams params = params_of("set");
  params.only = "G0-*-ind-ref-v0";
  params.reuse = {share("1-of-1")};
  make_set(params);
  params = params_of("set");
  params.job = JobShare{1, 1};
  params.only = "G0-MS-ind-ref-v0";
  make_set(params);
  for (const char* room : {"G0-ind-v0", "of-another-study"}) {
    fs::create_directories(share("1-of-1") / "rooms" / room);
    save_text(share("1-of-1") / "rooms" / room / "plan.stage", "of minutes");
  }
  EXPECT_THAT(message_of<InputError>([&] { gather(); }), testing::Not(HasSubstr("1-of-1")));
  EXPECT_FALSE(path_exists(jobs()));
}

TEST_F(Gather, KeepsAShareWithoutARecordUntilTheSetIsWhole) {
  render_shares(2);
  for (const char* part : {"layers", "layers.json"}) fs::remove_all(share("1-of-2") / part);
  EXPECT_THAT(message_of<InputError>([&] { gather(); }), HasSubstr("1-of-2: no layer is recorded there"));
  EXPECT_TRUE(path_exists(share("1-of-2")));
  {
    const FolderLock lock(share("1-of-2"));
    EXPECT_THAT(make_set(params_of("set")).warnings, ElementsAre(HasSubstr("still being rendered")));
  }
  EXPECT_EQ(gather().warnings, std::vector<std::string>());
  EXPECT_FALSE(path_exists(jobs()));
}

}  // namespace
}  // namespace equilux
