// Family by family, in parallel.
#include "renderer/verify.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <tuple>

#include "base/digest.h"
#include "base/error.h"
#include "base/files.h"
#include "base/memory.h"
#include "base/progress.h"
#include "renderer/compose.h"
#include "renderer/jobs.h"
#include "renderer/parallel.h"
#include "renderer/record_check.h"
#include "stimuli/change_mark.h"
#include "stimuli/origin.h"
#include "stimuli/png_file.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

// Of sums that another compiler may round otherwise.
constexpr double kRounding = 1e-6;

bool is_near(double a, double b) { return std::abs(a - b) <= kRounding * std::max(std::abs(a), std::abs(b)); }

bool is_same(const ToneRecord& a, const ToneRecord& b) {
  return is_near(a.log_average, b.log_average) && is_near(a.white, b.white) && is_near(a.delta, b.delta) &&
         is_near(a.key, b.key) && a.exposure == b.exposure && a.tone_operator == b.tone_operator;
}

bool is_black(const float* pixel) { return pixel[0] == 0 && pixel[1] == 0 && pixel[2] == 0; }

// Light of a layer where it may not be: `allowed` by the pixel's coverage.
template <typename Allowed>
std::string find_misplaced(const HdrImage& layer, const HdrImage& coverage, const Allowed& allowed) {
  for (std::size_t i = 0; i < layer.pixel_count(); ++i) {
    const float* p = layer.pixel(i);
    if (!is_black(p) && !allowed(coverage.values[i]))
      return fmt::format("light outside its place, at pixel {}", i);
  }
  return "";
}

bool is_on_object(float covered) { return covered > 0; }

double sum_light(const HdrImage& layer) {
  double sum = 0;
  for (std::size_t i = 0; i < layer.pixel_count(); ++i) {
    const float* p = layer.pixel(i);
    sum += luminance({p[0], p[1], p[2]});
  }
  return sum;
}

// What all families are held to.
struct VerifiedSet {
  const StudyFolder& folder;
  const Study& study;
  const Manifest& manifest;
  const LayerStore& store;
};

class FamilyVerifier {
 public:
  FamilyVerifier(const VerifiedSet& set, const Family& family) : set_(set), family_(family) {}

  std::vector<Finding> verify(const std::vector<Condition>& conditions) {
    const std::string key = format_key(family_);
    guard(key, [&] {
      loaded_ = load_family(set_.study, set_.store, family_);
      verify_layers(key);
      verify_reference(key);
    });
    if (!loaded_) return findings_;
    for (const Condition& condition : conditions)
      guard(format_key(condition), [&] { verify_condition(condition); });
    verify_levels();
    return findings_;
  }

  // What is legal, and hardly ever meant.
  std::string tell_dark() const {
    if (!loaded_ || sum_light(loaded_->direct) + sum_light(loaded_->indirect) > 0) return "";
    return format_key(family_) + ": no light on the object";
  }

  // Empty where it cannot be read.
  std::string digest_coverage() const {
    if (!loaded_) return "";
    const std::vector<float>& values = loaded_->coverage.values;
    return digest_text({reinterpret_cast<const char*>(values.data()), sizeof(float) * values.size()});
  }

 private:
  // Where reading fails, that is what is found.
  template <typename Body>
  void guard(const std::string& what, const Body& body) {
    try {
      body();
    } catch (const InputError& error) {
      add(what, error.what());
    }
  }

  void add(const std::string& what, std::string wrong) {
    if (!wrong.empty()) findings_.push_back({what, std::move(wrong)});
  }

  void verify_layers(const std::string& key) {
    const LoadedFamily& family = *loaded_;
    for (const float covered : family.coverage.values) {
      if (covered >= 0 && covered <= 1) continue;
      add(key + ".coverage", fmt::format("{}, where 0 to 1 is meant", covered));
      break;
    }
    add(key + ".background",
        find_misplaced(family.background, family.coverage, [](float covered) { return covered < 1; }));
    add(key + ".direct", find_misplaced(family.direct, family.coverage, is_on_object));
    add(key + ".indirect", find_misplaced(family.indirect, family.coverage, is_on_object));
    add(key + ".standard_error",
        find_misplaced(family.standard_error, family.coverage, [](float) { return true; }));
    if (sum_light(family.standard_error) == 0 && sum_light(family.indirect) > 0)
      add(key + ".standard_error", "black, where light was sampled");
    add(key + ".indirect", find_unchecked(set_.store.record(layer_name(family_, "indirect")), set_.study));
    for (const char* content : {"indirect", "background"}) {
      for (std::string& text : find_failed_checks(set_.store.record(layer_name(family_, content))))
        add(fmt::format("{}.{}", key, content), std::move(text));
    }
  }

  void verify_reference(const std::string& key) {
    const auto tone = set_.manifest.tones.find(key);
    if (tone != set_.manifest.tones.end() && !is_same(tone->second, loaded_->tone.record))
      add(key, "its tone curve in the manifest is not that of its layers");
    const auto record = set_.manifest.pictures.find(key);
    if (record == set_.manifest.pictures.end()) return;
    const Json& error = record->second.standard_error;
    const DisplayNoise& noise = loaded_->noise;
    for (const auto& [member, value] : {std::pair{"object_mean", noise.object_mean},
                                        {"object_p99", noise.object_p99},
                                        {"outside_mean", noise.outside_mean}}) {
      const Json* recorded = error.find(member);
      if (recorded && !is_near(recorded->as_double(), value))
        add(key, fmt::format("its {} in the manifest is {}, of its layers {}", member, recorded->as_double(),
                             value));
    }
    if (error.is_null()) add(key, "its standard error is not in the manifest");
    verify_record(key, record->second.reference, tell_picture_reference(set_.store.records(), family_));
    shown_ = load_shown(record->second);
    if (!shown_) return;
    if (shown_->values != compose_picture(*loaded_, loaded_->indirect, key + ".indirect").values)
      add(key, "the picture is not that of its layers");
  }

  void verify_record(const std::string& key, const Json& recorded, const Json& meant) {
    if (recorded != meant)
      add(key,
          "what the manifest tells of its making is not what layers.json tells; `equilux-render tonemap` "
          "writes it anew");
  }

  void verify_condition(const Condition& condition) {
    const std::string key = format_key(condition);
    const HdrImage layer = load_vpl_layer(set_.store, condition);
    const std::string name = vpl_layer_name(condition);
    add(name, find_misplaced(layer, loaded_->coverage, is_on_object));
    const bool is_cut = !is_summed_plainly(condition.cell.column.vpl_count);
    add(name, find_uncertified(set_.store.record(name), is_cut && set_.study.certified));
    if (!condition.cell.normalised)
      light_[condition.cell.column][condition.cell.clamp_level] = sum_light(layer);
    const auto record = set_.manifest.pictures.find(key);
    if (record == set_.manifest.pictures.end()) return;
    verify_record(key, record->second.vpls, tell_picture_vpls(set_.store.records(), condition));
    const auto picture = load_shown(record->second);
    if (!picture) return;
    if (picture->values != compose_picture(*loaded_, layer, name).values)
      add(key, "the picture is not that of its layers");
    if (shown_ && differs_outside(*picture)) add(key, "its background is not that of its reference");
  }

  // Empty where it is of another size, which is found before: that takes no memory.
  std::optional<LdrImage> load_shown(const PictureRecord& record) const {
    const fs::path path = set_.folder.root / record.file;
    if (load_png_size(path) != PixelSize{set_.study.width, set_.study.height}) return {};
    return load_png(path);
  }

  bool differs_outside(const LdrImage& picture) const {
    if (picture.values.size() != shown_->values.size()) return true;
    for (std::size_t i = 0; i < loaded_->coverage.values.size(); ++i) {
      if (loaded_->coverage.values[i] > 0) continue;
      if (!std::equal(&picture.values[3 * i], &picture.values[3 * i] + 3, &shown_->values[3 * i]))
        return true;
    }
    return false;
  }

  void verify_levels() {
    for (const auto& [column, levels] : light_) {
      double before = std::numeric_limits<double>::infinity();
      for (const auto& [level, light] : levels) {
        if (light > before * (1 + kRounding))
          add(format_key(Condition{{column, level, false}, family_.view}),
              "brighter than under a weaker clamp");
        before = light;
      }
    }
  }

  const VerifiedSet& set_;
  const Family& family_;
  std::optional<LoadedFamily> loaded_;
  std::optional<LdrImage> shown_;
  std::map<Column, std::map<int, double>> light_;  // by clamp level, the weakest first
  std::vector<Finding> findings_;
};

// What a material is made of changes nothing of where its object is. shape: digests, by family
std::vector<Finding> compare_coverage(const std::vector<Family>& families,
                                      const std::vector<std::string>& digests) {
  std::vector<Finding> findings;
  std::map<std::tuple<std::string, Illumination, int>, std::size_t> firsts;
  for (std::size_t i = 0; i < families.size(); ++i) {
    if (digests[i].empty()) continue;
    const Object& object = families[i].object;
    const std::size_t first =
        firsts.try_emplace({object.geometry, object.illumination, families[i].view}, i).first->second;
    if (digests[i] != digests[first])
      findings.push_back({format_key(families[i]) + ".coverage",
                          fmt::format("not that of {}, of the same object in another material",
                                      format_key(families[first]))});
  }
  return findings;
}

std::vector<Finding> verify_families(const VerifiedSet& set, std::vector<std::string>& notes) {
  const std::vector<Family> families = enumerate_references(set.study);
  std::map<Family, std::vector<Condition>> conditions;
  for (const Condition& condition : enumerate_conditions(set.study))
    conditions[family_of(condition)].push_back(condition);
  std::vector<std::vector<Finding>> by_family(families.size());
  std::vector<std::string> coverage(families.size()), dark(families.size());
  Progress progress("verifying", static_cast<double>(families.size()));
  const ThreadLimit limit(fit_threads(estimate_family_memory(set.study), find_available_memory()));
  for_each_parallel(families.size(), [&](std::size_t i) {
    const auto found = conditions.find(families[i]);
    FamilyVerifier verifier(set, families[i]);
    by_family[i] = verifier.verify(found == conditions.end() ? std::vector<Condition>() : found->second);
    coverage[i] = verifier.digest_coverage();
    dark[i] = verifier.tell_dark();
    progress.advance(1);
  });
  std::copy_if(dark.begin(), dark.end(), std::back_inserter(notes),
               [](const std::string& note) { return !note.empty(); });
  std::vector<Finding> findings = compare_coverage(families, coverage);
  for (const auto& some : by_family) findings.insert(findings.end(), some.begin(), some.end());
  return findings;
}

// Layers that today's study and scene would make otherwise.
std::vector<Finding> verify_recipes(const fs::path& study_path, const Study& study, const LayerStore& store) {
  const Study today = load_study(study_path);
  if (today.digest != study.digest)
    throw InputError(study_path.string(), "", "the study of the folder", "another");
  const Wanted all = enumerate_wanted(today, "*");
  std::vector<Finding> findings;
  for (const auto& [name, recipe] :
       list_layers(make_recipes(today, load_scene(today.scene_path), all), all)) {
    if (store.is_other(name, recipe))
      findings.push_back({name, "made from another study, scene or estimator", true});
  }
  return findings;
}

std::string tell_unsure_checks(const LayerRecords& layers) {
  CheckedRegions sum;
  for (const auto& [name, layer] : layers) {
    const CheckedRegions count = count_checked_regions(layer);
    sum.all += count.all;
    sum.unsure += count.unsure;
  }
  if (sum.unsure == 0) return "";
  return fmt::format(
      "in {1} of {0} regions of references the paths which check them met the light too rarely: a difference "
      "there could not have been found",
      sum.all, sum.unsure);
}

std::vector<Finding> verify_manifest(const StudyFolder& folder, const Study& study) {
  if (!path_exists(folder.manifest()))
    return {{folder.manifest().string(), "not there: no pictures were made"}};
  const Manifest manifest = load_manifest(folder.manifest());
  return verify_pictures(folder, study, manifest, list_pictures(study, manifest));
}

}  // namespace

Verification verify_set(const fs::path& root, const std::optional<fs::path>& study_path) {
  const StudyFolder folder{root};
  const Study study = load_folder_study(folder);
  const LayerStore store(folder, study);
  Verification verification;
  verification.pictures = enumerate_pictures(study).size();
  verification.layers =
      enumerate_references(study).size() * std::size(kFamilyContents) + enumerate_conditions(study).size();
  auto& findings = verification.findings;
  findings = verify_manifest(folder, study);
  for (Finding& change : find_change_mark(folder)) findings.push_back(std::move(change));
  if (study.paths)
    verification.notes.push_back(
        "the study fixes its paths: the errors of its references are not held to its noise target");
  if (std::string unsure = tell_unsure_checks(store.records()); !unsure.empty())
    verification.notes.push_back(std::move(unsure));
  if (has_shares(folder))
    findings.push_back({folder.jobs().string(),
                        "shares that are not gathered; `equilux-render gather` does it, or says why not"});
  if (study_path) {
    const auto more = verify_recipes(*study_path, study, store);
    findings.insert(findings.end(), more.begin(), more.end());
  }
  const Manifest manifest = path_exists(folder.manifest()) ? load_manifest(folder.manifest()) : Manifest();
  with_family_memory(folder, study, [&] {
    const auto more = verify_families({folder, study, manifest, store}, verification.notes);
    findings.insert(findings.end(), more.begin(), more.end());
  });
  return verification;
}

}  // namespace equilux
