// Records against files.
#include "stimuli/verify_pictures.h"

#include <optional>
#include <set>

#include "base/digest.h"
#include "base/error.h"
#include "base/files.h"
#include "stimuli/origin.h"
#include "stimuli/png_file.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

std::string family_key(const std::string& key) {
  const bool is_reference = key.find("-ref-") != std::string::npos;
  return is_reference ? key : format_key(family_of(parse_condition(key, "manifest")));
}

std::string find_error_beyond(const PictureRecord& record, const NoiseTarget& target) {
  for (const auto& [member, most] : {std::pair{"object_mean", target.object_mean},
                                     {"object_p99", target.object_p99},
                                     {"outside_mean", target.outside_mean}}) {
    const Json* error = record.standard_error.find(member);
    if (!error) return "no standard error";
    if (!(error->as_double() <= most))
      return fmt::format("standard error {} of {:.2f} steps, over the study's {:.2f}", member,
                         error->as_double(), most);
  }
  return "";
}

// The records that pictures are held to; a folder without layers may still be shown.
struct Records {
  const StudyFolder& folder;
  const Study& study;
  const Manifest& manifest;
  std::optional<Layers> layers;
};

// Layers may have been made again since, for another scene or by another estimator.
std::string find_other_origin(const Records& records, const std::string& key, const PictureRecord& picture) {
  if (!records.layers) return "";
  const LayerRecords& layers = records.layers->by_name;
  const ToneRecord& tone = records.manifest.tones.at(family_key(key));
  const bool is_reference = key == family_key(key);
  const std::string meant = is_reference ? digest_reference(layers, tone, parse_family(key, "manifest"))
                                         : digest_picture(layers, tone, parse_condition(key, "manifest"));
  return picture.made_from == meant ? ""
                                    : "not made from the layers of layers.json by its tone curve; "
                                      "`equilux-render tonemap` makes it anew";
}

std::string find_fault(const Records& records, const std::string& key) {
  const auto& [folder, study, manifest, layers] = records;
  const auto found = manifest.pictures.find(key);
  if (found == manifest.pictures.end()) return "no picture; `equilux-render set` makes what is missing";
  if (const std::string meant = "pictures/" + key + ".png"; found->second.file != meant)
    return fmt::format("recorded as {}, where {} is meant", found->second.file, meant);
  const fs::path file = folder.root / found->second.file;
  if (!is_file(file)) return "no file " + file.string();
  if (const std::string digest = digest_file(file, most_file_bytes({study.width, study.height}));
      digest != found->second.digest)
    return fmt::format("{}: expected the digest {}, got {}", file.string(), found->second.digest, digest);
  if (const PixelSize size = load_png_size(file); size != PixelSize{manifest.width, manifest.height})
    return fmt::format("{} x {} pixels, where the manifest has {} x {}", size.width, size.height,
                       manifest.width, manifest.height);
  if (!manifest.tones.contains(family_key(key))) return "no tone curve of " + family_key(key);
  if (std::string other = find_other_origin(records, key, found->second); !other.empty()) return other;
  if (key == family_key(key) && !study.paths) return find_error_beyond(found->second, study.noise_target);
  return "";
}

// Where reading fails, that is what is found: the other pictures are still to be looked at.
std::string find_any_fault(const Records& records, const std::string& key) {
  try {
    return find_fault(records, key);
  } catch (const InputError& error) {
    return error.what();
  }
}

// What a file of records says of its study that is not so.
class HeadFaults {
 public:
  HeadFaults(const fs::path& path, std::vector<Finding>& findings)
      : path_(path.string()), findings_(findings) {}

  void check(bool good, const std::string& wrong) {
    if (!good) findings_.push_back({path_, wrong});
  }
  void check_study(const Study& study, const std::string& name, std::uint64_t seed) {
    check(name == study.name,
          fmt::format("of the study \"{}\", where study.json has \"{}\"", name, study.name));
    check(seed == study.seed, fmt::format("seed {}, where the study has {}", seed, study.seed));
  }

 private:
  std::string path_;
  std::vector<Finding>& findings_;
};

void check_manifest_head(const fs::path& path, const Study& study, const Manifest& manifest,
                         std::vector<Finding>& findings) {
  HeadFaults faults(path, findings);
  faults.check_study(study, manifest.study_name, manifest.seed);
  faults.check(manifest.width == study.width && manifest.height == study.height,
               fmt::format("pictures of {} x {} pixels, where the study has {} x {}", manifest.width,
                           manifest.height, study.width, study.height));
  if (manifest.noise_target)
    faults.check(*manifest.noise_target == study.noise_target, "another noise target than the study's");
}

std::optional<Layers> load_layers_if_there(const StudyFolder& folder, const Study& study,
                                           std::vector<Finding>& findings) {
  if (!path_exists(folder.layers())) return {};
  try {
    Layers layers = load_layers(folder.layers());
    HeadFaults(folder.layers(), findings).check_study(study, layers.study_name, layers.seed);
    return layers;
  } catch (const InputError& error) {
    findings.push_back({"layers", error.what()});
    return {};
  }
}

}  // namespace

std::string format_finding(const Finding& finding) { return finding.what + ": " + finding.wrong; }

std::vector<std::string> enumerate_pictures(const Study& study) {
  std::vector<std::string> keys;
  for (const Family& family : enumerate_references(study)) keys.push_back(format_key(family));
  for (const Condition& condition : enumerate_conditions(study)) keys.push_back(format_key(condition));
  return keys;
}

std::vector<std::string> list_pictures(const Study& study, const Manifest& manifest) {
  std::vector<std::string> keys = enumerate_pictures(study);
  const std::set<std::string> known(keys.begin(), keys.end());
  for (const auto& [key, picture] : manifest.pictures) {
    if (!known.contains(key)) keys.push_back(key);
  }
  return keys;
}

std::vector<Finding> verify_pictures(const StudyFolder& folder, const Study& study, const Manifest& manifest,
                                     const std::vector<std::string>& keys) {
  if (manifest.study_digest != study.digest)
    return {{folder.manifest().string(), "of another study than study.json"}};
  std::vector<Finding> findings;
  check_manifest_head(folder.manifest(), study, manifest, findings);
  const Records records{folder, study, manifest, load_layers_if_there(folder, study, findings)};
  const std::vector<std::string> all = enumerate_pictures(study);
  const std::set<std::string> known(all.begin(), all.end());
  for (const std::string& key : keys) {
    std::string wrong = known.contains(key) ? find_any_fault(records, key)
                                            : "recorded in the manifest, and no picture of the study";
    if (!wrong.empty()) findings.push_back({key, std::move(wrong)});
  }
  return findings;
}

void refuse_findings(const std::vector<Finding>& findings, const StudyFolder& folder) {
  if (findings.empty()) return;
  const std::string more =
      findings.size() > 1 ? fmt::format("; and {} more: see `equilux-render verify`", findings.size() - 1)
                          : "";
  throw InputError(folder.root.string(), "", "pictures that verify", format_finding(findings.front()) + more);
}

}  // namespace equilux
