// What Slurm is handed: text that a shell reads as it was meant.
#include "renderer/submit.h"

#include <gtest/gtest.h>

#include "base/error.h"
#include "base/files.h"
#include "renderer/set.h"
#include "stimuli/layers.h"
#include "tests/renderer/tiny_study.h"
#include "tests/support/failures.h"
#include "tests/support/temp_folder.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;
using testing::HasSubstr;

SubmitParams make_params(const fs::path& folder) {
  SubmitParams params;
  params.program = "/usr/bin/printf";
  params.study_path = "it's a study.json";
  params.folder = folder / "a set";
  params.count = 12;
  return params;
}

TEST(Submit, ListsSharesAsSlurmDoes) {
  SubmitParams params = make_params("/x");
  params.options = {"time=2:00:00"};
  params.isa = Isa::kV3;
  const SlurmJobs jobs = make_slurm_jobs(params, {1, 2, 3, 7, 9, 10});
  EXPECT_EQ(format_sbatch(jobs),
            (std::vector<std::string>{"sbatch --parsable --array=1-3,7,9-10 --output='/x/a "
                                      "set/slurm/%A-%a.log' '/x/a set/slurm/array.sh'",
                                      "sbatch --parsable --dependency=afterany:JOB --output='/x/a "
                                      "set/slurm/%j.log' '/x/a set/slurm/gather.sh'"}));
  EXPECT_THAT(jobs.array_text, HasSubstr("#SBATCH --time=2:00:00\n"));
  EXPECT_THAT(jobs.array_text, HasSubstr("--isa v3"));
  EXPECT_THAT(jobs.gather_text,
              HasSubstr(" gather 'it'\\''s a study.json' --out '/x/a set' --isa v3 || failed=1\n"
                        "'/usr/bin/printf' verify '/x/a set' --study 'it'\\''s a study.json' --jobs 12 --isa "
                        "v3 || failed=1\n"));
  EXPECT_EQ(format_sbatch(make_slurm_jobs(params, {})),
            std::vector<std::string>{
                "sbatch --parsable --output='/x/a set/slurm/%j.log' '/x/a set/slurm/gather.sh'"});
}

// The script is run with printf in the program's place.
TEST(Submit, WritesScriptsThatAShellTakesWordByWord) {
  const TempFolder folder;
  SubmitParams params = make_params(folder.path());
  params.program = "/usr/bin/printf";
  SlurmJobs jobs = make_slurm_jobs(params, {5});
  const std::string format = "printf' '[%s]'";
  const auto place = jobs.array_text.find("printf' set");
  ASSERT_NE(place, std::string::npos);
  jobs.array_text.replace(place, std::string("printf'").size(), format);
  save_scripts(jobs);
  const std::string out = (folder.path() / "out").string();
  ASSERT_EQ(
      std::system(("SLURM_ARRAY_TASK_ID=5 sh '" + jobs.array_script.string() + "' >'" + out + "'").c_str()),
      0);
  EXPECT_EQ(load_text(out), "[set][it's a study.json][--out][" + params.folder.string() + "][--isa][" +
                                format_isa(current_isa()) + "][--threads][0][--job][5/12]");
}

// Programs in equilux-render's place: what fails at gathering is verified all the same, so that the log names
// what was lost; either failure is the step's.
TEST(Submit, VerifiesAlsoWhatCannotBeGathered) {
  const TempFolder folder;
  for (const char* failing : {"gather", "verify", "none"}) {
    SubmitParams params = make_params(folder.path());
    params.program = folder / "program";
    save_text(params.program, std::string("#!/bin/sh\necho $1\n[ $1 != ") + failing + " ]\n");
    fs::permissions(params.program, fs::perms::owner_all);
    const SlurmJobs jobs = make_slurm_jobs(params, {});
    save_scripts(jobs);
    const std::string out = (folder / "out").string();
    const int status = std::system(("sh '" + jobs.gather_script.string() + "' >'" + out + "'").c_str());
    EXPECT_EQ(status == 0, std::string(failing) == "none") << failing;
    EXPECT_EQ(load_text(out), "gather\nverify\n") << failing;
  }
}

TEST(Submit, WritesNamesOfLogsAsSlurmReadsThem) {
  const std::string call = format_sbatch(make_slurm_jobs(make_params("/x/100%j"), {1}))[0];
  EXPECT_THAT(call, HasSubstr("--output='/x/100%%j/a set/slurm/%A-%a.log'"));
}

// A command of that name first on the path stands for Slurm's.
class FakeSlurm {
 public:
  explicit FakeSlurm(const std::string& script) : path_(std::getenv("PATH")) {
    save_text(folder_ / "sbatch", "#!/bin/sh\n" + script);
    fs::permissions(folder_ / "sbatch", fs::perms::owner_all);
    ::setenv("PATH", (folder_.path().string() + ":" + path_).c_str(), 1);
  }
  ~FakeSlurm() { ::setenv("PATH", path_.c_str(), 1); }
  std::string log() const { return load_text(folder_ / "log"); }
  fs::path folder() const { return folder_.path(); }

 private:
  const TempFolder folder_;
  const std::string path_;
};

TEST(Submit, GathersAfterTheArray) {
  const TempFolder folder;
  const FakeSlurm slurm("echo \"$@\" >>\"$(dirname \"$0\")/log\"\necho '41;cluster'\n");
  const SlurmJobs jobs = make_slurm_jobs(make_params(folder.path()), {2, 3});
  save_scripts(jobs);
  std::vector<std::string> told;
  submit_slurm(jobs, [&](const std::string& number) { told.push_back(number); });
  EXPECT_EQ(told, (std::vector<std::string>{"41", "41"}));
  const std::string folder_name = jobs.array_script.parent_path().string();
  EXPECT_EQ(slurm.log(), "--parsable --array=2-3 --output=" + folder_name + "/%A-%a.log " +
                             jobs.array_script.string() + "\n--parsable --dependency=afterany:41 --output=" +
                             folder_name + "/%j.log " + jobs.gather_script.string() + "\n");
}

TEST(Submit, SaysWhatSlurmRefuses) {
  const TempFolder folder;
  const FakeSlurm slurm("echo 'no partition' >&2\nexit 1\n");
  const auto tell = [](const std::string&) { FAIL() << "nothing was submitted"; };
  EXPECT_THAT(
      message_of<InputError>([&] { submit_slurm(make_slurm_jobs(make_params(folder.path()), {1}), tell); }),
      HasSubstr("expected a job that Slurm takes, got sbatch --parsable --array=1 "));
}

TEST(Submit, TellsOfTheArrayAlsoWhereTheGatheringIsRefused) {
  const TempFolder folder;
  const FakeSlurm slurm("case \"$*\" in *dependency*) exit 1;; esac\necho 41\n");
  std::vector<std::string> told;
  const SlurmJobs jobs = make_slurm_jobs(make_params(folder.path()), {1});
  EXPECT_THAT(message_of<InputError>(
                  [&] { submit_slurm(jobs, [&](const std::string& number) { told.push_back(number); }); }),
              HasSubstr("--dependency=afterany:41"));
  EXPECT_EQ(told, std::vector<std::string>{"41"});
}

TEST(Submit, HandsThreadsOn) {
  SubmitParams params = make_params("/x");
  params.threads = 3;
  EXPECT_THAT(make_slurm_jobs(params, {1}).array_text, HasSubstr(" --threads 3 --job "));
}

// Every share of an array into another study's folder would fail, after its time in the queue.
TEST(Submit, IntoTheFolderOfAnotherStudyIsRefused) {
  const test::TinyStudy study, other(study.folder(), 2);
  SetParams set{study.path(), study.folder() / "set", "G0-MS-ind-ref-v0"};
  make_set(set);
  SubmitParams params;
  params.study_path = other.path();
  params.folder = set.folder;
  params.count = 2;
  EXPECT_THAT(message_of<InputError>([&] { find_unfinished(params); }),
              HasSubstr(params.folder.string() + ": expected the folder of this study"));
  params.study_path = study.path();
  EXPECT_EQ(find_unfinished(params), (std::vector<int>{1, 2}));
  Layers layers = load_layers(params.folder / "layers.json");
  layers.by_name.at("G0-MS-ind-ref-v0.direct").made_from = digest_text("another");
  save_layers(layers, params.folder / "layers.json");
  save_text(params.folder / "responses.sqlite", "");
  EXPECT_THAT(message_of<InputError>([&] { find_unfinished(params); }),
              HasSubstr("what its sessions have seen"));
}

TEST(Submit, TellsOfSharesOfAnotherNumber) {
  const TempFolder folder;
  SubmitParams params = make_params(folder.path());
  for (const char* name : {"1-of-12", "11-of-12", "notes", ".done-1-of-3"})
    fs::create_directories(params.folder / "jobs" / name);
  EXPECT_EQ(tell_other_shares(params), "");
  for (const char* name : {"1-of-3", "2-of-3", "1-of-112"})
    fs::create_directories(params.folder / "jobs" / name);
  const std::string out = params.folder.string();
  EXPECT_EQ(
      tell_other_shares(params),
      "shares of another number stand in " + out +
          "/jobs: 1-of-112, 1-of-3, 2-of-3; what they hold is not counted, and would be rendered again: "
          "`equilux-render gather 'it'\\''s a study.json' --out '" +
          out + "'` takes it in, submit after that");
}

}  // namespace
}  // namespace equilux
