// A whole set, very small: bytes, backgrounds, resuming, refusals.
#include "renderer/set.h"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <future>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <thread>

#include "base/digest.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/work_control.h"
#include "renderer/parallel.h"
#include "renderer/timing.h"
#include "renderer/vpl.h"
#include "stimuli/exr_file.h"
#include "stimuli/layers.h"
#include "stimuli/png_file.h"
#include "tests/renderer/tiny_study.h"
#include "tests/support/failures.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

using test::digest_products;
using testing::AllOf;
using testing::HasSubstr;

SetSummary render(const test::TinyStudy& study, const std::string& out, const std::string& only = "*") {
  return make_set({study.path(), study.folder() / out, only});
}

TEST(Set, GivesTheSameBytesOnOneTwoAndThreeThreadsAndInParts) {
  const test::TinyStudy study;
  std::vector<std::map<std::string, std::string>> products;
  for (int threads : {1, 2, 3}) {
    const ThreadLimit limit(threads);
    render(study, "set" + std::to_string(threads));
    products.push_back(digest_products(study.folder() / ("set" + std::to_string(threads))));
  }
  EXPECT_EQ(products[0], products[1]);
  EXPECT_EQ(products[0], products[2]);
  EXPECT_GT(products[0].size(), 100u);
  render(study, "parts", "*-v1");
  render(study, "parts", "G0-MS-ind-*-C4-v0");
  render(study, "parts");
  EXPECT_EQ(digest_products(study.folder() / "parts"), products[0]);
}

// make_set in a thread of its own, under a control.
class ControlledSet {
 public:
  explicit ControlledSet(SetParams params)
      : params_(std::move(params)), thread_([this] { result_.set_value(make()); }) {}
  ~ControlledSet() { control_.cancel(); }

  WorkControl& control() { return control_; }
  /// "", "cancelled", or what went wrong.
  std::string wait() { return done_.get(); }
  bool is_over() const { return done_.wait_for(std::chrono::seconds(0)) == std::future_status::ready; }

 private:
  std::string make() {
    const ControlledWork work(control_);
    try {
      make_set(params_);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  }

  SetParams params_;
  WorkControl control_;
  std::promise<std::string> result_;
  std::future<std::string> done_ = result_.get_future();
  std::jthread thread_;
};

std::ptrdiff_t count_layers(const fs::path& root) {
  std::error_code gone;
  return std::count_if(fs::directory_iterator(root / "layers", gone), fs::directory_iterator{},
                       [](const auto& entry) { return entry.path().extension() == ".exr"; });
}

TEST(Set, ThatIsPausedMakesNothingAndCancelledKeepsWhatIsWhole) {
  using namespace std::chrono_literals;
  const test::TinyStudy study;
  render(study, "whole");
  const fs::path root = study.folder() / "set";
  ControlledSet set({study.path(), root});
  while (count_layers(root) == 0 && !set.is_over()) std::this_thread::sleep_for(1ms);
  set.control().pause();
  std::ptrdiff_t held = -1;  // what was being saved comes to its end
  for (; held != count_layers(root); std::this_thread::sleep_for(1s)) held = count_layers(root);
  EXPECT_FALSE(set.is_over());
  EXPECT_THAT(set.control().line(), testing::HasSubstr("rendering: "));
  set.control().cancel();
  EXPECT_EQ(set.wait(), "cancelled");
  EXPECT_FALSE(fs::exists(root / "manifest.json"));
  EXPECT_EQ(count_layers(root), held);
  EXPECT_EQ(static_cast<std::ptrdiff_t>(load_layers(root / "layers.json").by_name.size()),
            count_layers(root));
  render(study, "set");
  EXPECT_EQ(digest_products(root), digest_products(study.folder() / "whole"));
}

// A study is edited, and its new pictures are not all made when the run ends: those of the old one are on the
// disk, and in no manifest of the new one.
TEST(Set, CancelledAmongPicturesLeavesThoseOfTodaysStudyAlone) {
  const test::TinyStudy first;
  const fs::path root = first.folder() / "set";
  render(first, "set");
  std::size_t recorded = 0, all = 0;
  for (std::uint64_t seed = 2; seed < 8 && recorded == all; ++seed) {
    const test::TinyStudy edited(first.folder(), seed);
    {
      ControlledSet set({edited.path(), root});
      while (!set.control().line().starts_with("pictures") && !set.is_over()) std::this_thread::yield();
      set.control().cancel();
      set.wait();
    }
    const Manifest left = load_manifest(root / "manifest.json");
    EXPECT_EQ(left.study_digest, edited.load().digest);
    const std::string whole = "whole" + std::to_string(seed);
    render(edited, whole);
    const Manifest wanted = load_manifest(first.folder() / whole / "manifest.json");
    for (const auto& [key, record] : left.pictures) {
      EXPECT_EQ(record.made_from, wanted.pictures.at(key).made_from) << key;
      EXPECT_EQ(record.digest, digest_file(root / record.file)) << key;
    }
    recorded = left.pictures.size();
    all = wanted.pictures.size();
  }
  EXPECT_GT(recorded, 0u);
  EXPECT_LT(recorded, all) << "otherwise this test shows nothing";
}

// The check that every pair of a reference and its tests must pass; gives the first key that differs outside
// the object.
std::string find_background_change(const fs::path& folder, const Study& study) {
  for (const Condition& condition : enumerate_conditions(study)) {
    const Family family = family_of(condition);
    const LdrImage test = load_png(folder / "pictures" / (format_key(condition) + ".png"));
    const LdrImage reference = load_png(folder / "pictures" / (format_key(family) + ".png"));
    const HdrImage coverage = load_exr(folder / "layers" / (format_key(family) + ".coverage.exr")).image;
    for (std::size_t i = 0; i < coverage.values.size(); ++i) {
      if (coverage.values[i] > 0) continue;
      if (!std::equal(&test.values[3 * i], &test.values[3 * i] + 3, &reference.values[3 * i]))
        return format_key(condition);
    }
  }
  return "";
}

TEST(Set, PicturesAndTheirReferenceAreEqualOutsideTheObject) {
  const test::TinyStudy study;
  render(study, "set");
  EXPECT_EQ(find_background_change(study.folder() / "set", study.load()), "");
}

TEST(Set, AMutantBackgroundChangedByOneBitIsCaught) {
  const test::TinyStudy study;
  render(study, "set");
  const std::string key = "G0-MS-ind-100-C4-v1";
  const fs::path path = study.folder() / "set" / "pictures" / (key + ".png");
  LdrImage picture = load_png(path);
  picture.values[0] ^= 1;  // the upper left corner is wall
  save_png(picture, path);
  EXPECT_EQ(find_background_change(study.folder() / "set", study.load()), key);
}

TEST(Set, LayersAddUpAndNoneIsLitOutsideItsPlace) {
  const test::TinyStudy study;
  render(study, "set");
  const fs::path layers = study.folder() / "set" / "layers";
  for (const std::string family : {"G0-MS-ind-ref-v0", "G0-GS-dir-ref-v1"}) {
    const HdrImage coverage = load_exr(layers / (family + ".coverage.exr")).image;
    const HdrImage background = load_exr(layers / (family + ".background.exr")).image;
    const HdrImage indirect = load_exr(layers / (family + ".indirect.exr")).image;
    const HdrImage direct = load_exr(layers / (family + ".direct.exr")).image;
    double lit = 0;
    for (std::size_t i = 0; i < coverage.values.size(); ++i) {
      if (coverage.values[i] == 1) {
        EXPECT_EQ(background.pixel(i)[1], 0);
      }
      if (coverage.values[i] == 0) {
        EXPECT_EQ(indirect.pixel(i)[1] + direct.pixel(i)[1], 0);
      }
      lit += direct.pixel(i)[1];
    }
    if (family.find("-ind-") != std::string::npos) {
      EXPECT_EQ(lit, 0) << "indirect-only, yet light reaches the object directly";
    } else {
      EXPECT_GT(lit, 0);
    }
  }
}

TEST(Set, ASecondRunRedoesNothing) {
  const test::TinyStudy study;
  const auto first = render(study, "set");
  EXPECT_GT(first.layers_rendered, 0u);
  const auto before = fs::last_write_time(study.folder() / "set/pictures/G0-MS-ind-100-C4-v0.png");
  const auto second = render(study, "set");
  EXPECT_EQ(second.layers_rendered, 0u);
  EXPECT_EQ(second.pictures_written, 0u);
  EXPECT_EQ(second.pictures, first.pictures);
  EXPECT_EQ(fs::last_write_time(study.folder() / "set/pictures/G0-MS-ind-100-C4-v0.png"), before);
}

TEST(Set, WhatIsMissingOrDamagedIsMadeAgainTheSame) {
  const test::TinyStudy study;
  render(study, "set");
  const auto whole = digest_products(study.folder() / "set");
  fs::remove(study.folder() / "set/pictures/G0-GS-ind-100-C2-v0.png");
  fs::remove(study.folder() / "set/layers/G0-MS-ind-100-C7-v1.exr");
  fs::resize_file(study.folder() / "set/layers/G0-MS-ind-ref-v0.background.exr", 200);
  const auto summary = render(study, "set");
  EXPECT_EQ(summary.layers_rendered, 6u);  // one VPL layer, and the five of a family, which are made together
  EXPECT_EQ(digest_products(study.folder() / "set"), whole);
}

// A share makes no pictures, so that rendering is the last that it tells of.
TEST(Set, ThatGoesOnCountsWhatWasWholeBefore) {
  const test::TinyStudy study;
  render(study, "set");
  fs::remove(study.folder() / "set/layers/G0-MS-ind-100-C7-v1.exr");
  WorkControl control;
  const ControlledWork work(control);
  SetParams params{study.path(), study.folder() / "set"};
  params.job = JobShare{1, 1};
  make_set(params);
  EXPECT_THAT(control.line(), HasSubstr("8 of 8 references, 87 of 88 VPL layers"));
}

TEST(Set, AFolderWithSessionsRefusesToChangeAPictureThatMayHaveBeenShown) {
  const test::TinyStudy study;
  render(study, "set");
  const auto whole = digest_products(study.folder() / "set");
  save_text(study.folder() / "set/responses.sqlite", "a session's log stands here");
  EXPECT_EQ(render(study, "set").pictures_written, 0u);
  fs::remove(study.folder() / "set/pictures/G0-GS-ind-100-C2-v0.png");
  EXPECT_EQ(render(study, "set").pictures_written, 1u);
  const test::TinyStudy other(study.folder(), 99);  // another seed
  EXPECT_THROW(render(other, "set"), InputError);
  fs::remove(study.folder() / "set/responses.sqlite");
  EXPECT_EQ(digest_products(study.folder() / "set"), whole);
}

TEST(Set, AFolderWithSessionsKnowsItsStudyAlsoWithoutTheStudyFile) {
  const test::TinyStudy study;
  render(study, "set", "G0-MS-ind-100-C4-v0");
  save_text(study.folder() / "set/responses.sqlite", "a session's log stands here");
  fs::remove(study.folder() / "set/study.json");
  const test::TinyStudy other(study.folder(), 99);
  EXPECT_THROW(render(other, "set", "G0-MS-ind-100-C4-v0"), InputError);
  EXPECT_FALSE(fs::exists(study.folder() / "set/study.json"));
  EXPECT_EQ(render(study, "set", "G0-MS-ind-100-C4-v0").pictures_written, 0u);
}

TEST(Set, AFolderOfAnotherStudyIsRefusedAndLeftAsItWas) {
  const test::TinyStudy study;
  render(study, "set", "G0-MS-ind-*-v0");
  const auto before = digest_products(study.folder() / "set");
  Json json = study.load().source;
  json.set("name", "other");
  const fs::path path = study.folder() / "other.json";
  save_text(path, format_json(json));
  EXPECT_THAT(
      [&] {
        make_set({path, study.folder() / "set"});
      },
      testing::ThrowsMessage<InputError>(
          testing::HasSubstr("expected the folder of the study \"other\", got that of \"pocket\"")));
  EXPECT_EQ(digest_products(study.folder() / "set"), before);
}

TEST(Set, WindowsThatCannotBeUsedAreNotCopiedIntoTheFolder) {
  const test::TinyStudy study;
  const std::string good = load_text(study.folder() / "windows.json");
  save_text(study.folder() / "windows.json", "{}");
  EXPECT_THROW(render(study, "set", "G0-MS-ind-ref-v0"), InputError);
  EXPECT_FALSE(fs::exists(study.folder() / "set/windows.json"));
  save_text(study.folder() / "windows.json", good);
  EXPECT_NO_THROW(render(study, "set", "G0-MS-ind-ref-v0"));
}

TEST(Set, TellsSecondsOfProcessorsAndTheMostMemory) {
  const test::TinyStudy study;
  const SetSummary summary = make_set({study.path(), study.folder() / "set"});
  EXPECT_GT(summary.processor_seconds, 0);
  EXPECT_GT(summary.peak_memory, 1e6);
  const Json runs = load_timing({study.folder() / "set"});
  EXPECT_EQ(runs.at(0).at("processor_seconds").as_double(), summary.processor_seconds);
  EXPECT_GE(runs.at(0).at("peak_memory_bytes").as_double(), 1e6);
  std::ifstream log(study.folder() / "set/render.log");
  int lines = 0;
  for (std::string line; std::getline(log, line); ++lines)
    EXPECT_THAT(line, testing::ContainsRegex(
                          "^20[-0-9T:.]+Z .+: [0-9]+[.][0-9]+ s, [0-9]+[.][0-9]+ s of processors$"));
  EXPECT_GT(lines, 4);
}

TEST(Set, ALogThatIsAPipeIsNotWaitedFor) {
  const test::TinyStudy study;
  fs::create_directories(study.folder() / "set");
  ASSERT_EQ(::mkfifo((study.folder() / "set/render.log").c_str(), 0600), 0);
  EXPECT_GT(render(study, "set", "G0-MS-ind-ref-v0").layers_rendered, 0u);
  EXPECT_FALSE(fs::is_regular_file(study.folder() / "set/render.log"));
}

TEST(Set, ADamagedTimingFileIsSaidBeforeTheWork) {
  const test::TinyStudy study;
  fs::create_directories(study.folder() / "set");
  for (const char* text : {"{", "[1]", R"({"runs":5})"}) {
    save_text(study.folder() / "set/timing.json", text);
    EXPECT_THROW(render(study, "set", "G0-MS-ind-ref-v0"), InputError) << text;
    EXPECT_FALSE(fs::exists(study.folder() / "set/layers.json")) << text;
  }
}

// By which `plan --out` foresees: a file that anybody may have edited.
TEST(Set, HasNoSpeedThatNoMachineHas) {
  const test::TinyStudy study;
  const StudyFolder folder{study.folder()};
  const auto find = [&](const char* work) {
    save_text(folder.timing(), std::string(R"({"runs":[{"foreseen_work":)") + work +
                                   R"(,"seconds":{"references":2,"pictures":7}}]})");
    return find_speed(folder);
  };
  EXPECT_EQ(find("3e6"), 1.5e6);
  for (const char* work : {"1e-300", "1e308", "0", "-1"}) EXPECT_FALSE(find(work)) << work;
}

TEST(Set, MemoryThatIsNotThereIsSaidBeforeTheWork) {
  const auto most = find_available_memory();
  if (!most || *most > estimate_vpl_memory(1'000'000'000)) GTEST_SKIP() << "this machine has too much";
  const test::TinyStudy study;
  Json json = parse_json(load_text(study.path()), "study");
  Json block = json.at("blocks").at(0);
  block.set("vpl_counts", parse_json(R"(["1000M"])", ""));
  json.set("blocks", Json(Json::Array{block}));
  for (const char* list : {"windows", "truth"}) {
    const fs::path path = study.folder() / (std::string(list) + ".json");
    std::string text = load_text(path);
    for (auto place = text.find("-100\""); place != std::string::npos; place = text.find("-100\""))
      text.replace(place, 5, "-1000M\"");
    save_text(path, text);
  }
  save_text(study.path(), format_json(json));
  EXPECT_THAT(message_of<InputError>([&] {
                make_set({study.path(), study.folder() / "set"});
              }),
              HasSubstr("1000000000 VPLs: expected about "));
  EXPECT_FALSE(fs::exists(study.folder() / "set/layers/G0-MS-ind-ref-v0.indirect.exr"));
}

TEST(Set, TheStudyFileItselfIsNotWrittenOver) {
  const test::TinyStudy study;
  const fs::path own = study.folder() / "study.json";
  save_text(own, R"({"extends": ")" + study.path().filename().string() + R"(", "name": "pocket"})");
  const std::string before = load_text(own);
  EXPECT_THAT(message_of<InputError>([&] {
                make_set({own, study.folder()});
              }),
              AllOf(HasSubstr("study.json: expected"), HasSubstr("the study file itself")));
  EXPECT_EQ(load_text(own), before);
}

TEST(Set, AGlobThatNamesNothingIsAnInputError) {
  const test::TinyStudy study;
  EXPECT_THROW(render(study, "set", "G9-*"), InputError);
}

}  // namespace
}  // namespace equilux
