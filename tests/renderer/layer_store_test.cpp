// Layers on disk: what cannot be read is made anew.
#include "renderer/layer_store.h"

#include <gtest/gtest.h>

#include "base/files.h"
#include "renderer/set.h"
#include "tests/renderer/tiny_study.h"
#include "tests/support/failures.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;
using test::digest_products;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

// A study folder that layers are saved into.
class LayersOnDisk : public testing::Test {
 protected:
  LayersOnDisk() { fs::create_directories(root() / "layers"); }

  fs::path root() const { return study_.folder() / "set"; }

  test::TinyStudy study_;
};

// A file of which nothing can be read, as of a disk that fails: a process has nothing at address 0.
TEST_F(LayersOnDisk, AreMadeAnewWhereTheyCannotBeRead) {
  SetParams params{study_.path(), root(), "G0-MS-ind-ref-v0"};
  const std::size_t layers = make_set(params).layers_rendered;
  const auto before = digest_products(root());
  const fs::path broken = root() / "layers/G0-MS-ind-ref-v0.coverage.exr";
  fs::remove(broken);
  fs::create_symlink("/proc/self/mem", broken);
  const SetSummary again = make_set(params);
  EXPECT_EQ(again.layers_rendered, layers);
  EXPECT_THAT(again.warnings, ElementsAre(AllOf(HasSubstr(broken.string()), HasSubstr("Input/output error"),
                                                HasSubstr("the layer counts as missing"))));
  EXPECT_EQ(digest_products(root()), before);
}

}  // namespace
}  // namespace equilux
