// layers.json, read and written.
#include "stimuli/layers.h"

#include "base/error.h"
#include "base/files.h"
#include "base/version.h"

namespace equilux {

extern const char kLayersSchema[];

namespace {

// Of the largest study: 88,000 rows of VPLs with 256 errors each, 5.1 KB, and 100,000 of references make 500
// MiB and 28 million values.
constexpr JsonLimits kLimits{.bytes = std::size_t{768} << 20, .values = 40'000'000};

}  // namespace

std::string layer_name(const Family& family, const std::string& content) {
  return format_key(family) + "." + content;
}

std::string vpl_layer_name(Condition condition) {
  condition.cell.normalised = false;
  return format_key(condition);
}

Layers load_layers(const std::filesystem::path& path) {
  const Json json = load_json(path, kLayersSchema, kLimits);
  Layers layers;
  layers.study_name = json.at("study").as_string();
  layers.study_digest = json.at("study_digest").as_string();
  layers.seed = static_cast<std::uint64_t>(json.at("seed").as_int());
  const auto& rows = json.at("layers").as_array();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Json& row = rows[i];
    const Json* count = row.find("vpl_count");
    LayerRecord record{row.at("file").as_string(), row.at("digest").as_string(),
                       row.at("made_from").as_string(), count ? count->as_int() : 0};
    if (const Json* vpls = row.find("vpls")) record.vpls = *vpls;
    if (const Json* errors = row.find("errors_1e5")) record.errors_1e5 = *errors;
    if (const Json* reference = row.find("reference")) record.reference = *reference;
    if (const Json* isa = row.find("isa")) record.isa = isa->as_string();
    if (!layers.by_name.emplace(row.at("name").as_string(), std::move(record)).second) {
      throw InputError(path.string(), fmt::format("/layers/{}/name", i), "each layer once",
                       row.at("name").as_string() + " again");
    }
  }
  return layers;
}

void save_layers(const Layers& layers, const std::filesystem::path& path) {
  Json rows{Json::Array{}};
  for (const auto& [name, layer] : layers.by_name) {
    Json row;
    row.set("name", name)
        .set("file", layer.file)
        .set("digest", layer.digest)
        .set("made_from", layer.made_from);
    if (layer.vpl_count > 0) row.set("vpl_count", layer.vpl_count);
    if (!layer.vpls.is_null()) row.set("vpls", layer.vpls);
    if (!layer.errors_1e5.is_null()) row.set("errors_1e5", layer.errors_1e5);
    if (!layer.reference.is_null()) row.set("reference", layer.reference);
    if (!layer.isa.empty()) row.set("isa", layer.isa);
    rows.push(std::move(row));
  }
  Json json;
  json.set("schema", "equilux-layers").set("schema_version", 1).set("producer_version", kVersion);
  json.set("study", layers.study_name).set("study_digest", layers.study_digest).set("seed", layers.seed);
  json.set("layers", std::move(rows));
  save_text(path, format_json(json));
}

}  // namespace equilux
