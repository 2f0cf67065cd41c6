// A contact sheet of a study: which picture stands in which cell and what the labels say. It opens no file.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "protocols/study.h"

namespace equilux {

/// source: Křivánek, Ferwerda, Bala, SIGGRAPH 2010: kClamp is like figure 3, kReferences like 5 and 8.
enum class SheetKind { kClamp, kReferences, kDifference, kError };

/// What is left empty is the study's first object or illumination, or all its levels and counts.
struct SheetParams {
  SheetKind kind = SheetKind::kClamp;
  int view = 0;
  std::string object;                        ///< its key; of clamp and difference
  std::vector<int> clamp_levels;             ///< of clamp and difference
  std::vector<std::int64_t> vpl_counts;      ///< of clamp and difference
  std::optional<Illumination> illumination;  ///< of references and error
};

enum class CellKind {
  kNone,        ///< the study has no such picture
  kPicture,     ///< as it is shown
  kDifference,  ///< its luminance less that of its reference, as displayed
  kError        ///< the standard error of a reference, as displayed
};

struct SheetCell {
  CellKind kind = CellKind::kNone;
  std::string key;  ///< of the picture
  Family family;    ///< whose reference and coverage go with it
};

struct SheetLabel {
  std::string name;  ///< C4
  std::string note;  ///< c = 10
};

struct Sheet {
  SheetKind kind = SheetKind::kClamp;
  std::string title;
  std::string subtitle;
  std::vector<std::string> columns;
  std::vector<SheetLabel> rows;  ///< from the top
  std::vector<SheetCell> cells;  ///< shape: rows x columns, row-major from the top left

  const SheetCell& cell(std::size_t row, std::size_t column) const {
    return cells[row * columns.size() + column];
  }
};

/// Clamp and difference: columns the VPL counts from few to many, then the reference; rows the clamp levels,
/// C0 at the bottom. References and error: rows geometries, columns materials, in the study's order. errors:
/// InputError for what the study lacks, naming what it has.
Sheet make_sheet_layout(const Study& study, const SheetParams& params);

}  // namespace equilux
