// The font that the window uses, without the window.
#include "experiment/app/glyphs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <imgui.h>

#include "base/error.h"
#include "tests/support/temp_folder.h"

namespace equilux {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr const char* kFont = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";

std::string refusal_of(const std::string& text) {
  const std::vector<ShownText> texts{{"texts-xx.json", "/texts/close", text}};
  const auto ranges = make_glyph_ranges(texts);
  ImFontAtlas atlas;
  const ImFont* font = atlas.AddFontFromFileTTF(kFont, 22, nullptr, ranges.data());
  atlas.Build();
  try {
    check_glyphs(*font, kFont, texts);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Glyphs, AreReadFromUtf8) {
  EXPECT_THAT(decode_characters("a\u00e9\u20ac\U0001F600"),
              ElementsAre(U'a', U'\u00e9', U'\u20ac', U'\U0001F600'));
  EXPECT_THAT(decode_characters("\xff\xe2\x82"), ElementsAre(U'\uFFFD', U'\uFFFD'));
}

TEST(Glyphs, OfTheTextsAreAddedToTheFontsOwn) {
  for (const char* text : {"Close (Enter) \u2190", "12 \u20ac, \u22125 \u2264 x \u2260 y", "e\u0301 a\u0308",
                           "\u0388\u03bd\u03b1 \u0411\u0443\u043a\u0432\u044b", "two\nlines"})
    EXPECT_EQ(refusal_of(text), "") << text;
}

TEST(Glyphs, ThatTheFontLacksAreRefusedByFileTextAndCharacter) {
  EXPECT_THAT(
      refusal_of("close \u9589\u3058\u308b"),
      AllOf(HasSubstr("texts-xx.json: /texts/close"), HasSubstr("DejaVuSans.ttf"), HasSubstr("U+9589")));
  EXPECT_THAT(refusal_of("\U0001F600"), HasSubstr("U+1F600"));
}

// DejaVu Sans has them, and ImGui would draw them backwards.
TEST(Glyphs, OfWritingFromRightToLeftAreRefused) {
  for (const char* text : {"(Enter) \u05e1\u05d2\u05d5\u05e8", "\u0627\u0644", "\ufefb", "\u202eesolC"})
    EXPECT_THAT(refusal_of(text),
                AllOf(HasSubstr("texts-xx.json: /texts/close: expected writing that runs from left to right"),
                      HasSubstr("got U+")))
        << text;
}

TEST(Glyphs, AreAskedForTheTableAndTheConsent) {
  const TempFolder folder;
  SessionProtocol protocol;
  protocol.language = "en";
  protocol.consent = Consent{"v7", {"first", "second"}};
  const auto shown = list_shown_texts({folder.path()}, protocol, load_texts("en", folder.path()));
  EXPECT_EQ(shown.back().place, "/consent/text/1");
  EXPECT_EQ(shown.back().text, "second");
  EXPECT_EQ(shown.back().file, StudyFolder{folder.path()}.session().string());
  EXPECT_EQ(shown.front().file, "the English texts");
  EXPECT_EQ(shown[shown.size() - 3].place, "/consent/version");
  EXPECT_EQ(shown[shown.size() - 3].text, "v7");
  EXPECT_EQ(shown.size(), load_texts("en", folder.path()).all().size() + 3);
}

}  // namespace
}  // namespace equilux
