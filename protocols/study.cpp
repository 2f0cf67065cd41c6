// From a study file to a checked Study, and from its factors to lists of what must exist.
#include "protocols/study.h"

#include <algorithm>
#include <set>

#include "base/error.h"
#include "base/files.h"

namespace equilux {

extern const char kStudySchema[];

namespace {
namespace fs = std::filesystem;

Block make_block(const Json& json, const std::string& source, const std::string& place) {
  Block block;
  block.geometries = json.at("geometries").as_strings();
  block.materials = json.at("materials").as_strings();
  for (const std::string& text : json.at("illuminations").as_strings()) {
    block.illuminations.push_back(parse_illumination(text, source, place + "/illuminations"));
  }
  for (const std::string& text : json.at("vpl_counts").as_strings()) {
    block.vpl_counts.push_back(parse_vpl_count(text, source, place + "/vpl_counts"));
  }
  std::sort(block.vpl_counts.begin(), block.vpl_counts.end());
  return block;
}

std::vector<Column> columns_of(const Block& block) {
  std::vector<Column> columns;
  for (const auto& geometry : block.geometries) {
    for (const auto& material : block.materials) {
      for (const auto illumination : block.illuminations) {
        for (const auto vpl_count : block.vpl_counts)
          columns.push_back({{geometry, material, illumination}, vpl_count});
      }
    }
  }
  return columns;
}

// 33 times what the main study has, and 88,000 pictures.
constexpr std::size_t kMostColumns = 4000;

void check_blocks(const Study& study, const std::string& source) {
  std::set<Column> seen;
  std::size_t count = 0;
  for (std::size_t i = 0; i < study.blocks.size(); ++i) {
    const Block& block = study.blocks[i];
    count += block.geometries.size() * block.materials.size() * block.illuminations.size() *
             block.vpl_counts.size();
    if (count > kMostColumns) {
      throw InputError(source, fmt::format("/blocks/{}", i),
                       fmt::format("at most {} columns in all", kMostColumns),
                       fmt::format("{} up to this block", count));
    }
    for (const Column& column : columns_of(study.blocks[i])) {
      if (!seen.insert(column).second) {
        throw InputError(source, fmt::format("/blocks/{}", i), "columns that no other block has",
                         format_key(column));
      }
    }
  }
}

// Of both views: 8,000 of as many objects as columns, and one and a half other materials of each. Five layers
// of each and those of 88,000 pictures stay within the rows that layers.json may have.
constexpr std::size_t kMostReferences = 20'000;

void check_references(const Study& study, const std::string& source) {
  if (const std::size_t count = enumerate_references(study).size(); count > kMostReferences) {
    throw InputError(source, "/reference_materials",
                     fmt::format("at most {} references in all", kMostReferences), fmt::format("{}", count));
  }
}

// As enumerate_reference_materials, of a study whose objects are known.
std::vector<std::string> reference_materials_of(const Study& study, const std::vector<Object>& objects,
                                                const Object& object) {
  std::vector<std::string> materials;
  for (const Object& other : objects) {
    const bool same_place = other.geometry == object.geometry && other.illumination == object.illumination;
    if (same_place && other.material != object.material) materials.push_back(other.material);
  }
  if (!materials.empty()) return materials;
  for (const std::string& material : study.reference_materials) {
    if (material != object.material) materials.push_back(material);
  }
  return materials;
}

void check_reference_materials(const Study& study, const std::string& source) {
  const std::vector<Object> objects = enumerate_objects(study);
  for (const Object& object : objects) {
    if (reference_materials_of(study, objects, object).empty()) {
      throw InputError(source, "/reference_materials",
                       fmt::format("a material other than {}, for the artifact references of {}",
                                   object.material, format_key(object)),
                       study.reference_materials.empty() ? "none" : object.material);
    }
  }
}

ToneMapping read_tone(const Json& json) {
  ToneMapping tone;
  tone.key = json.at("tone_key").as_double();
  tone.exposure = json.at("exposure").as_string() == "whole" ? Exposure::kWhole : Exposure::kBackground;
  if (const Json* operation = json.find("tone_operator"))
    tone.operation = operation->as_string() == "local" ? ToneOperator::kLocal : ToneOperator::kGlobal;
  return tone;
}

// By sets unless the study says otherwise; they need a noise target.
ReferenceMethod parse_reference(const Study& study, const std::string& source) {
  const Json* reference = study.source.find("reference");
  if (!reference) return study.paths ? ReferenceMethod::kPath : ReferenceMethod::kCompensated;
  if (reference->as_string() == "path") return ReferenceMethod::kPath;
  if (study.paths)
    throw InputError(source, "/reference", "path, since /paths fixes their number", reference->as_string());
  return ReferenceMethod::kCompensated;
}

template <typename T>
std::vector<T> without_repetition(const std::vector<T>& values) {
  std::vector<T> unique;
  std::set<T> seen;
  for (const T& value : values) {
    if (seen.insert(value).second) unique.push_back(value);
  }
  return unique;
}

std::vector<Family> in_both_views(const std::vector<Object>& objects) {
  std::vector<Family> families;
  for (const Object& object : objects) {
    for (int view = 0; view < kViewCount; ++view) families.push_back({object, view});
  }
  return families;
}

constexpr int kMostExtensions = 8;

// Names of files that stand beside the study that names them.
constexpr const char* kFileMembers[] = {"scene", "windows", "truth", "session"};

fs::path folder_of(const fs::path& file) {
  return fs::absolute(file.has_parent_path() ? file.parent_path() : fs::path(".")).lexically_normal();
}

// The base's member, as it is found from the folder of the study that extends it.
Json take_over(const std::string& member, const Json& value, const fs::path& from, const fs::path& to) {
  const bool is_file =
      std::find(std::begin(kFileMembers), std::end(kFileMembers), member) != std::end(kFileMembers);
  if (!is_file || !value.is_string() || from == to || fs::path(value.as_string()).is_absolute()) return value;
  return (from / value.as_string()).lexically_normal().lexically_relative(to).generic_string();
}

// A study file without what it extends: members that it has replace those of the base, and more_blocks are
// added to the blocks.
Json load_extended(const fs::path& path, int depth) {
  Json own = parse_json(load_text(path), path.string());
  const Json* base_name = own.find("extends");
  if (!base_name) return own;
  const auto refuse = [&](const char* member, std::string expected, std::string got) {
    throw InputError(path.string(), std::string("/") + member, std::move(expected), std::move(got));
  };
  if (!base_name->is_string() || base_name->as_string().empty())
    refuse("extends", "the name of a study file", describe_json(*base_name));
  if (depth == kMostExtensions)
    refuse("extends", fmt::format("a chain of at most {} studies", kMostExtensions), "a longer one");
  const fs::path base_path = path.parent_path() / base_name->as_string();
  const Json base = load_extended(base_path, depth + 1);
  if (!base.is_object()) refuse("extends", "a study file", describe_json(base));
  Json merged;
  for (const auto& [member, value] : base.as_object())
    merged.set(member, take_over(member, value, folder_of(base_path), folder_of(path)));
  for (const auto& [member, value] : own.as_object()) {
    if (member != "extends" && member != "more_blocks") merged.set(member, value);
  }
  if (const Json* more = own.find("more_blocks")) {
    const Json* blocks = merged.find("blocks");
    if (!more->is_array() || !blocks || !blocks->is_array())
      refuse("more_blocks", "an array, and one in the base", describe_json(*more));
    Json all = *blocks;
    for (const Json& block : more->as_array()) all.push(block);
    merged.set("blocks", std::move(all));
  }
  return merged;
}

}  // namespace

Study load_study(const fs::path& path) {
  const std::string source = path.string();
  Study study;
  study.source = load_extended(path, 1);
  validate_json(study.source, kStudySchema, source);
  study.digest = digest_json(study.source);
  const Json& json = study.source;
  const auto beside = [&](const char* member) {
    return (path.parent_path() / json.at(member).as_string()).lexically_normal();
  };
  study.name = json.at("name").as_string();
  if (const Json* description = json.find("description")) study.description = description->as_string();
  study.scene_path = beside("scene");
  study.windows_path = beside("windows");
  study.truth_path = beside("truth");
  if (json.find("session")) study.session_path = beside("session");
  study.seed = static_cast<std::uint64_t>(json.at("seed").as_int());
  study.width = static_cast<int>(json.at("image").at("width").as_int());
  study.height = static_cast<int>(json.at("image").at("height").as_int());
  study.subpixel_positions = static_cast<int>(json.at("subpixel_positions").as_int());
  if (const Json* paths = json.find("paths")) {
    const auto count = [&](const char* member) { return static_cast<int>(paths->at(member).as_int()); };
    study.paths = {count("object_indirect"), count("object_direct"), count("background")};
  }
  if (const Json* emission = json.find("emission"))
    study.emission = emission->as_string() == "full" ? Emission::kFull : Emission::kLambertian;
  const Json& noise = json.at("noise_target");
  study.noise_target = {noise.at("object_mean").as_double(), noise.at("object_p99").as_double(),
                        noise.at("outside_mean").as_double()};
  study.reference = parse_reference(study, source);
  study.tone = read_tone(json);
  const Json* planned = json.find("planned_tone");
  study.planned_tone = planned ? read_tone(*planned) : study.tone;
  for (const std::string& text : json.at("clamp_levels").as_strings()) {
    study.clamp_levels.push_back(parse_clamp_level(text, source, "/clamp_levels"));
  }
  std::sort(study.clamp_levels.begin(), study.clamp_levels.end());
  if (const Json* certified = json.find("certified")) study.certified = certified->as_bool();
  if (const Json* normalise = json.find("normalise")) study.normalise = normalise->as_bool();
  study.view_mode =
      json.at("view_mode").as_string() == "pair_turned" ? ViewMode::kPairTurned : ViewMode::kReferenceTurned;
  if (const Json* materials = json.find("reference_materials"))
    study.reference_materials = materials->as_strings();
  study.target_degrees_wide = json.at("target").at("degrees_wide").as_double();
  study.target_degrees_high = json.at("target").at("degrees_high").as_double();
  study.viewing_distance_m = json.at("target").at("viewing_distance_m").as_double();
  for (const auto& [experiment, subjects] : json.at("subjects").as_object()) {
    study.subjects[experiment] = static_cast<int>(subjects.as_int());
  }
  const Json& blocks = json.at("blocks");
  for (std::size_t i = 0; i < blocks.as_array().size(); ++i) {
    study.blocks.push_back(make_block(blocks.at(i), source, fmt::format("/blocks/{}", i)));
  }
  check_blocks(study, source);
  check_reference_materials(study, source);
  check_references(study, source);
  return study;
}

std::vector<Object> enumerate_objects(const Study& study) {
  std::vector<Object> objects;
  for (const Column& column : enumerate_columns(study)) objects.push_back(column.object);
  return without_repetition(objects);
}

std::vector<Column> enumerate_columns(const Study& study) {
  std::vector<Column> columns;
  for (const Block& block : study.blocks) {
    const auto more = columns_of(block);
    columns.insert(columns.end(), more.begin(), more.end());
  }
  return columns;
}

std::vector<Cell> enumerate_cells(const Study& study) {
  std::vector<Cell> cells;
  for (const Column& column : enumerate_columns(study)) {
    for (int level : study.clamp_levels) cells.push_back({column, level, study.normalise});
  }
  return cells;
}

std::vector<Condition> enumerate_conditions(const Study& study) {
  std::vector<Condition> conditions;
  for (const Cell& cell : enumerate_cells(study)) {
    for (int view = 0; view < kViewCount; ++view) conditions.push_back({cell, view});
  }
  return conditions;
}

std::vector<Family> enumerate_families(const Study& study) { return in_both_views(enumerate_objects(study)); }

std::vector<Family> enumerate_references(const Study& study) {
  const std::vector<Object> own = enumerate_objects(study);
  std::vector<Object> objects = own;
  for (const Object& object : own) {
    for (const std::string& material : reference_materials_of(study, own, object)) {
      objects.push_back({object.geometry, material, object.illumination});
    }
  }
  return in_both_views(without_repetition(objects));
}

std::vector<std::string> enumerate_reference_materials(const Study& study, const Object& object) {
  return reference_materials_of(study, enumerate_objects(study), object);
}

}  // namespace equilux
