// Characters to ranges of glyphs.
#include "experiment/app/glyphs.h"

#include <algorithm>
#include <fmt/format.h>
#include <imgui.h>
#include <iterator>
#include <type_traits>

#include "base/error.h"
#include "base/files.h"

namespace equilux {
namespace {

static_assert(std::is_same_v<ImWchar, unsigned short>);
constexpr ImWchar kBase[] = {0x0020, 0x024F, 0x0370, 0x052F, 0x2010, 0x205E, 0x2190, 0x21FF, 0};
constexpr char32_t kNoCharacter = 0xFFFD, kFirstPrinted = 0x20, kLastOfImGui = 0xFFFF;

// Bytes that follow a first byte; -1 for what is none.
int count_following(unsigned char first) {
  if (first < 0x80) return 0;
  if (first >= 0xC2 && first < 0xE0) return 1;
  if (first >= 0xE0 && first < 0xF0) return 2;
  if (first >= 0xF0 && first < 0xF5) return 3;
  return -1;
}

// At `at`, which goes on to the next one.
char32_t read_character(const std::string& text, std::size_t& at) {
  const auto first = static_cast<unsigned char>(text[at++]);
  const int following = count_following(first);
  if (following < 0) return kNoCharacter;
  if (following == 0) return first;
  char32_t character = first & (0x3FU >> following);
  for (int i = 0; i < following; ++i) {
    if (at == text.size() || (static_cast<unsigned char>(text[at]) & 0xC0U) != 0x80U) return kNoCharacter;
    character = character << 6U | (static_cast<unsigned char>(text[at++]) & 0x3FU);
  }
  return character;
}

struct Span {
  char32_t first, last;
};
// Hebrew, Arabic and their neighbours with their forms, and marks of direction. source: Unicode 15,
// Bidi_Class
constexpr Span kRightToLeft[] = {{0x0590, 0x08FF}, {0x200F, 0x200F}, {0x202B, 0x202B}, {0x202E, 0x202E},
                                 {0x2067, 0x2067}, {0xFB1D, 0xFDFF}, {0xFE70, 0xFEFC}};

bool runs_to_the_left(char32_t character) {
  return std::any_of(std::begin(kRightToLeft), std::end(kRightToLeft),
                     [&](const Span& span) { return character >= span.first && character <= span.last; });
}

bool has_glyph(const ImFont& font, char32_t character) {
  if (character < kFirstPrinted) return true;  // new lines
  return character <= kLastOfImGui && font.FindGlyphNoFallback(static_cast<ImWchar>(character));
}

}  // namespace

std::vector<ShownText> list_shown_texts(const StudyFolder& folder, const SessionProtocol& protocol,
                                        const Texts& texts) {
  const auto path = find_texts_file(protocol.language, folder.root);
  const std::string file = path_exists(path) ? path.string() : "the English texts";
  std::vector<ShownText> shown;
  for (const auto& [name, text] : texts.all()) shown.push_back({file, "/texts/" + name, text});
  if (!protocol.consent) return shown;
  shown.push_back({folder.session().string(), "/consent/version", protocol.consent->version});
  for (std::size_t i = 0; i < protocol.consent->text.size(); ++i)
    shown.push_back(
        {folder.session().string(), fmt::format("/consent/text/{}", i), protocol.consent->text[i]});
  return shown;
}

std::vector<char32_t> decode_characters(const std::string& text) {
  std::vector<char32_t> characters;
  for (std::size_t at = 0; at < text.size();) characters.push_back(read_character(text, at));
  return characters;
}

std::vector<unsigned short> make_glyph_ranges(const std::vector<ShownText>& texts) {
  ImFontGlyphRangesBuilder builder;
  builder.AddRanges(kBase);
  for (const ShownText& shown : texts) builder.AddText(shown.text.c_str());
  ImVector<ImWchar> ranges;
  builder.BuildRanges(&ranges);
  return {ranges.begin(), ranges.end()};
}

void check_glyphs(const ImFont& font, const std::string& font_name, const std::vector<ShownText>& texts) {
  for (const ShownText& shown : texts) {
    for (const char32_t character : decode_characters(shown.text)) {
      const std::string name = fmt::format("U+{:04X}", static_cast<std::uint32_t>(character));
      // The font may have it, but each line is drawn from the left, letter by letter.
      if (runs_to_the_left(character))
        throw InputError(shown.file, shown.place, "writing that runs from left to right", name);
      if (!has_glyph(font, character))
        throw InputError(shown.file, shown.place, fmt::format("characters that {} has", font_name), name);
    }
  }
}

}  // namespace equilux
