// The table of texts and translations of it.
#include "experiment/texts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "base/json.h"
#include "protocols/experiment.h"
#include "tests/support/failures.h"
#include "tests/support/temp_folder.h"

namespace equilux {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class TextsTest : public ::testing::Test {
 protected:
  Texts load(const std::map<std::string, std::string>& texts) {
    Json table;
    for (const auto& [name, text] : texts) table.set(name, text);
    return load_file(Json().set("schema", "equilux-texts").set("schema_version", 1).set("texts", table));
  }
  Texts load_file(const Json& file) {
    folder_.write("texts-xx.json", format_json(file));
    return load_texts("xx", folder_.path());
  }
  std::string refusal_of(const std::map<std::string, std::string>& texts) {
    return message_of<InputError>([&] { load(texts); });
  }

  const TempFolder folder_;
  const Texts english_ = load_texts("en", folder_.path());
};

TEST_F(TextsTest, ThePromptsAreThoseOfTheStudyToTheLetter) {
  EXPECT_EQ(english_.at("prompt_artifact"), "Select the image that has the artifacts.");
  EXPECT_EQ(english_.at("prompt_material"), "Which object's material is different from the reference?");
  EXPECT_EQ(english_.at("prompt_artifact"), prompt_of(Experiment::kArtifact));
  EXPECT_EQ(english_.at("prompt_material"), prompt_of(Experiment::kMaterial));
}

TEST_F(TextsTest, FillsPlacesInBraces) {
  EXPECT_EQ(english_.fill("aborted_text", {{"answered", "3"}, {"count", "8"}}),
            "3 of 8 answers are recorded; none is lost.");
}

TEST_F(TextsTest, AnotherLanguageIsAFileToAdd) {
  auto texts = english_.all();
  texts["close"] = "Schließen (Enter)";
  EXPECT_EQ(load(texts).at("close"), "Schließen (Enter)");
  EXPECT_THAT(message_of<InputError>([&] { load_texts("de", folder_.path()); }), HasSubstr("texts-de.json"));
}

TEST_F(TextsTest, ATranslationIsCompleteAndHasTheSamePlaces) {
  auto texts = english_.all();
  texts.erase("close");
  EXPECT_THAT(refusal_of(texts), AllOf(HasSubstr("/texts/close"), HasSubstr("Close (Enter)")));
  texts = english_.all();
  texts["aborted_text"] = "{answered} of {all}";
  EXPECT_THAT(refusal_of(texts), AllOf(HasSubstr("/texts/aborted_text"), HasSubstr("{answered} of {all}")));
  texts = english_.all();
  texts["surplus"] = "x";
  EXPECT_THAT(refusal_of(texts), HasSubstr("/texts/surplus"));
  texts = english_.all();
  texts["close"] = "";
  EXPECT_THAT(refusal_of(texts), HasSubstr("/texts/close"));
}

TEST_F(TextsTest, ATableSaysThatItIsOneAndOfWhichSchema) {
  Json table;
  for (const auto& [name, text] : english_.all()) table.set(name, text);
  const auto refusal_of_file = [&](const Json& file) {
    return message_of<InputError>([&] { load_file(file); });
  };
  const Json file = Json().set("texts", table);
  EXPECT_THAT(refusal_of_file(file),
              HasSubstr("texts-xx.json: /schema: expected \"equilux-texts\", got none"));
  EXPECT_THAT(refusal_of_file(Json(file).set("schema", "equilux-session")), HasSubstr("/schema"));
  EXPECT_THAT(refusal_of_file(Json(file).set("schema", "equilux-texts").set("schema_version", 2)),
              HasSubstr("/schema_version: expected 1, got 2"));
}

}  // namespace
}  // namespace equilux
