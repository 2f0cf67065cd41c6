// The cells of a sheet from a study folder: which are rendered, how they are cut, what they show.
#pragma once

#include <vector>

#include "renderer/layer_store.h"
#include "renderer/sheet.h"
#include "renderer/sheet_image.h"
#include "renderer/sheet_values.h"
#include "stimuli/manifest.h"

namespace equilux {

/// A study folder, opened to be read.
struct SheetSource {
  StudyFolder folder;
  Study study;
  Manifest manifest;
  LayerStore layers;
};

/// errors: InputError for what is no study folder, and where the pictures are another study's.
SheetSource open_sheet_source(const std::filesystem::path& root);

/// The picture file of a rendered cell, relative to the folder; empty for one that is not rendered.
std::string find_cell_file(const SheetSource& source, const SheetCell& cell);

/// In the sheet's order: the whole pictures, or parts of one size about the object of each.
/// errors: InputError for a coverage layer that is not there.
std::vector<Crop> find_cell_crops(const SheetSource& source, const Sheet& sheet, bool to_object);

/// How a cell is shown.
struct CellLook {
  int width = 0, height = 0;  ///< shrunk to this. units: pixels
  double scale = 32;          ///< of differences. units: displayed steps of 255
};

/// An empty picture where it is not rendered. errors: InputError where a file is not that of the manifest, or
/// a layer is not there.
LdrImage load_cell(const SheetSource& source, const SheetCell& cell, const Crop& crop, const CellLook& look,
                   const SheetImage& image);

/// What the colours of such a sheet mean; empty for pictures. units: `width` in pixels
ScaleBar make_scale_bar(SheetKind kind, double scale, int width);

}  // namespace equilux
