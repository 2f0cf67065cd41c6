// The table of a sheet in HTML.
#include "renderer/sheet_html.h"

#include <fmt/format.h>

namespace equilux {
namespace {

constexpr const char* kStyle =
    "body { margin: 2em; color: #1a1a1a; background: #fff; font: 15px/1.4 Helvetica, Arial, 'DejaVu Sans', "
    "sans-serif; }\n"
    "h1 { font-size: 1.2em; margin: 0; } p { color: #666; margin: .2em 0 1em; }\n"
    "table { border-collapse: collapse; } td { padding: 2px; } th { padding: 2px 8px; white-space: nowrap; "
    "}\n"
    "tr > th:first-child { text-align: left; } small { font-weight: normal; margin-left: .5em; }\n"
    ".cell { display: block; overflow: hidden; } .cell img { display: block; max-width: none; }\n"
    ".none { background: #f0f0f0; color: #666; display: grid; place-items: center; font-size: 12px; }\n";

std::string escape(const std::string& text) {
  std::string escaped;
  for (const char character : text) {
    const std::string_view special = "&<>\"'";
    escaped += special.find(character) == special.npos ? std::string(1, character)
                                                       : fmt::format("&#{};", static_cast<int>(character));
  }
  return escaped;
}

// Every byte that a path in a URL may not hold as it is. source: RFC 3986, section 2.3
std::string encode_path(const std::string& path) {
  std::string encoded;
  for (const char character : path) {
    const bool plain = (character >= 'a' && character <= 'z') || (character >= 'A' && character <= 'Z') ||
                       (character >= '0' && character <= '9') ||
                       std::string_view("-._~/").find(character) != std::string_view::npos;
    encoded += plain ? std::string(1, character)
                     : fmt::format("%{:02X}", static_cast<unsigned>(static_cast<unsigned char>(character)));
  }
  return encoded;
}

// source: RFC 4648, section 4
std::string encode_base64(std::string_view bytes) {
  constexpr const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned bits = 0;
    for (std::size_t j = 0; j < 3; ++j)
      bits = bits << 8 | (i + j < bytes.size() ? static_cast<unsigned char>(bytes[i + j]) : 0u);
    for (std::size_t j = 0; j < 4; ++j)
      text += i + j <= bytes.size() ? digits[bits >> (18 - 6 * j) & 63] : '=';
  }
  return text;
}

std::string format_size(const HtmlSheet& html) {
  return fmt::format("width:{}px;height:{}px", html.cell_width, html.cell_height);
}

// The file, moved under the window that the cell is; or the bytes, which fill it.
std::string format_image(const HtmlCell& cell, const HtmlSheet& html, const std::string& name) {
  if (!cell.bytes.empty()) {
    return fmt::format(R"(<img alt="{}" style="{}" src="data:image/png;base64,{}">)", name, format_size(html),
                       encode_base64(cell.bytes));
  }
  const double factor = static_cast<double>(html.cell_width) / cell.crop.width;
  return fmt::format(R"(<img alt="{}" style="width:{:.2f}px;margin:{:.2f}px 0 0 {:.2f}px" src="{}">)", name,
                     factor * html.picture_width, -factor * cell.crop.y, -factor * cell.crop.x,
                     encode_path(cell.file));
}

std::string format_cell(const SheetCell& cell, const HtmlCell& shown, const HtmlSheet& html) {
  if (cell.kind == CellKind::kNone) return "<td></td>";
  const std::string name = escape(cell.key);
  if (shown.file.empty()) {
    return fmt::format(R"(<td><span class="cell none" style="{}" title="{}">not rendered</span></td>)",
                       format_size(html), name);
  }
  return fmt::format(R"(<td><a class="cell" style="{}" title="{}" href="{}">{}</a></td>)", format_size(html),
                     name, encode_path(shown.file), format_image(shown, html, name));
}

std::string format_row(const Sheet& sheet, std::size_t row, const HtmlSheet& html) {
  std::string text = fmt::format("<tr><th>{}<small>{}</small></th>\n", escape(sheet.rows[row].name),
                                 escape(sheet.rows[row].note));
  for (std::size_t column = 0; column < sheet.columns.size(); ++column) {
    const SheetCell& cell = sheet.cell(row, column);
    text += format_cell(cell, html.cells[row * sheet.columns.size() + column], html) + "\n";
  }
  return text + "</tr>\n";
}

}  // namespace

std::string format_sheet_html(const Sheet& sheet, const HtmlSheet& html) {
  std::string text = fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{0}</title>\n"
      "<style>\n{1}</style></head><body>\n<h1>{0}</h1>\n<p>{2}{3}</p>\n<table>\n<tr><th></th>",
      escape(sheet.title), kStyle, escape(sheet.subtitle),
      html.scale.empty() ? "" : "; " + escape(html.scale));
  for (const std::string& column : sheet.columns) text += fmt::format("<th>{}</th>", escape(column));
  text += "</tr>\n";
  for (std::size_t row = 0; row < sheet.rows.size(); ++row) text += format_row(sheet, row, html);
  return text + "</table>\n</body></html>\n";
}

}  // namespace equilux
