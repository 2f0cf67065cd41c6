// Layers on disk.
#include "renderer/layer_store.h"

#include "base/digest.h"
#include "base/error.h"
#include "base/files.h"
#include "base/version.h"
#include "base/work_control.h"
#include "renderer/isa.h"

namespace equilux {
namespace fs = std::filesystem;

namespace {

std::string file_of(const std::string& layer) { return "layers/" + layer + ".exr"; }

// As a hard link where that works.
void copy_layer(const fs::path& source, const fs::path& target) {
  save_atomically(target, [&](const fs::path& part) {
    std::error_code error;
    // Of the file itself, were its name a symbolic link.
    const fs::path file = fs::canonical(source, error);
    if (!error) fs::create_hard_link(file, part, error);
    if (!error) return;
    fs::copy_file(source, part, fs::copy_options::overwrite_existing, error);
    if (error)
      throw StoreError(
          fmt::format("{}: cannot copy to {}: {}", source.string(), target.string(), error.message()));
  });
}

// That a file is the layer that its record takes it for: its bytes say what they are.
void check_origin(const ExrMetadata& metadata, const std::string& name, const std::string& made_from,
                  const fs::path& path) {
  for (const auto& [member, meant] : {std::pair{"equilux_key", &name}, {"equilux_made_from", &made_from}}) {
    const auto found = metadata.find(member);
    const std::string& told = found == metadata.end() ? "none" : found->second;
    if (told != *meant)
      throw InputError(path.string(), member, fmt::format("{}, as in layers.json", *meant), told);
  }
}

// Layers of older programs do not say it.
void check_vpl_count(const ExrMetadata& metadata, const LayerRecord& layer, const fs::path& path) {
  const auto found = metadata.find("equilux_vpl_count");
  if (found == metadata.end() || found->second == fmt::format("{}", layer.vpl_count)) return;
  throw InputError(path.string(), "equilux_vpl_count", fmt::format("{}, as in layers.json", layer.vpl_count),
                   found->second);
}

}  // namespace

LayerStore::LayerStore(StudyFolder folder, const Study& study)
    : folder_(std::move(folder)), width_(study.width), height_(study.height) {
  if (path_exists(folder_.layers())) layers_ = load_layers(folder_.layers());
  layers_.study_name = study.name;
  layers_.study_digest = study.digest;
  layers_.seed = study.seed;
  pending_ = layers_;
  pending_.by_name.clear();
  take_up_pending();
}

// Each is recorded before its file has its name, so that it may be of a file that was there before, or never.
void LayerStore::take_up_pending() {
  if (!is_file(folder_.pending_layers())) return;
  try {  // the boundary to making them again
    pending_.by_name = load_layers(folder_.pending_layers()).by_name;
  } catch (const InputError&) {
    return;
  }
  std::erase_if(pending_.by_name, [&](const auto& layer) { return !has_digest(layer.first, layer.second); });
  for (const auto& [name, layer] : pending_.by_name) {
    layers_.by_name[name] = layer;
    whole_.insert(name);
  }
}

void LayerStore::save_record() {
  save_layers(layers_, folder_.layers());
  pending_.by_name.clear();
  std::error_code stays;  // what it says is true
  fs::remove(folder_.pending_layers(), stays);
}

void LayerStore::save_group() {
  const std::size_t pending = pending_.by_name.size();
  if (pending * pending > layers_.by_name.size()) save_record();
}

bool LayerStore::is_whole(const std::string& name, const std::string& recipe) {
  check_control();  // a set has thousands to read
  const auto found = layers_.by_name.find(name);
  if (found == layers_.by_name.end() || found->second.made_from != recipe) return false;
  if (whole_.contains(name)) return true;
  if (!has_digest(name, found->second)) return false;
  whole_.insert(name);
  return true;
}

bool LayerStore::has_digest(const std::string& name, const LayerRecord& layer) {
  const fs::path path = folder_.root / layer.file;
  try {  // the boundary to making it again
    return is_file(path) && digest_file(path, most_file_bytes({width_, height_})) == layer.digest;
  } catch (const InputError& error) {
    unreadable_[name] = error.what();
    return false;
  }
}

std::vector<std::string> LayerStore::warnings() const {
  std::vector<std::string> warnings;
  for (const auto& [name, why] : unreadable_) warnings.push_back(why + "; the layer counts as missing");
  return warnings;
}

bool LayerStore::is_other(const std::string& name, const std::string& recipe) const {
  const auto found = layers_.by_name.find(name);
  return found != layers_.by_name.end() && found->second.made_from != recipe;
}

void LayerStore::save(const std::string& name, const std::string& recipe, const HdrImage& image,
                      ExrMetadata metadata, const VplRecord& vpls, Json reference) {
  const std::string file = file_of(name);
  metadata["equilux_key"] = name;
  metadata["equilux_study"] = layers_.study_name;
  metadata["equilux_seed"] = fmt::format("{}", layers_.seed);
  metadata["equilux_made_from"] = recipe;
  metadata["equilux_unit"] = image.channels == 1 ? "1" : "W/(m^2 sr)";  // coverage is a share
  metadata["equilux_version"] = kVersion;
  const std::string bytes = encode_exr(image, metadata);
  const LayerRecord layer{file,
                          digest_text(bytes),
                          recipe,
                          vpls.count,
                          vpls.vpls,
                          vpls.errors_1e5,
                          std::move(reference),
                          format_isa(current_isa())};
  pending_.by_name[name] = layer;
  save_layers(pending_, folder_.pending_layers());
  save_text(folder_.root / file, bytes);
  layers_.by_name[name] = layer;
  whole_.insert(name);
}

bool LayerStore::adopt(const std::string& name, const std::string& recipe, LayerStore& from) {
  if (!from.is_whole(name, recipe)) return false;
  LayerRecord record = from.record(name);
  const fs::path source = from.folder_.root / record.file;
  record.file = file_of(name);
  std::error_code same;
  if (!fs::equivalent(source, folder_.root / record.file, same))
    copy_layer(source, folder_.root / record.file);
  layers_.by_name[name] = std::move(record);
  whole_.insert(name);
  return true;
}

HdrImage LayerStore::load(const std::string& name) const {
  const LayerRecord& layer = record(name);
  const fs::path path = folder_.root / layer.file;
  if (!is_file(path)) throw InputError(path.string(), "", "an EXR file", "no such file");
  if (const std::string digest = digest_file(path, most_file_bytes({width_, height_}));
      digest != layer.digest) {
    throw InputError(path.string(), "",
                     fmt::format("the file recorded in layers.json, digest {}", layer.digest), digest);
  }
  ExrFile file = load_exr(path, PixelSize{width_, height_});
  check_origin(file.metadata, name, layer.made_from, path);
  check_vpl_count(file.metadata, layer, path);
  HdrImage image = std::move(file.image);
  const int channels = name.ends_with(".coverage") ? 1 : 3;
  if (image.channels != channels)
    throw InputError(path.string(), "", fmt::format("a layer of {} channels", channels),
                     fmt::format("{}", image.channels));
  return image;
}

const LayerRecord& LayerStore::record(const std::string& name) const {
  const auto found = layers_.by_name.find(name);
  if (found == layers_.by_name.end()) {
    throw InputError(folder_.layers().string(), "/layers", fmt::format("the layer {}", name),
                     "none; `equilux-render set` makes what is missing");
  }
  return found->second;
}

}  // namespace equilux
