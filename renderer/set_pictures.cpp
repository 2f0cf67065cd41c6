// From a set's layers to its pictures and manifest, and what is worth a warning on the way.
#include "renderer/set_pictures.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <fmt/format.h>
#include <functional>
#include <map>
#include <set>

#include "base/error.h"
#include "base/memory.h"
#include "base/progress.h"
#include "base/work_control.h"
#include "renderer/compose.h"
#include "renderer/parallel.h"
#include "renderer/picture_store.h"
#include "renderer/record_check.h"
#include "renderer/stopwatch.h"
#include "renderer/vpl.h"
#include "stimuli/origin.h"

namespace equilux {
namespace {

constexpr std::chrono::seconds kRecordEvery{5};  // a run that is killed loses this and a family

Json make_json(const DisplayNoise& noise) {
  Json json;
  json.set("object_mean", noise.object_mean).set("object_p99", noise.object_p99);
  json.set("outside_mean", noise.outside_mean);
  return json;
}

// The errors measured of all pictures by cuts, pooled over levels and materials.
void pool_errors(const LayerStore& store, const std::vector<Condition>& conditions, SetSummary& summary) {
  std::map<std::int64_t, std::map<std::string, const Json*>> pools;  // by count, then by layer
  for (const Condition& condition : conditions) {
    const std::string name = vpl_layer_name(condition);
    const Json& errors = store.record(name).errors_1e5;
    if (const std::string text = find_uncertified(store.record(name)); !text.empty())
      summary.missed.push_back(fmt::format("{}: {}", name, text));
    if (!errors.is_null()) pools[condition.cell.column.vpl_count][name] = &errors;
  }
  for (const auto& [count, by_layer] : pools) {
    std::vector<const Json*> all;
    for (const auto& [name, errors] : by_layer) all.push_back(errors);
    summary.cut_errors[count] = summarise_pools(all);
  }
}

// Layers of other instruction sets differ in their last bits.
void warn_of_mixture(const LayerStore& store, const Wanted& wanted, SetSummary& summary) {
  std::map<std::string, std::size_t> counts;
  for (const Family& family : wanted.families) {
    for (const char* content : kFamilyContents) ++counts[store.record(layer_name(family, content)).isa];
  }
  for (const Condition& condition : wanted.conditions) ++counts[store.record(vpl_layer_name(condition)).isa];
  counts.erase("");
  if (counts.size() < 2) return;
  std::string text;
  for (const auto& [isa, count] : counts)
    text += fmt::format("{}{} by {}", text.empty() ? "" : ", ", count, isa);
  summary.warnings.push_back("layers of more than one instruction set, which differ in their last bits: " +
                             text + "; --isa fixes it");
}

void warn_of_counts(const LayerStore& store, const std::vector<Condition>& conditions, SetSummary& summary) {
  std::set<std::string> told;
  for (const Condition& condition : conditions) {
    const Column& column = condition.cell.column;
    const std::string odd =
        tell_odd_count(column.vpl_count, store.record(vpl_layer_name(condition)).vpl_count);
    if (!odd.empty() && told.insert(format_key(column)).second)
      summary.warnings.push_back(format_key(column) + ": " + odd);
  }
}

bool is_black(const HdrImage& image) {
  return std::all_of(image.values.begin(), image.values.end(), [](float value) { return value == 0; });
}

// Pictures without an object or without light are legal, and hardly ever meant.
void warn_of_emptiness(const LoadedFamily& loaded, const std::string& key, SetSummary& summary) {
  if (is_black(loaded.coverage)) {
    summary.warnings.push_back(key + ": the object is not in the picture");
  } else if (is_black(loaded.indirect) && is_black(loaded.direct)) {
    summary.warnings.push_back(key + ": no path met light on the object");
  }
  const auto& covered = loaded.coverage.values;
  const bool has_background =
      std::any_of(covered.begin(), covered.end(), [](float share) { return share < 1; });
  if (has_background && is_black(loaded.background))
    summary.warnings.push_back(key + ": the background is black");
}

// A picture of a family: what its record says but for its file, and its object's indirect light by the layer
// of this name.
struct WantedPicture {
  std::string key, layer;
  PictureRecord record;
  std::function<HdrImage()> make_indirect;
};

std::vector<WantedPicture> list_pictures(const LoadedFamily& loaded, const LayerStore& store,
                                         const Family& family, const std::vector<Condition>& conditions) {
  const Json reference = tell_picture_reference(store.records(), family);
  const ToneRecord& tone = loaded.tone.record;
  std::vector<WantedPicture> pictures{
      {format_key(family),
       layer_name(family, "indirect"),
       {"", "", digest_reference(store.records(), tone, family), make_json(loaded.noise), reference},
       [&] { return loaded.indirect; }}};
  for (const Condition& condition : conditions) {
    const std::string layer = vpl_layer_name(condition);
    const Json vpls = tell_picture_vpls(store.records(), condition);
    pictures.push_back({format_key(condition),
                        layer,
                        {"", "", digest_picture(store.records(), tone, condition), {}, {}, vpls},
                        [&] { return load_vpl_layer(store, condition); }});
  }
  return pictures;
}

// Those that are not whole, on all threads; gives their number.
std::size_t write_pictures(const LoadedFamily& loaded, const std::vector<WantedPicture>& wanted,
                           PictureStore& pictures, Progress& progress) {
  std::atomic<std::size_t> written = 0;
  for_each_parallel(wanted.size(), [&](std::size_t i) {
    const WantedPicture& picture = wanted[i];
    const auto compose = [&] { return compose_picture(loaded, picture.make_indirect(), picture.layer); };
    const bool is_whole = pictures.keep(picture.key, picture.record) &&
                          (!pictures.is_doubted() || pictures.shows(picture.key, compose()));
    if (!is_whole) {
      pictures.save(picture.key, picture.record, compose());
      ++written;
    }
    progress.advance(1);
  });
  return written;
}

void tonemap_family(const Study& study, const LayerStore& store, const Family& family,
                    const std::vector<Condition>& conditions, PictureStore& pictures, Progress& progress,
                    SetSummary& summary) {
  const LoadedFamily loaded = load_family(study, store, family);
  const std::string key = format_key(family);
  summary.noise[key] = loaded.noise;
  warn_of_emptiness(loaded, key, summary);
  if (!study.paths && !meets_target(loaded.noise, study.noise_target))
    summary.missed.push_back(key + ": its standard error is over the study's noise target");
  for (const char* content : {"indirect", "background"}) {
    for (const std::string& text : find_failed_checks(store.record(layer_name(family, content))))
      summary.missed.push_back(fmt::format("{}.{}: {}", key, content, text));
  }
  pictures.set_tone(key, loaded.tone.record);
  const auto wanted = list_pictures(loaded, store, family, conditions);
  summary.pictures += wanted.size();
  const ThreadLimit limit(fit_threads(estimate_picture_memory(study), find_available_memory()));
  summary.pictures_written += write_pictures(loaded, wanted, pictures, progress);
}

void tonemap_families(const Study& study, const LayerStore& store, const Wanted& wanted,
                      PictureStore& pictures, SetSummary& summary) {
  Progress progress("pictures", static_cast<double>(wanted.families.size() + wanted.conditions.size()));
  std::map<Family, std::vector<Condition>> conditions;
  for (const Condition& condition : wanted.conditions) conditions[family_of(condition)].push_back(condition);
  auto recorded = std::chrono::steady_clock::now();
  for (const Family& family : wanted.families) {
    tonemap_family(study, store, family, conditions[family], pictures, progress, summary);
    if (std::chrono::steady_clock::now() - recorded < kRecordEvery) continue;
    pictures.save_record();
    recorded = std::chrono::steady_clock::now();
  }
}

}  // namespace

void tonemap_wanted(const Study& study, const StudyFolder& folder, const LayerStore& store,
                    const Wanted& wanted, SetSummary& summary) {
  const Stopwatch watch(summary.seconds["pictures"]);
  PictureStore pictures(folder, study);
  try {
    with_family_memory(folder, study, [&] { tonemap_families(study, store, wanted, pictures, summary); });
  } catch (const WorkCancelled&) {
    pictures.save_record();
    throw;
  }
  pictures.save_record();
  pool_errors(store, wanted.conditions, summary);
  warn_of_counts(store, wanted.conditions, summary);
  warn_of_mixture(store, wanted, summary);
}

}  // namespace equilux
