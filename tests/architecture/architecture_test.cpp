// The tree keeps the laws of includes, and trees that break one of them are found out.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/architecture/include_check.h"
#include "tests/support/temp_folder.h"

namespace equilux {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// A tree that keeps the laws; the mutants add one file each.
class MadeUpTree : public testing::Test {
 protected:
  MadeUpTree() {
    add("base/json.h", "");
    add("base/json.cpp", "base/json.h\nnlohmann/json.hpp\nvalijson/schema.hpp\nstring");
    add("protocols/study.h", "base/json.h\nvector");
    add("stimuli/mesh.h", "protocols/study.h");
    add("renderer/set.h", "stimuli/mesh.h\nbase/json.h");
    add("renderer/world.cpp", "renderer/set.h\nembree3/rtcore.h");
    add("experiment/trial_log.h", "protocols/study.h");
    add("experiment/trial_log.cpp", "experiment/trial_log.h\nsqlite3.h");
    add("experiment/app/app.h", "experiment/trial_log.h");
    add("experiment/app/window.cpp",
        "experiment/app/app.h\nrenderer/set.h\nanalysis/report.h\nGLFW/glfw3.h\nimgui.h");
    add("experiment/app/screen.cpp", "experiment/app/app.h\nrenderer/set.h\nGL/gl.h\nbase/version.h");
    add("experiment/main.cpp", "experiment/app/app.h");
    add("analysis/report.h", "experiment/trial_log.h");
  }
  void add(const std::string& file, const std::string& headers) {
    std::string text = "#pragma once\n";
    for (std::size_t start = 0; start < headers.size();) {
      const std::size_t end = std::min(headers.find('\n', start), headers.size());
      text += "#include \"" + headers.substr(start, end - start) + "\"\n";
      start = end + 1;
    }
    folder_.write(file, text);
  }
  std::vector<std::string> faults() const { return find_include_faults(folder_.path()); }

  const TempFolder folder_;
};

TEST(Architecture, IsKeptByEveryIncludeOfTheTree) {
  EXPECT_THAT(find_include_faults(EQUILUX_SOURCE_DIR), IsEmpty());
}

TEST(Architecture, IsCheckedOnTheTreeItself) {
  ASSERT_TRUE(std::filesystem::exists(std::filesystem::path(EQUILUX_SOURCE_DIR) / "base/json.cpp"));
}

TEST_F(MadeUpTree, ThatKeepsTheLawsHasNoFaults) { EXPECT_THAT(faults(), IsEmpty()); }

TEST_F(MadeUpTree, WithAForbiddenEdgeIsFoundOut) {
  const std::pair<const char*, const char*> edges[] = {
      {"base/x.cpp", "protocols/study.h"},           {"protocols/x.cpp", "stimuli/mesh.h"},
      {"stimuli/x.cpp", "renderer/set.h"},           {"renderer/x.cpp", "experiment/trial_log.h"},
      {"renderer/main.cpp", "experiment/app/app.h"}, {"experiment/x.cpp", "renderer/set.h"},
      {"experiment/x.cpp", "analysis/report.h"},     {"experiment/x.cpp", "experiment/app/app.h"},
      {"analysis/x.cpp", "renderer/set.h"},          {"analysis/x.cpp", "experiment/app/app.h"},
      {"analysis/main.cpp", "experiment/app/app.h"}, {"experiment/main.cpp", "renderer/set.h"}};
  for (const auto& [file, header] : edges) {
    const std::string before = read_bytes(folder_ / file);
    add(file, header);
    EXPECT_THAT(faults(), ElementsAre(std::string(file) + " may not include " + header));
    before.empty() ? void(std::filesystem::remove(folder_ / file)) : void(folder_.write(file, before));
  }
}

TEST_F(MadeUpTree, WithAnalysisReachingBeyondTheTrialLogIsFoundOut) {
  add("experiment/session.h", "");
  add("analysis/x.cpp", "experiment/session.h");
  EXPECT_THAT(faults(), ElementsAre("analysis/x.cpp may not include experiment/session.h"));
}

TEST_F(MadeUpTree, WithASecondHeaderOfTheRendererInTheAppIsFoundOut) {
  add("renderer/vpl.h", "");
  add("experiment/app/x.cpp", "renderer/vpl.h");
  EXPECT_THAT(faults(),
              ElementsAre(HasSubstr("more than one header of renderer: renderer/set.h renderer/vpl.h")));
}

TEST_F(MadeUpTree, WithACycleIsFoundOut) {
  add("stimuli/a.h", "stimuli/b.h");
  add("stimuli/b.h", "stimuli/c.h");
  add("stimuli/c.h", "stimuli/a.h");
  EXPECT_THAT(faults(), ElementsAre("cycle: stimuli/a.h -> stimuli/b.h -> stimuli/c.h -> stimuli/a.h"));
}

TEST_F(MadeUpTree, WithAFileThatIncludesItselfIsFoundOut) {
  add("base/self.h", "base/self.h");
  EXPECT_THAT(faults(), ElementsAre("cycle: base/self.h -> base/self.h"));
}

TEST_F(MadeUpTree, WithASecondUserOfSqliteIsFoundOut) {
  folder_.write("analysis/tally.cpp", "  #  include <sqlite3.h>\n");
  EXPECT_THAT(faults(), ElementsAre("SQLite is included by more than one file: analysis/tally.cpp "
                                    "experiment/trial_log.cpp"));
}

TEST_F(MadeUpTree, WithAForeignLibraryAwayFromHomeIsFoundOut) {
  for (const char* header :
       {"nlohmann/json.hpp", "openssl/evp.h", "ImfHeader.h", "OpenEXR/ImfHeader.h", "png.h", "assimp/scene.h",
        "GLFW/glfw3.h", "imgui.h", "GL/gl.h", "valijson/schema.hpp"}) {
    add("renderer/x.cpp", header);
    EXPECT_THAT(faults(), ElementsAre(HasSubstr("renderer/x.cpp includes "))) << header;
  }
}

TEST_F(MadeUpTree, WithAHeaderThatIsNotThereOrNotNamedFromTheRootIsFoundOut) {
  add("stimuli/x.cpp", "stimuli/gone.h\nmesh.h");
  EXPECT_THAT(faults(), ElementsAre("stimuli/x.cpp includes stimuli/gone.h, which is not there",
                                    "stimuli/x.cpp includes mesh.h not by its path from the root"));
}

}  // namespace
}  // namespace equilux
