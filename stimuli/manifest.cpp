// manifest.json, read and written.
#include "stimuli/manifest.h"

#include <algorithm>

#include "base/digest.h"
#include "base/error.h"
#include "base/files.h"
#include "base/version.h"

namespace equilux {

extern const char kManifestSchema[];

namespace {

// Of the largest study: 88,000 pictures of 1 KB and 20,000 references of 2 KB make 125 MiB and 4 million
// values.
constexpr JsonLimits kLimits{.bytes = std::size_t{256} << 20, .values = 10'000'000};

}  // namespace

Manifest load_manifest(const std::filesystem::path& path) {
  const Json json = load_json(path, kManifestSchema, kLimits);
  Manifest manifest;
  manifest.study_name = json.at("study").as_string();
  manifest.study_digest = json.at("study_digest").as_string();
  manifest.seed = static_cast<std::uint64_t>(json.at("seed").as_int());
  manifest.width = static_cast<int>(json.at("width").as_int());
  manifest.height = static_cast<int>(json.at("height").as_int());
  if (const Json* target = json.find("noise_target")) {
    manifest.noise_target = {target->at("object_mean").as_double(), target->at("object_p99").as_double(),
                             target->at("outside_mean").as_double()};
  }
  const auto& tones = json.at("tones").as_array();
  for (std::size_t i = 0; i < tones.size(); ++i) {
    const Json& tone = tones[i];
    const Json* operation = tone.find("operator");
    const ToneRecord record{
        tone.at("log_average").as_double(), tone.at("white").as_double(),
        tone.at("delta").as_double(),       tone.at("key").as_double(),
        tone.at("exposure").as_string(),    operation ? operation->as_string() : "global"};
    if (!manifest.tones.emplace(tone.at("family").as_string(), record).second) {
      throw InputError(path.string(), fmt::format("/tones/{}/family", i), "each family once",
                       tone.at("family").as_string() + " again");
    }
  }
  const auto& pictures = json.at("pictures").as_array();
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const Json& picture = pictures[i];
    const auto find = [&](const char* member) {
      const Json* found = picture.find(member);
      return found ? *found : Json();
    };
    PictureRecord record{picture.at("file").as_string(),
                         picture.at("digest").as_string(),
                         picture.at("made_from").as_string(),
                         find("standard_error"),
                         find("reference"),
                         find("vpls")};
    if (!manifest.pictures.emplace(picture.at("key").as_string(), std::move(record)).second) {
      throw InputError(path.string(), fmt::format("/pictures/{}/key", i), "each picture once",
                       picture.at("key").as_string() + " again");
    }
  }
  return manifest;
}

void save_manifest(const Manifest& manifest, const std::filesystem::path& path) {
  Json json;
  json.set("schema", "equilux-manifest").set("schema_version", 1).set("producer_version", kVersion);
  json.set("study", manifest.study_name).set("study_digest", manifest.study_digest);
  json.set("seed", manifest.seed).set("width", manifest.width).set("height", manifest.height);
  if (const auto& target = manifest.noise_target) {
    Json row;
    row.set("object_mean", target->object_mean).set("object_p99", target->object_p99);
    row.set("outside_mean", target->outside_mean);
    json.set("noise_target", std::move(row));
  }
  Json tones{Json::Array{}};
  for (const auto& [family, tone] : manifest.tones) {
    Json row;
    row.set("family", family).set("log_average", tone.log_average).set("white", tone.white);
    row.set("delta", tone.delta).set("key", tone.key).set("exposure", tone.exposure);
    row.set("operator", tone.tone_operator);
    tones.push(std::move(row));
  }
  Json pictures{Json::Array{}};
  for (const auto& [key, picture] : manifest.pictures) {
    Json row;
    row.set("key", key)
        .set("file", picture.file)
        .set("digest", picture.digest)
        .set("made_from", picture.made_from);
    if (!picture.standard_error.is_null()) row.set("standard_error", picture.standard_error);
    if (!picture.reference.is_null()) row.set("reference", picture.reference);
    if (!picture.vpls.is_null()) row.set("vpls", picture.vpls);
    pictures.push(std::move(row));
  }
  json.set("tones", std::move(tones)).set("pictures", std::move(pictures));
  save_text(path, format_json(json));
}

std::string digest_pictures(const Manifest& manifest, const std::vector<std::string>& keys,
                            const std::string& source) {
  std::vector<std::string> sorted = keys;
  std::sort(sorted.begin(), sorted.end());
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  std::string text;
  for (const std::string& key : sorted) {
    const auto found = manifest.pictures.find(key);
    if (found == manifest.pictures.end()) {
      throw InputError(source, "/pictures", fmt::format("the picture {}", key),
                       "none; `equilux-render set` makes what is missing");
    }
    text += fmt::format("{} {}\n", key, found->second.digest);
  }
  return digest_text(text);
}

}  // namespace equilux
