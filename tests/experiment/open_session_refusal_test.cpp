// What no session begins on: folders, pictures, windows and selections that are not as they should be.
#include <functional>

#include "stimuli/change_mark.h"
#include "stimuli/layers.h"
#include "stimuli/verdict.h"
#include "tests/experiment/open_session_fixture.h"

namespace equilux {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::ThrowsMessage;

using OpenSessionRefusal = OpenSessionTest;

TEST_F(OpenSessionRefusal, RefusesAFolderThatIsNoStudy) {
  fs::remove(folder_.study());
  expect_refused(HasSubstr("equilux-render set"));
}

TEST_F(OpenSessionRefusal, RefusesAFolderWithoutManifest) {
  fs::remove(folder_.manifest());
  expect_refused(HasSubstr("manifest.json"));
}

TEST_F(OpenSessionRefusal, RefusesAManifestOfAnotherStudy) {
  replace_in_file(folder_.study(), "\"seed\": 1", "\"seed\": 2");
  expect_refused(AllOf(HasSubstr("manifest.json"), HasSubstr("/study_digest")));
}

TEST_F(OpenSessionRefusal, RefusesAMissingPictureOfTheManifest) {
  Manifest manifest = load_manifest(folder_.manifest());
  manifest.pictures.erase("G2-GS-ind-100k-C2-v1");
  save_manifest(manifest, folder_.manifest());
  expect_refused(AllOf(HasSubstr("the picture G2-GS-ind-100k-C2-v1"), HasSubstr("equilux-render set")));
}

TEST_F(OpenSessionRefusal, RefusesAMissingPictureFile) {
  fs::remove(folder_.picture_folder() / "G0-MS-ind-ref-v0.png");
  expect_refused(AllOf(HasSubstr("G0-MS-ind-ref-v0.png"), HasSubstr("no file")));
}

TEST_F(OpenSessionRefusal, RefusesAPictureFileThatWasChanged) {
  save_png(make_fake_picture("another", 4, 3), folder_.picture_folder() / "G0-MS-ind-1k-C7-v0.png");
  expect_refused(AllOf(HasSubstr("expected pictures that verify, got G0-MS-ind-1k-C7-v0: "),
                       HasSubstr("G0-MS-ind-1k-C7-v0.png: expected the digest ")));
}

// Of layers, which a session does not read, too.
TEST_F(OpenSessionRefusal, RefusesASetThatDidNotVerify) {
  save_verdict(folder_, {{"G0-MS-ind-1k-C7-v0", "its background is not that of its reference"}});
  expect_refused(AllOf(HasSubstr("expected pictures that verify, got found by `equilux-render verify`"),
                       HasSubstr("G0-MS-ind-1k-C7-v0: its background is not that of its reference")));
  save_verdict(folder_, {});
  EXPECT_EQ(open("P1").row.participant, "P1");
}

TEST_F(OpenSessionRefusal, RefusesAFolderWhosePicturesAreBeingReplaced) {
  save_change_mark(folder_);
  expect_refused(AllOf(HasSubstr("changing.txt: pictures are being made anew"), HasSubstr("without --only")));
  remove_change_mark(folder_);
  EXPECT_EQ(open("P1").row.participant, "P1");
}

// From the start of the program to that of the session a person reads and agrees, for minutes.
TEST_F(OpenSessionRefusal, RefusesPicturesThatAreOthersThanItWasPreparedWith) {
  const SessionRequest request = request_of("P1");
  const SessionInputs inputs = load_session_inputs(folder_, &log_, request);
  const auto expect_none_begun = [&](const std::string& why) {
    EXPECT_THAT([&] { open_session(inputs, log_, request); }, ThrowsMessage<InputError>(HasSubstr(why)));
    EXPECT_THAT([&] { make_log(inputs); }, ThrowsMessage<InputError>(HasSubstr(why)));
    EXPECT_THAT(log_.load_sessions(), IsEmpty());
  };
  save_change_mark(folder_);
  expect_none_begun("pictures are being made anew");
  remove_change_mark(folder_);
  const Manifest before = load_manifest(folder_.manifest());
  Manifest manifest = before;
  manifest.pictures.at("G0-MS-ind-ref-v0").digest = digest_text("another");
  save_manifest(manifest, folder_.manifest());
  expect_none_begun("expected the pictures that the session was prepared with, got others, made since");
  save_manifest(before, folder_.manifest());
  EXPECT_EQ(open_session(inputs, log_, request).row.participant, "P1");
}

// Else the first session would be of windows that are nowhere any more, and the folder could have no second.
TEST_F(OpenSessionRefusal, RefusesFilesThatAreOthersThanItWasPreparedWith) {
  const SessionRequest artifact = request_of("P1"), material = request_of("P1", Experiment::kMaterial);
  save_fake_selection(folder_, SubjectKind::kPerson, {4, 6, 10});
  const auto expect_refused_by = [&](const SessionRequest& request, const fs::path& file,
                                     const std::function<void()>& change) {
    const SessionInputs inputs = load_session_inputs(folder_, &log_, request);
    const std::string before = fs::exists(file) ? load_text(file) : "";
    change();
    const auto refusal = HasSubstr(file.string() + ": expected the file that the session was prepared with");
    EXPECT_THAT([&] { open_session(inputs, log_, request); }, ThrowsMessage<InputError>(refusal));
    EXPECT_THAT([&] { make_log(inputs); }, ThrowsMessage<InputError>(refusal));
    EXPECT_THAT(log_.load_sessions(), IsEmpty());
    before.empty() ? static_cast<void>(fs::remove(file)) : save_text(file, before);
  };
  expect_refused_by(artifact, folder_.windows(),
                    [&] { replace_in_file(folder_.windows(), "\"first\": \"C4\"", "\"first\": \"C5\""); });
  expect_refused_by(artifact, folder_.session(), [&] {
    save_text(folder_.session(),
              R"({"schema": "equilux-session", "schema_version": 1, "least_response_ms": 9})");
  });
  expect_refused_by(material, folder_.selection(SubjectKind::kPerson), [&] {
    save_fake_selection(folder_, SubjectKind::kPerson, {4, 8, 10});
  });
  EXPECT_EQ(open("P1").row.participant, "P1");
}

TEST_F(OpenSessionRefusal, RefusesASelectionThatArtifactAnswersCameAfter) {
  save_fake_selection(folder_, SubjectKind::kPerson, {4, 6, 10});
  const SessionRequest request = request_of("P1", Experiment::kMaterial);
  const SessionInputs inputs = load_session_inputs(folder_, &log_, request);
  finish(open("P2"));
  EXPECT_THAT([&] { open_session(inputs, log_, request); },
              ThrowsMessage<InputError>(HasSubstr("of the artifact answers in the log")));
}

TEST_F(OpenSessionRefusal, RefusesAPictureOfAnotherSize) {
  Manifest manifest = load_manifest(folder_.manifest());
  const std::string key = "G0-MS-ind-1k-C7-v0";
  save_png(make_fake_picture(key, 5, 3), folder_.root / manifest.pictures[key].file);
  manifest.pictures[key].digest = digest_file(folder_.root / manifest.pictures[key].file);
  save_manifest(manifest, folder_.manifest());
  expect_refused(HasSubstr("5 x 3 pixels, where the manifest has 4 x 3"));
}

TEST_F(OpenSessionRefusal, RefusesPicturesThatWereNotMadeFromTheLayersOnRecord) {
  const Study study = load_folder_study(folder_);
  save_layers({study.name, study.digest, study.seed, {}}, folder_.layers());
  expect_refused(HasSubstr("not made from the layers of layers.json by its tone curve"));
}

TEST_F(OpenSessionRefusal, RefusesAManifestOfAnotherSeed) {
  Manifest manifest = load_manifest(folder_.manifest());
  manifest.seed += 1;
  save_manifest(manifest, folder_.manifest());
  expect_refused(AllOf(HasSubstr("manifest.json: seed "), HasSubstr(", where the study has ")));
}

TEST_F(OpenSessionRefusal, RefusesAReferenceThatMissesTheTarget) {
  Manifest manifest = load_manifest(folder_.manifest());
  manifest.pictures["G0-MS-ind-ref-v1"].standard_error.set("object_p99", 8.25);
  save_manifest(manifest, folder_.manifest());
  expect_refused(
      HasSubstr("G0-MS-ind-ref-v1: standard error object_p99 of 8.25 steps, over the study's 8.00"));
}

TEST_F(OpenSessionRefusal, RefusesPicturesWithoutAToneCurve) {
  Manifest manifest = load_manifest(folder_.manifest());
  manifest.tones.erase("G0-MS-ind-ref-v0");
  save_manifest(manifest, folder_.manifest());
  expect_refused(HasSubstr("no tone curve of G0-MS-ind-ref-v0; and "));
}

TEST_F(OpenSessionRefusal, DoesNotMissPicturesThatItNeverShows) {
  fs::remove(folder_.picture_folder() / "G0-MS-ind-1k-C0-v0.png");
  EXPECT_NO_THROW(open("P1"));
}

TEST_F(OpenSessionRefusal, RefusesToGoOnOrRepeatWithOtherWindows) {
  open("P1");
  replace_in_file(folder_.windows(), "\"first\": \"C4\"", "\"first\": \"C5\"");
  expect_refused(HasSubstr("windows: expected what session 1 of P1 was made from"), "P1");
  expect_refused(HasSubstr("windows: expected what session 1 of P1 was made from"), "P2");
}

TEST_F(OpenSessionRefusal, RefusesToGoOnOrRepeatWithAnotherPicture) {
  finish(open("P1"));
  Manifest manifest = load_manifest(folder_.manifest());
  const std::string key = "G0-MS-ind-1k-C7-v0";
  save_png(make_fake_picture("another", manifest.width, manifest.height),
           folder_.root / manifest.pictures[key].file);
  manifest.pictures[key].digest = digest_file(folder_.root / manifest.pictures[key].file);
  save_manifest(manifest, folder_.manifest());
  expect_refused(HasSubstr("pictures: expected"), "P2");
}

TEST_F(OpenSessionRefusal, RefusesToGoOnWithAnotherSelection) {
  save_fake_selection(folder_, SubjectKind::kPerson, {4, 6, 10});
  open("P1", Experiment::kMaterial);
  save_fake_selection(folder_, SubjectKind::kPerson, {4, 8, 10});
  expect_refused(HasSubstr("selection: expected"), "P1", Experiment::kMaterial);
}

TEST_F(OpenSessionRefusal, RefusesASelectionOfAnotherKind) {
  save_fake_selection(folder_, SubjectKind::kPlanted, {4});
  fs::rename(folder_.selection(SubjectKind::kPlanted), folder_.selection(SubjectKind::kPerson));
  expect_refused(HasSubstr("/kind: expected person, got planted"), "P1", Experiment::kMaterial);
}

TEST_F(OpenSessionRefusal, RefusesASelectionThatDroppedEverything) {
  save_fake_selection(folder_, SubjectKind::kPerson, {});
  expect_refused(HasSubstr("every column was dropped"), "P1", Experiment::kMaterial);
}

}  // namespace
}  // namespace equilux
