// Cells of a sheet, read by the manifest.
#include "renderer/sheet_cells.h"

#include <algorithm>
#include <map>

#include "base/digest.h"
#include "base/error.h"
#include "base/files.h"
#include "renderer/compose.h"
#include "renderer/tone.h"
#include "stimuli/png_file.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

Manifest load_pictures_of(const StudyFolder& folder, const Study& study) {
  if (!path_exists(folder.manifest())) return {};
  Manifest manifest = load_manifest(folder.manifest());
  if (manifest.study_digest != study.digest) {
    throw InputError(folder.manifest().string(), "/study_digest",
                     fmt::format("{}, of {}", study.digest, folder.study().string()), manifest.study_digest);
  }
  return manifest;
}

std::string find_picture_file(const SheetSource& source, const std::string& key) {
  const auto found = source.manifest.pictures.find(key);
  if (found == source.manifest.pictures.end()) return "";
  return is_file(source.folder.root / found->second.file) ? found->second.file : "";
}

LdrImage load_picture(const SheetSource& source, const std::string& key) {
  const PictureRecord& record = source.manifest.pictures.at(key);
  const fs::path path = source.folder.root / record.file;
  if (const std::string digest = digest_file(path); digest != record.digest) {
    throw InputError(path.string(), "",
                     fmt::format("the file recorded in manifest.json, digest {}", record.digest), digest);
  }
  const PixelSize size = load_png_size(path);  // before it takes memory
  if (size != PixelSize{source.study.width, source.study.height}) {
    throw InputError(path.string(), "",
                     fmt::format("{} x {} pixels", source.study.width, source.study.height),
                     fmt::format("{} x {}", size.width, size.height));
  }
  return load_png(path);
}

const ToneRecord& find_tone(const SheetSource& source, const std::string& key) {
  const auto found = source.manifest.tones.find(key);
  if (found == source.manifest.tones.end())
    throw InputError(source.folder.manifest().string(), "/tones", "the tone curve of " + key, "none");
  return found->second;
}

// One channel. units: displayed steps of 255
HdrImage measure_error(const SheetSource& source, const SheetCell& cell) {
  std::vector<double> noise;
  with_family_memory(source.folder, source.study, [&] {
    LoadedFamily loaded = load_family(source.study, source.layers, cell.family);
    const ToneRecord& recorded = find_tone(source, format_key(cell.family));
    if (recorded.tone_operator != loaded.tone.record.tone_operator) {
      throw InputError(source.folder.manifest().string(), "/tones",
                       fmt::format("the study's operator, {}", loaded.tone.record.tone_operator),
                       recorded.tone_operator);
    }
    loaded.tone.record = recorded;
    const HdrImage reference = composite({&loaded.base, &loaded.indirect});
    noise = measure_pixel_noise(reference, loaded.standard_error, loaded.tone);
  });
  HdrImage steps(source.study.width, source.study.height, 1);
  std::transform(noise.begin(), noise.end(), steps.values.begin(),
                 [](double value) { return static_cast<float>(value); });
  return steps;
}

HdrImage load_values(const SheetSource& source, const SheetCell& cell) {
  if (cell.kind == CellKind::kError) return measure_error(source, cell);
  const LdrImage picture = load_picture(source, cell.key);
  if (cell.kind == CellKind::kPicture) return to_linear(picture);
  return measure_difference(picture, load_picture(source, format_key(cell.family)));
}

LdrImage show_error(const HdrImage& steps) {
  return show_noise({steps.values.begin(), steps.values.end()}, steps.width, steps.height);
}

LdrImage show_values(const HdrImage& values, CellKind kind, double scale) {
  if (kind == CellKind::kPicture) return to_display(values);
  return kind == CellKind::kError ? show_error(values) : show_difference(values, scale);
}

// From `first` to `last` in even steps.
HdrImage make_ramp(int width, double first, double last) {
  HdrImage ramp(width, 1, 1);
  for (int x = 0; x < width; ++x)
    ramp.values[static_cast<std::size_t>(x)] = static_cast<float>(first + (last - first) * (x + 0.5) / width);
  return ramp;
}

}  // namespace

SheetSource open_sheet_source(const fs::path& root) {
  const StudyFolder folder{root};
  Study study = load_folder_study(folder);
  Manifest manifest = load_pictures_of(folder, study);
  LayerStore layers(folder, study);
  return {folder, std::move(study), std::move(manifest), std::move(layers)};
}

std::string find_cell_file(const SheetSource& source, const SheetCell& cell) {
  if (cell.kind == CellKind::kNone) return "";
  const bool lacks_reference =
      cell.kind == CellKind::kDifference && find_picture_file(source, format_key(cell.family)).empty();
  return lacks_reference ? "" : find_picture_file(source, cell.key);
}

std::vector<Crop> find_cell_crops(const SheetSource& source, const Sheet& sheet, bool to_object) {
  const int width = source.study.width, height = source.study.height;
  if (!to_object) return std::vector<Crop>(sheet.cells.size(), Crop{0, 0, width, height});
  std::map<Family, Crop> known;
  std::vector<Crop> boxes;
  for (const SheetCell& cell : sheet.cells) {
    if (find_cell_file(source, cell).empty()) {
      boxes.push_back({width / 2, height / 2, 0, 0});
      continue;
    }
    if (!known.contains(cell.family))
      known[cell.family] = find_object_box(source.layers.load(layer_name(cell.family, "coverage")));
    boxes.push_back(known[cell.family]);
  }
  return make_crops(boxes, width, height);
}

LdrImage load_cell(const SheetSource& source, const SheetCell& cell, const Crop& crop, const CellLook& look,
                   const SheetImage& image) {
  if (find_cell_file(source, cell).empty()) return {};
  HdrImage values = cut_image(load_values(source, cell), crop);
  if (look.width < values.width) values = image.shrink_image(values, look.width, look.height);
  return show_values(values, cell.kind, look.scale);
}

ScaleBar make_scale_bar(SheetKind kind, double scale, int width) {
  if (kind == SheetKind::kDifference) {
    return {show_difference(make_ramp(width, -scale, scale), scale),
            {fmt::format("-{}", scale), "0", fmt::format("+{}", scale)},
            "displayed luminance less the reference's, steps of 255"};
  }
  if (kind == SheetKind::kError)
    return {show_error(make_ramp(width, 0, 5)), {"0", "1", "2", "3", "4", "5"}, "displayed steps of 255"};
  return {};
}

}  // namespace equilux
