// The workspace under a real X server, by keys: a set rendered beside the window, pictures flipped, results.
#include "experiment/browse.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <set>
#include <thread>

#include "analysis/interim.h"
#include "base/files.h"
#include "renderer/set.h"
#include "stimuli/png_file.h"
#include "tests/e2e/child_process.h"
#include "tests/e2e/x_display.h"
#include "tests/experiment/fake_study.h"
#include "tests/renderer/tiny_study.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

const std::string kBin = EQUILUX_BIN_DIR;

// Large enough that it is still at work when it is paused and cancelled.
fs::path write_study(const test::TinyStudy& tiny) {
  Json json = tiny.load().source;
  json.set("image", parse_json(R"({"width":64,"height":48})", ""));
  json.set("paths", parse_json(R"({"object_indirect":256,"object_direct":64,"background":64})", ""));
  const fs::path path = tiny.folder() / "study.json";
  save_text(path, format_json(json));
  return path;
}

// Whether a process has the folder's lock open.
bool is_being_written(const fs::path& folder) {
  std::error_code gone;
  for (const auto& process : fs::directory_iterator("/proc", gone)) {
    if (std::atoi(process.path().filename().c_str()) <= 1) continue;
    for (const auto& open : fs::directory_iterator(process.path() / "fd", gone)) {
      if (fs::read_symlink(open.path(), gone) == folder / ".lock") return true;
    }
  }
  return false;
}

// Layers and pictures that are whole.
std::size_t count_products(const fs::path& folder) {
  std::size_t count = 0;
  std::error_code gone;
  for (const char* part : {"layers", "pictures"}) {
    for (const auto& file : fs::directory_iterator(folder / part, gone))
      count += file.path().extension() == ".exr" || file.path().extension() == ".png";
  }
  return count;
}

void run(const std::vector<std::string>& arguments) {
  ChildProcess program(arguments);
  ASSERT_EQ(program.wait(), 0) << program.read_output();
}

bool holds_all(const StudyFolder& folder) {
  const std::optional<Manifest> manifest = load_manifest(folder.manifest());
  return find_holding(load_folder_study(folder), manifest, folder.root).missing.empty();
}

LdrImage load(const StudyFolder& folder, const std::string& key) {
  return load_png(folder.root / load_manifest(folder.manifest()).pictures.at(key).file);
}

// Of the report's graphs.
const std::map<Region, std::array<std::uint8_t, 3>> kColours{{Region::kArtifact, {247, 188, 201}},
                                                             {Region::kChanged, {224, 96, 79}},
                                                             {Region::kBoth, {236, 143, 147}},
                                                             {Region::kEquivalent, {147, 207, 152}},
                                                             {Region::kUntested, {241, 241, 239}}};

std::set<Region> find_regions(const StudyFolder& folder) {
  std::set<Region> regions;
  for (const ColumnFinding& column :
       load_interim(folder, load_folder_study(folder), SubjectKind::kPlanted).columns) {
    for (const Region region : column.under(Rule::kPaper).regions) regions.insert(region);
  }
  return regions;
}

// Whether the picture stands somewhere on the screen, pixel for pixel.
bool shows(const LdrImage& screen, const LdrImage& picture) {
  const auto row = [](const LdrImage& image, int x, int y) {
    return image.values.data() + 3 * (static_cast<std::ptrdiff_t>(y) * image.width + x);
  };
  const auto bytes = static_cast<std::size_t>(picture.width) * 3;
  const auto is_at = [&](int x, int y) {
    for (int line = 0; line < picture.height; ++line) {
      if (std::memcmp(row(screen, x, y + line), row(picture, 0, line), bytes) != 0) return false;
    }
    return true;
  };
  for (int y = 0; y + picture.height <= screen.height; ++y) {
    for (int x = 0; x + picture.width <= screen.width; ++x) {
      if (is_at(x, y)) return true;
    }
  }
  return false;
}

std::size_t count_pixels(const LdrImage& screen, std::array<std::uint8_t, 3> colour) {
  std::size_t count = 0;
  for (std::size_t i = 0; i + 2 < screen.values.size(); i += 3)
    count += std::equal(colour.begin(), colour.end(), screen.values.begin() + static_cast<std::ptrdiff_t>(i));
  return count;
}

class BrowseAppTest : public testing::Test {
 protected:
  ChildProcess browse(const StudyFolder& folder, const std::vector<std::string>& more = {}) const {
    return browse_on(display_, folder, more);
  }
  static ChildProcess browse_on(const XDisplay& display, const StudyFolder& folder,
                                const std::vector<std::string>& more = {}) {
    std::vector<std::string> line{kBin + "/equilux-session", "browse", folder.root.string()};
    line.insert(line.end(), more.begin(), more.end());
    return ChildProcess(line, {{"DISPLAY", display.name()}, {"LIBGL_ALWAYS_SOFTWARE", "1"}});
  }
  bool wait_for_screen(const char* name, const std::function<bool(const LdrImage&)>& is_wanted) const {
    std::optional<LdrImage> screen;
    const bool came = wait_until([&] { return is_wanted(screen.emplace(display_.take_screenshot())); });
    if (const char* shots = std::getenv("EQUILUX_SCREENSHOTS"); shots && screen)
      save_png(*screen, fs::path(shots) / (std::string(name) + ".png"));
    return came;
  }
  bool wait_for_window() const {
    return wait_for_screen("browse-grid", [](const LdrImage& screen) {
      return count_pixels(screen, {128, 128, 128}) > 100000 && count_pixels(screen, {255, 255, 255}) > 500 &&
             count_pixels(screen, kColours.at(Region::kUntested)) == 0;
    });
  }

  XDisplay display_;
};

TEST_F(BrowseAppTest, RendersWhatIsMissingPausesCancelsAndGoesOn) {
  const test::TinyStudy tiny;
  const fs::path study = write_study(tiny);
  const StudyFolder folder{tiny.folder() / "set"};
  run({kBin + "/equilux-render", "set", study.string(), "--out", folder.root.string(), "--only",
       "G0-MS-ind-100-C0-v0"});
  ChildProcess app = browse(folder, {"--study", study.string()});
  ASSERT_TRUE(wait_for_window()) << app.read_output();
  const auto writing_is = [&](bool wanted) {
    return wait_until([&] { return is_being_written(folder.root) == wanted; });
  };
  const auto grows = [&] {
    const std::size_t before = count_products(folder.root);
    return wait_until([&] { return count_products(folder.root) > before; });
  };
  display_.type_key("r");
  ASSERT_TRUE(writing_is(true));
  ASSERT_TRUE(grows());
  display_.type_key("p");
  std::this_thread::sleep_for(std::chrono::seconds(1));
  const std::size_t held = count_products(folder.root);
  std::this_thread::sleep_for(std::chrono::seconds(2));
  EXPECT_EQ(count_products(folder.root), held);
  EXPECT_TRUE(is_being_written(folder.root)) << "paused, not ended";
  display_.type_key("r");
  ASSERT_TRUE(grows());
  display_.type_key("c");
  ASSERT_TRUE(writing_is(false));
  EXPECT_FALSE(holds_all(folder)) << "it was over before it was cancelled";
  display_.type_key("r");
  ASSERT_TRUE(writing_is(true));
  bool is_done = false;  // it is nice to whatever else runs
  for (int patience = 0; patience < 10 && !is_done; ++patience) is_done = writing_is(false);
  ASSERT_TRUE(is_done);

  SetParams params;
  params.study_path = study;
  params.folder = tiny.folder() / "whole";
  make_set(params);
  EXPECT_EQ(test::digest_products(folder.root), test::digest_products(params.folder));
  const LdrImage picture = load(folder, "G0-MS-ind-100-C0-v0"), reference = load(folder, "G0-MS-ind-ref-v0"),
                 neighbour = load(folder, "G0-MS-ind-100-C1-v0");
  display_.type_key("Return");
  EXPECT_TRUE(
      wait_for_screen("browse-picture", [&](const LdrImage& screen) { return shows(screen, picture); }));
  display_.type_key("space");
  EXPECT_TRUE(
      wait_for_screen("browse-reference", [&](const LdrImage& screen) { return shows(screen, reference); }));
  display_.type_key("space");
  display_.type_key("Up");
  EXPECT_TRUE(
      wait_for_screen("browse-neighbour", [&](const LdrImage& screen) { return shows(screen, neighbour); }));
  display_.type_key("BackSpace");
  ASSERT_TRUE(wait_for_window());
  display_.type_key("BackSpace");
  EXPECT_EQ(app.wait(), 0) << app.read_output();
}

TEST_F(BrowseAppTest, ShowsTheRegionsOfTheAnswersSoFar) {
  const TemporaryFolder temporary;
  const StudyFolder folder = make_fake_study(temporary.path());
  const auto shows_regions = [&](const LdrImage& screen) {
    const auto regions = find_regions(folder);
    return std::all_of(kColours.begin(), kColours.end(), [&](const auto& entry) {
      return (count_pixels(screen, entry.second) > 100) == regions.contains(entry.first);
    });
  };
  ChildProcess app = browse(folder);
  ASSERT_TRUE(wait_for_window()) << app.read_output();
  display_.type_key("g");
  EXPECT_EQ(find_regions(folder), std::set<Region>{Region::kUntested});
  EXPECT_TRUE(wait_for_screen("browse-no-results", shows_regions));

  for (const std::string experiment : {"artifact", "material"}) {
    if (experiment == "material") run({kBin + "/equilux-analyze", "prune", folder.root.string()});
    run({kBin + "/equilux-session", "simulate", folder.root.string(), "--experiment", experiment,
         "--subjects", "12", "--seed", "1"});
  }
  EXPECT_TRUE(find_regions(folder).contains(Region::kEquivalent));
  display_.type_key("k");
  EXPECT_TRUE(wait_for_screen("browse-results", shows_regions));
  display_.type_key("g");
  ASSERT_TRUE(wait_for_window());
  display_.type_key("BackSpace");
  EXPECT_EQ(app.wait(), 0) << app.read_output();
}

// The key with W on it lies where an American keyboard has Z.
TEST_F(BrowseAppTest, LettersAreThoseOnTheKeysOfAFrenchKeyboard) {
  const TemporaryFolder temporary;
  const StudyFolder folder = make_fake_study(temporary.path());
  const std::string before = load_text(folder.windows());
  ChildProcess layout({"setxkbmap", "-display", display_.name(), "-layout", "fr"});
  ASSERT_EQ(layout.wait(), 0) << layout.read_output();
  ChildProcess app = browse(folder);
  ASSERT_TRUE(wait_for_window()) << app.read_output();
  display_.type_key("w");
  EXPECT_TRUE(wait_until([&] { return load_text(folder.windows()) != before; }));
  EXPECT_THAT(load_text(folder.windows()), testing::HasSubstr("by_eye"));
  display_.type_key("BackSpace");
  EXPECT_EQ(app.wait(), 0) << app.read_output();
}

// A screen smaller than the window wants to be: the lines above the grid begin on it.
TEST_F(BrowseAppTest, ItsWindowHasRoomOnASmallScreen) {
  const TemporaryFolder temporary;
  const StudyFolder folder = make_fake_study(temporary.path());
  XDisplay small(800, 600);
  ChildProcess app = browse_on(small, folder);
  const auto has_margin = [&] {  // of 24 pixels around what is written
    const LdrImage screen = small.take_screenshot();
    const auto is_grey = [&](int x, int y) {
      const auto* pixel =
          screen.values.data() + 3 * (static_cast<std::size_t>(y) * 800 + static_cast<std::size_t>(x));
      return pixel[0] == 128 && pixel[1] == 128 && pixel[2] == 128;
    };
    for (int y = 0; y < 600; ++y) {
      if (!is_grey(2, y) || !is_grey(797, y)) return false;
    }
    for (int x = 0; x < 800; ++x) {
      if (!is_grey(x, 2)) return false;
    }
    return count_pixels(screen, {255, 255, 255}) > 500;  // the frame around the chosen picture
  };
  EXPECT_TRUE(wait_until(has_margin)) << app.read_output();
  small.type_key("BackSpace");
  EXPECT_EQ(app.wait(), 0) << app.read_output();
}

// A disk that is full: the window says so, and stays.
TEST_F(BrowseAppTest, AWindowThatCannotBeSavedIsSaidAndEndsNothing) {
  const TemporaryFolder temporary;
  const StudyFolder folder = make_fake_study(temporary.path());
  const std::string before = load_text(folder.windows());
  ChildProcess app = browse(folder);
  ASSERT_TRUE(wait_for_window()) << app.read_output();
  std::this_thread::sleep_for(std::chrono::seconds(1));  // for all thumbnails
  const LdrImage shown = display_.take_screenshot();
  app.limit_file_size(0);
  display_.type_key("w");
  EXPECT_TRUE(wait_for_screen("browse-not-saved", [&](const LdrImage& screen) { return screen != shown; }));
  EXPECT_EQ(load_text(folder.windows()), before);
  EXPECT_TRUE(app.is_running()) << app.read_output();
  display_.type_key("BackSpace");
  EXPECT_EQ(app.wait(), 0) << app.read_output();
}

}  // namespace
}  // namespace equilux
