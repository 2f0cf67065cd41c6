// A set: check, render what is missing, tone-map, tell.
#include "renderer/set.h"

#include <chrono>
#include <set>
#include <unistd.h>

#include "base/digest.h"
#include "base/error.h"
#include "base/files.h"
#include "base/program.h"
#include "base/progress.h"
#include "base/version.h"
#include "renderer/layer_store.h"
#include "renderer/parallel.h"
#include "renderer/render_layers.h"
#include "renderer/wanted.h"
#include "stimuli/png_file.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// True once subjects may have seen pictures: the session program makes the log with its first session.
bool has_sessions(const StudyFolder& folder) { return fs::exists(folder.responses()); }

[[noreturn]] void refuse_change(const StudyFolder& folder, const std::string& what) {
  throw InputError(folder.root.string(), "",
                   "what its sessions have seen: " + folder.responses().string() + " exists",
                   what + "; render into a new folder");
}

void prepare_folder(const StudyFolder& folder, const Study& study) {
  if (has_sessions(folder) && fs::exists(folder.study())) {
    if (load_study(folder.study()).digest != study.digest) refuse_change(folder, "another study");
  }
  for (const fs::path& part : {folder.root, folder.layer_folder(), folder.picture_folder()}) {
    make_folder(part);
    remove_stale_parts(part);
  }
  save_text(folder.study(), format_json(study.source));
  // Windows and truth are a person's to edit once they are here.
  if (!fs::exists(folder.windows())) save_text(folder.windows(), load_text(study.windows_path));
  if (!fs::exists(folder.truth())) save_text(folder.truth(), load_text(study.truth_path));
  load_windows(folder.windows(), study);
  load_truth(folder.truth(), study);
  if (fs::exists(folder.manifest())) load_manifest(folder.manifest());  // before hours of work, not after
}

MissingLayers find_missing(const Study& study, const Scene& scene, const Wanted& wanted, LayerStore& store,
                           const StudyFolder& folder) {
  const bool locked = has_sessions(folder);
  const auto is_missing = [&](const std::string& name, const std::string& recipe) {
    if (locked && store.is_other(name, recipe)) refuse_change(folder, fmt::format("another {}", name));
    return !store.is_whole(name, recipe);
  };
  MissingLayers missing;
  for (const Family& family : wanted.families) {
    const std::string recipe = digest_family_recipe(study, scene, family);
    bool lacks = false;
    for (const char* content : kFamilyContents) lacks |= is_missing(layer_name(family, content), recipe);
    if (lacks) missing.families.push_back(family);
  }
  std::set<std::string> seen;
  for (Condition condition : wanted.conditions) {
    for (int level : needed_levels(condition)) {
      condition.cell = {condition.cell.column, level, false};
      const std::string name = vpl_layer_name(condition);
      if (!seen.insert(name).second) continue;
      if (is_missing(name, digest_vpl_recipe(study, scene, condition)))
        missing.conditions.push_back(condition);
    }
  }
  return missing;
}

// The layers of a family, loaded once for all its pictures.
struct LoadedFamily {
  HdrImage background, coverage, direct, indirect, standard_error, base;
  ToneRecord tone;
  DisplayNoise noise;
  std::string digests;
};

LoadedFamily load_family(const Study& study, const LayerStore& store, const Family& family) {
  const auto load = [&](const char* content) { return store.load(layer_name(family, content)); };
  LoadedFamily loaded{load("background"),
                      load("coverage"),
                      load("direct"),
                      load("indirect"),
                      load("standard_error"),
                      {},
                      {},
                      {},
                      {}};
  loaded.base = composite({&loaded.background, &loaded.direct});
  const HdrImage reference = composite({&loaded.base, &loaded.indirect});
  loaded.tone = make_tone_curve(reference, loaded.coverage, study.exposure, study.tone_key);
  loaded.noise = measure_display_noise(reference, loaded.standard_error, loaded.coverage, loaded.tone);
  for (const char* content : kFamilyContents)
    loaded.digests += store.record(layer_name(family, content)).digest + " ";
  const ToneRecord& tone = loaded.tone;
  loaded.digests +=
      fmt::format("{} {} {} {} {}", tone.log_average, tone.white, tone.delta, tone.key, tone.exposure);
  return loaded;
}

// Pictures on disk and their records; a picture that may have been shown is never replaced by another.
class PictureStore {
 public:
  PictureStore(StudyFolder folder, const Study& study)
      : folder_(std::move(folder)), locked_(has_sessions(folder_)) {
    if (fs::exists(folder_.manifest())) manifest_ = load_manifest(folder_.manifest());
    manifest_.study_name = study.name;
    manifest_.study_digest = study.digest;
    manifest_.seed = study.seed;
    manifest_.width = study.width;
    manifest_.height = study.height;
    drop_others(study);
  }

  bool is_whole(const std::string& key, const std::string& made_from) const {
    const auto found = manifest_.pictures.find(key);
    if (found == manifest_.pictures.end() || found->second.made_from != made_from) return false;
    const fs::path path = folder_.root / found->second.file;
    return fs::is_regular_file(path) && digest_file(path) == found->second.digest;
  }

  void save(const std::string& key, const std::string& made_from, const LdrImage& picture,
            Json standard_error) {
    const std::string bytes = encode_png(picture);
    const std::string digest = digest_text(bytes);
    const auto found = manifest_.pictures.find(key);
    if (locked_ && found != manifest_.pictures.end() && found->second.digest != digest) {
      refuse_change(folder_, "another " + key);
    }
    const std::string file = "pictures/" + key + ".png";
    save_text(folder_.root / file, bytes);
    manifest_.pictures[key] = {file, digest, made_from, std::move(standard_error)};
  }

  void set_tone(const std::string& reference_key, const ToneRecord& tone) {
    manifest_.tones[reference_key] = tone;
  }
  void save_record() const { save_manifest(manifest_, folder_.manifest()); }

 private:
  // Records of an earlier study of this folder that the present one does not have.
  void drop_others(const Study& study) {
    std::set<std::string> known;
    for (const Condition& condition : enumerate_conditions(study)) known.insert(format_key(condition));
    for (const Family& family : enumerate_references(study)) known.insert(format_key(family));
    std::erase_if(manifest_.pictures, [&](const auto& entry) { return !known.contains(entry.first); });
    std::erase_if(manifest_.tones, [&](const auto& entry) { return !known.contains(entry.first); });
  }

  StudyFolder folder_;
  bool locked_;
  Manifest manifest_;
};

HdrImage load_vpl_layer(const LayerStore& store, Condition condition) {
  HdrImage layer = store.load(vpl_layer_name(condition));
  if (!condition.cell.normalised) return layer;
  condition.cell.clamp_level = 0;
  return normalise_luminance(layer, store.load(vpl_layer_name(condition)));
}

std::string vpl_digests(const LayerStore& store, Condition condition) {
  std::string digests = store.record(vpl_layer_name(condition)).digest;
  if (condition.cell.normalised) {
    condition.cell.clamp_level = 0;
    digests += " normalised to " + store.record(vpl_layer_name(condition)).digest;
  }
  return digests;
}

Json make_json(const DisplayNoise& noise) {
  Json json;
  json.set("object_mean", noise.object_mean).set("object_p99", noise.object_p99);
  json.set("outside_mean", noise.outside_mean);
  return json;
}

void tonemap_family(const Study& study, const LayerStore& store, const Family& family,
                    const std::vector<Condition>& conditions, PictureStore& pictures, SetSummary& summary) {
  const LoadedFamily loaded = load_family(study, store, family);
  const std::string key = format_key(family);
  summary.noise[key] = loaded.noise;
  pictures.set_tone(key, loaded.tone);
  const auto write = [&](const std::string& picture_key, const std::string& made_from,
                         const auto& make_indirect, Json standard_error) {
    ++summary.pictures;
    if (pictures.is_whole(picture_key, made_from)) return;
    const HdrImage indirect = make_indirect();
    pictures.save(picture_key, made_from, apply_tone_curve(composite({&loaded.base, &indirect}), loaded.tone),
                  std::move(standard_error));
    ++summary.pictures_written;
  };
  write(
      key, digest_text(loaded.digests), [&] { return loaded.indirect; }, make_json(loaded.noise));
  for (const Condition& condition : conditions) {
    write(
        format_key(condition), digest_text(loaded.digests + " " + vpl_digests(store, condition)),
        [&] { return load_vpl_layer(store, condition); }, Json());
  }
}

void tonemap_wanted(const Study& study, const StudyFolder& folder, const LayerStore& store,
                    const Wanted& wanted, SetSummary& summary) {
  const auto start = std::chrono::steady_clock::now();
  PictureStore pictures(folder, study);
  Progress progress("pictures", static_cast<double>(wanted.families.size()));
  for (const Family& family : wanted.families) {
    std::vector<Condition> conditions;
    for (const Condition& condition : wanted.conditions) {
      if (family_of(condition) == family) conditions.push_back(condition);
    }
    tonemap_family(study, store, family, conditions, pictures, summary);
    progress.advance(1);
  }
  pictures.save_record();
  summary.seconds["pictures"] += seconds_since(start);
}

std::string processor_isa() { return __builtin_cpu_supports("avx512f") ? "avx512" : "avx2"; }

// Times, host and instruction set of every run that rendered something; no digest covers this file.
void append_timing(const StudyFolder& folder, const SetSummary& summary) {
  Json json;
  if (fs::exists(folder.timing())) {
    json = parse_json(load_text(folder.timing()), folder.timing().string());
  } else {
    json.set("schema", "equilux-timing").set("schema_version", 1).set("runs", Json::Array{});
  }
  char host[256] = {};
  gethostname(host, sizeof host - 1);
  Json seconds;
  for (const auto& [stage, time] : summary.seconds) seconds.set(stage, time);
  Json run;
  run.set("producer_version", kVersion).set("finished_utc", format_utc_now()).set("host", std::string(host));
  run.set("built_for", "x86-64-v3").set("processor_has", processor_isa());
  run.set("threads", count_threads());
  run.set("layers_rendered", summary.layers_rendered).set("pictures_written", summary.pictures_written);
  run.set("seconds", std::move(seconds));
  Json runs = json.find("runs") ? *json.find("runs") : Json(Json::Array{});
  runs.push(std::move(run));
  json.set("runs", std::move(runs));
  save_text(folder.timing(), format_json(json));
}

}  // namespace

SetSummary make_set(const SetParams& params) {
  const auto start = std::chrono::steady_clock::now();
  const Study study = load_study(params.study_path);
  const Scene scene = load_scene(study.scene_path);
  const Wanted wanted = enumerate_wanted(study, params.only);
  for (const Family& family : wanted.families)
    digest_scene_part(scene, family.object);  // names what the scene lacks
  const StudyFolder folder{params.folder};
  prepare_folder(folder, study);
  LayerStore store(folder, study);
  const MissingLayers missing = find_missing(study, scene, wanted, store, folder);
  SetSummary summary;
  summary.target = study.noise_target;
  summary.layers_rendered = missing.families.size() * std::size(kFamilyContents) + missing.conditions.size();
  summary.seconds["checking"] = seconds_since(start);
  if (!missing.empty()) summary.seconds.merge(render_layers(study, scene, missing, store));
  store.save_record();
  tonemap_wanted(study, folder, store, wanted, summary);
  if (summary.layers_rendered + summary.pictures_written > 0) append_timing(folder, summary);
  return summary;
}

SetSummary tonemap_set(const fs::path& root, const std::string& only) {
  const StudyFolder folder{root};
  const Study study = load_folder_study(folder);
  const LayerStore store(folder, study);
  SetSummary summary;
  summary.target = study.noise_target;
  tonemap_wanted(study, folder, store, enumerate_wanted(study, only), summary);
  return summary;
}

std::string format_summary(const SetSummary& summary) {
  std::string text = fmt::format("{} pictures, {} written now, {} layers rendered now\n\n", summary.pictures,
                                 summary.pictures_written, summary.layers_rendered);
  text += fmt::format("{:<14}{:>10}\n", "stage", "seconds");
  for (const auto& [stage, seconds] : summary.seconds)
    text += fmt::format("{:<14}{:>10.1f}\n", stage, seconds);
  const NoiseTarget& target = summary.target;
  text += fmt::format("\nStandard error of the references in steps of 255; target {:.1f}, {:.1f}, {:.1f}\n",
                      target.object_mean, target.object_p99, target.outside_mean);
  text += fmt::format("{:<22}{:>12}{:>12}{:>14}\n", "reference", "object mean", "object p99", "outside mean");
  for (const auto& [key, noise] : summary.noise) {
    text += fmt::format("{:<22}{:>12.2f}{:>12.2f}{:>14.2f}  {}\n", key, noise.object_mean, noise.object_p99,
                        noise.outside_mean, meets_target(noise, target) ? "MET" : "MISSED");
  }
  return text;
}

}  // namespace equilux
