// From a study to the cells and labels of a sheet.
#include "renderer/sheet.h"

#include <algorithm>
#include <fmt/ranges.h>
#include <functional>

#include "base/error.h"

namespace equilux {
namespace {

// The values in order of first appearance, each once.
template <typename T>
std::vector<T> keep_first(const std::vector<T>& values) {
  std::vector<T> kept;
  for (const T& value : values) {
    if (std::find(kept.begin(), kept.end(), value) == kept.end()) kept.push_back(value);
  }
  return kept;
}

template <typename T>
std::string list_names(const std::vector<T>& values, const std::function<std::string(const T&)>& format) {
  std::vector<std::string> names;
  for (const T& value : values) names.push_back(format(value));
  return fmt::format("{}", fmt::join(names, ", "));
}

// All that the study has, sorted, or those of it that were asked for.
template <typename T>
std::vector<T> choose(std::vector<T> has, const std::vector<T>& asked, const char* option,
                      const std::function<std::string(const T&)>& format) {
  std::sort(has.begin(), has.end());
  for (const T& value : asked) {
    if (std::find(has.begin(), has.end(), value) == has.end())
      throw InputError(option, "", "some of " + list_names(has, format), format(value));
  }
  std::erase_if(has, [&](const T& value) {
    return !asked.empty() && std::find(asked.begin(), asked.end(), value) == asked.end();
  });
  return has;
}

Object find_object(const Study& study, const std::string& key) {
  const auto objects = enumerate_objects(study);
  if (key.empty()) return objects.front();
  const auto format = [](const Object& object) { return format_key(object); };
  for (const Object& object : objects) {
    if (format(object) == key) return object;
  }
  throw InputError("--object", "", "one of " + list_names<Object>(objects, format), key);
}

std::vector<std::int64_t> find_vpl_counts(const Study& study, const Object& object) {
  std::vector<std::int64_t> counts;
  for (const Column& column : enumerate_columns(study)) {
    if (column.object == object) counts.push_back(column.vpl_count);
  }
  return keep_first(counts);
}

SheetLabel label_level(int level, bool normalised) {
  const std::string value = level == 0 ? "no clamp" : fmt::format("c = {:.3g}", clamp_per_m2(level));
  return {format_clamp(level, normalised), value};
}

std::string describe_illumination(Illumination illumination) {
  return illumination == Illumination::kIndirect ? "indirect light only" : "direct and indirect light";
}

void add_level(const Study& study, const Family& family, const std::vector<std::int64_t>& counts, int level,
               CellKind kind, Sheet& sheet) {
  sheet.rows.push_back(label_level(level, study.normalise));
  for (const std::int64_t count : counts) {
    const Condition condition{{{family.object, count}, level, study.normalise}, family.view};
    sheet.cells.push_back({kind, format_key(condition), family});
  }
  sheet.cells.push_back({CellKind::kPicture, format_key(family), family});
}

void name_clamp_sheet(const Study& study, const Family& family, Sheet& sheet) {
  sheet.title = fmt::format("{}: {}, view v{}", study.name, format_key(family.object), family.view);
  sheet.subtitle = "rows: clamp level, c per square metre";
  if (study.normalise) sheet.subtitle += ", luminance-normalised";
  if (sheet.kind == SheetKind::kDifference) sheet.title += ", difference to the reference";
}

Sheet make_clamp_sheet(const Study& study, const SheetParams& params) {
  const Family family{find_object(study, params.object), params.view};
  const auto counts = choose<std::int64_t>(find_vpl_counts(study, family.object), params.vpl_counts, "--vpls",
                                           [](const std::int64_t& count) { return format_vpl_count(count); });
  const auto levels = choose<int>(study.clamp_levels, params.clamp_levels, "--levels",
                                  [](const int& level) { return format_clamp(level); });
  Sheet sheet;
  sheet.kind = params.kind;
  name_clamp_sheet(study, family, sheet);
  for (const std::int64_t count : counts) sheet.columns.push_back(format_vpl_count(count) + " VPLs");
  sheet.columns.push_back("reference");
  const CellKind kind = params.kind == SheetKind::kDifference ? CellKind::kDifference : CellKind::kPicture;
  for (auto level = levels.rbegin(); level != levels.rend(); ++level)
    add_level(study, family, counts, *level, kind, sheet);
  return sheet;
}

// The references of one illumination and view, those of the study's own objects first.
std::vector<Family> find_families(const Study& study, Illumination illumination, int view) {
  std::vector<Family> families = enumerate_families(study);
  for (const Family& family : enumerate_references(study)) families.push_back(family);
  families = keep_first(families);
  std::erase_if(families, [&](const Family& family) {
    return family.object.illumination != illumination || family.view != view;
  });
  return families;
}

Illumination find_illumination(const Study& study, const SheetParams& params) {
  std::vector<Illumination> has;
  for (const Object& object : enumerate_objects(study)) has.push_back(object.illumination);
  has = keep_first(has);
  if (!params.illumination) return has.front();
  return choose<Illumination>(has, {*params.illumination}, "--illumination",
                              [](const Illumination& light) { return format_illumination(light); })
      .front();
}

void name_reference_sheet(const Study& study, Illumination illumination, int view, Sheet& sheet) {
  const bool error = sheet.kind == SheetKind::kError;
  sheet.title = fmt::format("{}: {}, view v{}", study.name,
                            error ? "standard error of the references" : "references", view);
  sheet.subtitle = describe_illumination(illumination);
}

void add_geometry(const std::string& geometry, const std::vector<Family>& families, CellKind kind,
                  Sheet& sheet) {
  sheet.rows.push_back({geometry, ""});
  for (const std::string& material : sheet.columns) {
    const auto found = std::find_if(families.begin(), families.end(), [&](const Family& family) {
      return family.object.geometry == geometry && family.object.material == material;
    });
    sheet.cells.push_back(found == families.end() ? SheetCell{}
                                                  : SheetCell{kind, format_key(*found), *found});
  }
}

Sheet make_reference_sheet(const Study& study, const SheetParams& params) {
  const Illumination illumination = find_illumination(study, params);
  const auto families = find_families(study, illumination, params.view);
  Sheet sheet;
  sheet.kind = params.kind;
  name_reference_sheet(study, illumination, params.view, sheet);
  std::vector<std::string> geometries;
  for (const Family& family : families) {
    geometries.push_back(family.object.geometry);
    sheet.columns.push_back(family.object.material);
  }
  sheet.columns = keep_first(sheet.columns);
  const CellKind kind = params.kind == SheetKind::kError ? CellKind::kError : CellKind::kPicture;
  for (const std::string& geometry : keep_first(geometries)) add_geometry(geometry, families, kind, sheet);
  return sheet;
}

}  // namespace

Sheet make_sheet_layout(const Study& study, const SheetParams& params) {
  const bool by_clamp = params.kind == SheetKind::kClamp || params.kind == SheetKind::kDifference;
  return by_clamp ? make_clamp_sheet(study, params) : make_reference_sheet(study, params);
}

}  // namespace equilux
