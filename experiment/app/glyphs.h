// Which characters a subject's texts need, and whether the font has them.
#pragma once

#include <string>
#include <vector>

#include "experiment/texts.h"
#include "protocols/session_protocol.h"
#include "stimuli/study_folder.h"

struct ImFont;

namespace equilux {

/// A text that a subject reads.
struct ShownText {
  std::string file;
  std::string place;  ///< JSON pointer
  std::string text;
};

/// The table of texts, the version of the consent and its text.
std::vector<ShownText> list_shown_texts(const StudyFolder& folder, const SessionProtocol& protocol,
                                        const Texts& texts);

/// Characters of UTF-8; what is none counts as U+FFFD.
std::vector<char32_t> decode_characters(const std::string& text);

/// For ImGui, with a 0 at their end: Latin, Greek, Cyrillic, general punctuation, arrows, and what these
/// texts need beside.
std::vector<unsigned short> make_glyph_ranges(const std::vector<ShownText>& texts);

/// errors: InputError naming file, text and the first character that `font`, called `font_name`, has no glyph
/// for, or whose writing runs from right to left: it would be drawn the wrong way round.
void check_glyphs(const ImFont& font, const std::string& font_name, const std::vector<ShownText>& texts);

}  // namespace equilux
