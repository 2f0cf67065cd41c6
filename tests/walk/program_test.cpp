// The command lines of all three programs: help, version, wrong words, input that cannot be used, and the one
// line that says so.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/version.h"
#include "stimuli/verdict.h"
#include "tests/experiment/fake_study.h"
#include "tests/renderer/tiny_study.h"
#include "tests/support/json_edit.h"
#include "tests/walk/programs.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

struct Subcommand {
  std::string program, name;
  bool needs_arguments = true;
  bool takes_several = false;
};

const std::vector<Subcommand> kSubcommands = {{"render", "set"},         {"render", "image"},
                                              {"render", "tonemap"},     {"render", "converge"},
                                              {"render", "plan"},        {"render", "gather"},
                                              {"render", "submit"},      {"render", "verify"},
                                              {"render", "explain"},     {"render", "describe"},
                                              {"render", "prove"},       {"render", "sheet"},
                                              {"render", "export"},      {"session", "simulate"},
                                              {"session", "run", false}, {"session", "status"},
                                              {"session", "browse"},     {"session", "export"},
                                              {"session", "withdraw"},   {"session", "merge", true, true},
                                              {"analyze", "prune"},      {"analyze", "report", true, true},
                                              {"analyze", "export"},     {"analyze", "plan"},
                                              {"analyze", "windows"}};
const std::vector<std::string> kPrograms = {"render", "session", "analyze"};

std::string describe(const std::string& program, const Words& words) {
  return fmt::format("equilux-{} {}", program, fmt::join(words, " "));
}

void expect_usage_error(const std::string& program, const Words& words) {
  const ChildResult result = run_equilux(program, words);
  EXPECT_EQ(result.exit_code, 2) << describe(program, words);
  EXPECT_EQ(result.out, "") << describe(program, words);
  EXPECT_NE(result.err, "") << describe(program, words);
}

/// Exit 1 and one line on standard error: the program, then what to look at.
void expect_input_error(const std::string& program, const Words& words, const std::string& named) {
  const ChildResult result = run_equilux(program, words);
  EXPECT_EQ(result.exit_code, 1) << describe(program, words);
  EXPECT_THAT(result.err, StartsWith("equilux-" + program + ": ")) << describe(program, words);
  EXPECT_THAT(result.err, HasSubstr(named)) << describe(program, words);
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  EXPECT_TRUE(result.err.ends_with("\n")) << result.err;
}

/// Words of the subcommands that take a study folder, without or with what else they need.
std::vector<std::pair<std::string, Words>> folder_commands(const std::string& folder) {
  return {{"render", {"tonemap", folder}},
          {"render", {"verify", folder}},
          {"session", {"simulate", folder, "--experiment", "artifact"}},
          {"session", {"status", folder}},
          {"analyze", {"prune", folder}},
          {"analyze", {"report", folder}}};
}

Words image_words(const std::string& scene, const std::string& out) {
  return {"image", scene, "--out", out, "--width", "8", "--height", "6", "--positions", "1", "--paths", "1"};
}

const std::string kCafe = EQUILUX_SOURCE_DIR "/stimuli/scenes/cafe.json";

TEST(Programs, HaveAnExampleInEveryHelp) {
  for (const std::string& program : kPrograms) {
    EXPECT_THAT(run_well(program, {"--help"}), HasSubstr("Example:")) << program;
  }
  for (const Subcommand& command : kSubcommands) {
    const std::string help = run_well(command.program, {command.name, "--help"});
    const auto example = help.find("Example:");
    ASSERT_NE(example, std::string::npos) << command.name;
    EXPECT_THAT(help.substr(example), HasSubstr("equilux-" + command.program + " " + command.name));
  }
}

TEST(Programs, SayTheirNameAndVersion) {
  for (const std::string& program : kPrograms) {
    EXPECT_EQ(run_well(program, {"--version"}), fmt::format("equilux-{} {}\n", program, kVersion));
  }
}

TEST(Programs, LeaveWithTwoOnAWrongCommandLine) {
  for (const std::string& program : kPrograms) {
    expect_usage_error(program, {});
    expect_usage_error(program, {"dance"});
    expect_usage_error(program, {"--dance"});
  }
  for (const auto& [program, name, needs_arguments, takes_several] : kSubcommands) {
    if (needs_arguments) expect_usage_error(program, {name});
    expect_usage_error(program, {name, "a", "--out", "b", "--experiment", "artifact", "--dance"});
    if (!takes_several) expect_usage_error(program, {name, "a", "b", "c"});
  }
  expect_usage_error("render", {"set", "study.json"});
  expect_usage_error("render", {"image", kCafe});
  expect_usage_error("render", {"export", kCafe});
  expect_usage_error("render", {"export", kCafe, "--out", "a.py", "--illumination", "dark"});
  expect_usage_error("render", {"export", kCafe, "--out", "a.py", "--view", "v2"});
  expect_usage_error("render", {"export", kCafe, "--out", "a.py", "--width", "0"});
  expect_usage_error("analyze", {"report", "a", "--rule", "psychic"});
  expect_usage_error("analyze", {"prune", "a", "--kind", "martian"});
  expect_usage_error("analyze", {"report", "a", "--resamples", "0"});
  expect_usage_error("analyze", {"plan", "a", "--subjects", "0"});
}

TEST(Programs, LeaveWithTwoOnThreadsBeyondTheRange) {
  for (const std::string threads : {"-1", "4097", "many", "1.5", "99999999999999999999"}) {
    expect_usage_error("render", {"set", "study.json", "--out", "a", "--threads", threads});
    expect_usage_error("render", {"image", kCafe, "--out", "a.exr", "--threads", threads});
  }
}

TEST(Programs, LeaveWithTwoOnSeedsThatAReportCannotHold) {
  for (const std::string seed : {"-1", "9223372036854775808", "18446744073709551615", "one", "1.5"}) {
    expect_usage_error("analyze", {"report", "a", "--seed", seed});
    expect_usage_error("analyze", {"plan", "a", "--seed", seed});
  }
  for (const std::string slope : {"nan", "-nan", "inf", "-1", "11"})
    expect_usage_error("analyze", {"plan", "a", "--slope", slope});
}

class ProgramInput : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return (temporary_.path() / name).string(); }

  TemporaryFolder temporary_;
};

TEST_F(ProgramInput, NamesWhatIsNotThere) {
  const std::string nowhere = path("nowhere");
  for (const auto& [program, words] : folder_commands(nowhere)) {
    expect_input_error(program, words, nowhere + ": expected a study folder");
  }
  expect_input_error("render", {"sheet", nowhere}, nowhere + ": expected a study folder");
  expect_input_error("render", {"set", nowhere + ".json", "--out", path("out")}, nowhere + ".json");
  expect_input_error("render", image_words(nowhere + ".json", path("a.exr")), nowhere + ".json");
  expect_input_error("render", {"export", nowhere + ".json", "--out", path("a.py")}, nowhere + ".json");
  EXPECT_FALSE(fs::exists(nowhere));
  EXPECT_FALSE(fs::exists(path("out"))) << "a study that cannot be read makes no folder";
}

TEST_F(ProgramInput, NamesAFolderThatIsNoStudy) {
  fs::create_directory(path("empty"));
  for (const auto& [program, words] : folder_commands(path("empty"))) {
    expect_input_error(program, words, path("empty") + ": expected a study folder");
  }
  expect_input_error("render", {"set", path("empty"), "--out", path("out")}, path("empty"));
  expect_input_error("render", image_words(path("empty"), path("a.exr")), path("empty"));
  EXPECT_TRUE(fs::is_empty(path("empty")));
}

TEST_F(ProgramInput, NamesAStudyFolderWithoutAnswers) {
  const StudyFolder folder = make_fake_study(temporary_.path() / "study");
  for (const char* name : {"prune", "report"}) {
    expect_input_error("analyze", {name, folder.root.string()}, folder.responses().string());
  }
}

// Half a file, and a value of the wrong type with its JSON pointer.
TEST_F(ProgramInput, NamesADamagedManifestAndItsPlace) {
  const StudyFolder folder = make_fake_study(temporary_.path() / "study");
  const std::string root = folder.root.string(), whole = load_text(folder.manifest());
  run_well("session", {"simulate", root, "--experiment", "artifact", "--subjects", "1"});
  const std::vector<std::pair<std::string, Words>> readers = {
      {"session", {"simulate", root, "--experiment", "artifact"}}, {"analyze", {"report", root}}};
  for (const auto& [program, words] : readers) {
    save_text(folder.manifest(), whole.substr(0, whole.size() / 2));
    expect_input_error(program, words, folder.manifest().string() + ": line ");
    const std::string place = "/pictures/0/file";
    save_text(folder.manifest(), format_json(with(parse_json(whole, "manifest"), place, 3)));
    expect_input_error(program, words, folder.manifest().string() + ": " + place + ": expected ");
  }
}

TEST_F(ProgramInput, NamesADamagedManifestBeforeAnythingIsRendered) {
  const test::TinyStudy study;
  const StudyFolder folder{temporary_.path() / "set"};
  fs::create_directory(folder.root);
  save_text(folder.manifest(), "{\"schema\": \"equilux-manifest\"");
  const Words words = {"set", study.path().string(), "--out", folder.root.string()};
  expect_input_error("render", words, folder.manifest().string());
  EXPECT_FALSE(path_exists(folder.layer_folder()));
}

TEST(Plan, TellsWhatAFolderStillLacks) {
  const test::TinyStudy study;
  const std::string root = (study.folder() / "set").string();
  const Words plan = {"plan", study.path().string(), "--out", root};
  const std::string all = "All of it is rendered in " + root + ".", rest = "Not yet in " + root + ": ";
  run_well("render", {"set", study.path().string(), "--out", root, "--only", "G0-MS-ind-*"});
  EXPECT_THAT(run_well("render", plan), AllOf(HasSubstr(rest), Not(HasSubstr(all))));
  run_well("render", {"set", study.path().string(), "--out", root});
  EXPECT_THAT(run_well("render", plan), AllOf(HasSubstr(all), Not(HasSubstr(rest))));
  // References are there, a layer of a VPL picture is not.
  fs::remove(study.folder() / "set/layers/G0-MS-ind-100-C4-v0.exr");
  EXPECT_THAT(run_well("render", plan), HasSubstr(rest + "0 references and 1 layers"));
  const test::TinyStudy other("normalise");
  EXPECT_THAT(run_well("render", {"plan", other.path().string(), "--out", root}),
              HasSubstr(root + " is the folder of another study"));
}

// What `set` will refuse is refused before a night is planned for it.
TEST(Plan, RefusesAStudyWhoseWindowsSetWouldRefuse) {
  const test::TinyStudy study;
  const fs::path windows = study.folder() / "windows.json";
  save_text(windows, "{");
  expect_input_error("render", {"plan", study.path().string()}, windows.string());
}

TEST(Plan, TellsOfATargetThatNoPictureShows) {
  const test::TinyStudy study;
  const Json text = parse_json(load_text(study.path()), "");
  const std::string other = (study.folder() / "other.json").string();
  const auto plan_of = [&](double least) {
    Json json{Json::Object{}};
    for (const auto& [member, value] : text.as_object()) {
      if (member != "paths") json.set(member, value);
    }
    json.set(
        "noise_target",
        parse_json(fmt::format(R"({{"object_mean": 3, "object_p99": 8, "outside_mean": {}}})", least), ""));
    save_text(other, format_json(json));
    return run_well("render", {"plan", other});
  };
  EXPECT_THAT(plan_of(.1), Not(HasSubstr("warning")));
  EXPECT_THAT(plan_of(.01), HasSubstr("warning: noise_target asks for errors of 0.01 displayed steps"));
}

TEST_F(ProgramInput, NamesAnUnknownMeshAndItsPlace) {
  const Json cafe = parse_json(load_text(kCafe), kCafe);
  save_text(path("scene.json"), format_json(with(cafe, "/instances/0/mesh", "teapot")));
  const std::string named = path("scene.json") + ": /instances/0/mesh: expected ";
  expect_input_error("render", image_words(path("scene.json"), path("a.exr")), named);
  const test::TinyStudy study;
  const Json other = with(parse_json(load_text(study.path()), ""), "/scene", path("scene.json"));
  save_text(study.folder() / "other.json", format_json(other));
  expect_input_error("render", {"set", (study.folder() / "other.json").string(), "--out", path("out")},
                     named);
  EXPECT_FALSE(fs::exists(path("out")));
  EXPECT_FALSE(fs::exists(path("a.exr")));
}

TEST_F(ProgramInput, NamesAPlaceThatCannotBeWritten) {
  const test::TinyStudy study;
  save_text(path("file"), "a regular file");
  expect_input_error("render", {"set", study.path().string(), "--out", path("file/set")}, path("file/set"));
  expect_input_error("render", {"set", study.path().string(), "--out", path("file")}, path("file"));
  expect_input_error("render", image_words(kCafe, path("file/a.exr")), path("file/a.exr"));
  expect_input_error("render", image_words(kCafe, path("no-folder/a.exr")), path("no-folder/a.exr"));
  expect_input_error("render", {"export", kCafe, "--out", path("no-folder/a.py")}, path("no-folder/a.py"));
  EXPECT_EQ(load_text(path("file")), "a regular file");
}

TEST_F(ProgramInput, NamesWrongValuesOfPictures) {
  const auto with_words = [&](Words more) {
    Words words = image_words(kCafe, path("a.exr"));
    words.insert(words.end(), more.begin(), more.end());
    return words;
  };
  expect_input_error("render", with_words({"--geometry", "teapot"}), "teapot");
  expect_input_error("render", with_words({"--material", "velvet"}), "velvet");
  expect_usage_error("render", with_words({"--method", "vpl", "--vpls", "several"}));
  expect_usage_error("render", with_words({"--method", "vpl", "--vpls", "0k"}));
  expect_usage_error("render", with_words({"--method", "vpl", "--clamp", "C11"}));
  expect_usage_error("render", with_words({"--vpls", "1k"}));
  expect_usage_error("render", with_words({"--clamp", "C4"}));
  expect_usage_error("render", with_words({"--emission", "full"}));
  expect_usage_error("render", with_words({"--method", "vpl", "--clamp", "=C4"}));
  expect_usage_error("render", with_words({"--camera", "0", "-3", "1", "0", "0", "nan"}));
  expect_usage_error("render", with_words({"--noise-target", "nan", "1", "1"}));
  expect_usage_error("render", with_words({"--fov", "40"}));
  expect_input_error("render", with_words({"--camera", "0", "0", "1", "0", "0", "2"}), "--camera");
  expect_input_error("render", with_words({"--method", "vpl", "--clamp", "Ball=C4"}), "Ball");
  expect_input_error("render", with_words({"--png", path("a.exr")}), path("a.exr"));
  EXPECT_FALSE(fs::exists(path("a.exr")));
}

TEST_F(ProgramInput, NamesWrongConditionsOfScenesAndStudies) {
  const std::string pocket = EQUILUX_SOURCE_DIR "/protocols/pocket.json", out = path("out");
  for (const std::string command : {"converge", "explain"}) {
    const auto words = [&](const std::string& input, const std::string& key) {
      Words some{command, input, "--condition", key};
      if (command == "converge") some.insert(some.end(), {"--out", out});
      return some;
    };
    expect_input_error("render", words(kCafe, "G0-MS-ind"), "G0-MS-ind");
    expect_input_error("render", words(kCafe, "teapot-MS-ind-1k-C4-v0"), "teapot");
    expect_input_error("render", words(kCafe, "G0-velvet-ind-1k-C4-v0"), "velvet");
    expect_input_error("render", words(kCafe, "G0-MS-ind-1k-C4n-v0"), "C4n");
    expect_input_error("render", words(path("nowhere.json"), "G0-MS-ind-1k-C4-v0"), path("nowhere.json"));
    save_text(path("neither.json"), R"({"schema":"equilux-windows"})");
    expect_input_error("render", words(path("neither.json"), "G0-MS-ind-1k-C4-v0"), path("neither.json"));
  }
  expect_input_error("render", {"explain", pocket, "--condition", "G0-MS-ind-1k-C4n-v0"}, "C4n");
  expect_input_error("render", {"explain", pocket, "--condition", "G1-MS-ind-1k-C4-v0"},
                     "G1-MS-ind-1k-C4-v0");
  expect_input_error("render", {"explain", kCafe, "--condition", "G0-MS-ind-1k-C4-v0", "--out", "."},
                     "a scene");
  expect_input_error("render", {"explain", pocket, "--condition", "G0-MS-ind-1k-C4-v0", "--out", path("no")},
                     path("no"));
  save_text(path("file"), "a regular file");
  expect_input_error("render",
                     {"converge", kCafe, "--condition", "G0-MS-ind-1k-C4-v0", "--out", path("file/x")},
                     path("file"));
  EXPECT_FALSE(fs::exists(out));
}

TEST_F(ProgramInput, NamesWrongValuesOfExports) {
  const Words words = {"export", kCafe, "--out", path("a.py")};
  for (const auto& [option, value] :
       std::vector<std::pair<std::string, std::string>>{{"--geometry", "teapot"}, {"--material", "velvet"}}) {
    Words more = words;
    more.insert(more.end(), {option, value});
    expect_input_error("render", more, value);
  }
  EXPECT_FALSE(fs::exists(path("a.py")));
}

TEST_F(ProgramInput, LeavesNoHalfOfAnExportOnAFullDisk) {
  const std::vector<std::string> words = {"export", kCafe, "--material", "LG", "--out", path("a.py")};
  const ChildResult full = Child(EQUILUX_BIN_DIR "/equilux-render", words, 1 << 20).wait();
  EXPECT_EQ(full.exit_code, 1);
  EXPECT_THAT(full.err, HasSubstr(path("a.py")));
  EXPECT_TRUE(fs::is_empty(temporary_.path()));
  EXPECT_THAT(run_well("render", words), AllOf(HasSubstr("31 spots"), HasSubstr(path("a.py"))));
  EXPECT_TRUE(load_text(path("a.py")).ends_with("render()\n"));
}

// Without a screen or without a window library: `run` says so in one line.
TEST_F(ProgramInput, NamesTheScreenThatIsMissing) {
#ifdef EQUILUX_WINDOW
  const std::string missing = "DISPLAY";
#else
  const std::string missing = "without one";
#endif
  const ChildResult result = Child("/usr/bin/env", {"-u", "DISPLAY", "-u", "WAYLAND_DISPLAY",
                                                    EQUILUX_BIN_DIR "/equilux-session", "run"})
                                 .wait();
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, AllOf(StartsWith("equilux-session: "), HasSubstr(missing)));
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
}

TEST(Analyze, RefusesPicturesThatDoNotVerifyUnlessItMaySaySo) {
  const TemporaryFolder temporary;
  const StudyFolder folder = make_fake_study(temporary.path());
  const std::string root = folder.root.string();
  run_well("session", {"simulate", root, "--experiment", "artifact", "--subjects", "2", "--seed", "1"});
  run_well("analyze", {"prune", root, "--kind", "planted"});
  EXPECT_THAT(run_well("analyze", {"report", root}), Not(HasSubstr("do not verify")));
  save_png(make_fake_picture("another", 4, 3), folder.picture_folder() / "G0-MS-ind-1k-C7-v0.png");
  expect_input_error("analyze", {"report", root}, "expected pictures that verify, got G0-MS-ind-1k-C7-v0: ");
  expect_input_error("session", {"simulate", root, "--experiment", "artifact", "--seed", "2"},
                     "expected pictures that verify, got G0-MS-ind-1k-C7-v0: ");
  EXPECT_THAT(run_well("analyze", {"report", root, "--no-verify"}),
              HasSubstr("warning: Of the pictures 1 does not verify, the first G0-MS-ind-1k-C7-v0"));
  const std::string out = (temporary.path() / "chosen.json").string();
  for (const Words& words :
       {Words{"prune", root, "--kind", "planted"}, Words{"windows", root, "--out", out}}) {
    expect_input_error("analyze", words, "expected pictures that verify, got G0-MS-ind-1k-C7-v0: ");
    Words all_the_same = words;
    all_the_same.push_back("--no-verify");
    run_well("analyze", all_the_same);
  }
}

// Whatever is done to the records by hand, even that they are removed.
TEST(Analyze, RefusesAFolderWhoseVerdictStandsAlthoughItsManifestIsGone) {
  const TemporaryFolder temporary;
  const StudyFolder folder = make_fake_study(temporary.path());
  const std::string root = folder.root.string();
  run_well("session", {"simulate", root, "--experiment", "artifact", "--subjects", "2", "--seed", "1"});
  fs::remove(folder.manifest());
  EXPECT_THAT(run_well("analyze", {"report", root}), HasSubstr("There is no manifest.json"));
  save_verdict(folder, {{"manifest.json", "not there: no pictures were made"}});
  for (const Words& words : {Words{"report", root}, Words{"prune", root, "--kind", "planted"},
                             Words{"export", root, "--out", (temporary.path() / "answers").string()}})
    expect_input_error("analyze", words,
                       "expected pictures that verify, got found by `equilux-render verify`");
}

}  // namespace
}  // namespace equilux
