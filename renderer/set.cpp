// A set: check, render what is missing, tone-map, tell.
#include "renderer/set.h"

#include <algorithm>
#include <chrono>
#include <thread>

#include "base/error.h"
#include "base/files.h"
#include "base/folder_lock.h"
#include "base/work_control.h"
#include "renderer/layer_store.h"
#include "renderer/picture_store.h"
#include "renderer/render_layers.h"
#include "renderer/room_stages.h"
#include "renderer/set_folder.h"
#include "renderer/set_pictures.h"
#include "renderer/stopwatch.h"
#include "renderer/timing.h"
#include "renderer/verify.h"
#include "stimuli/change_mark.h"
#include "stimuli/verdict.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// The mark goes when what the run replaced is whole, and stays where that was a part of what changes.
void end_change(const StudyFolder& folder, bool has_more, SetSummary& summary) {
  if (!has_more) return remove_change_mark(folder);
  for (const Finding& change : find_change_mark(folder)) summary.warnings.push_back(format_finding(change));
}

// A verdict goes when what it faulted was looked at again, as it was when it was found.
void look_again(const StudyFolder& folder, const std::optional<fs::path>& study_path, SetSummary& summary) {
  if (find_verdict(folder).empty()) return;
  const Stopwatch watch(summary.seconds["verifying"]);
  summary.findings =
      renew_verdict(folder, verify_set(folder.root, study_path).findings, study_path.has_value());
}

std::string join_warnings(const std::vector<std::string>& warnings) {
  std::string text;
  for (const std::string& warning : warnings) text += "; " + warning;
  return text;
}

// One run: what is wanted, and the folder that it stands in or will be gathered into.
class SetMaker {
 public:
  explicit SetMaker(const SetParams& params)
      : params_(params),
        study_(load_study(params.study_path)),
        scene_(load_scene(study_.scene_path)),
        folder_{params.folder},
        wanted_(find_share(enumerate_wanted(study_, params.only))),
        recipes_(make_recipes(study_, scene_, wanted_)) {
    summary_.target = study_.noise_target;
    summary_.fixes_paths = study_.paths.has_value();
    if (params.job && wanted_.families.empty() && wanted_.conditions.empty())
      summary_.warnings.push_back(
          fmt::format("share {} of {} holds nothing: there are more shares than objects in views",
                      params.job->index, params.job->count));
    if (std::string narrow = tell_narrow_target(study_); !narrow.empty())
      summary_.warnings.push_back(std::move(narrow));
  }

  SetSummary make() {
    const auto start = std::chrono::steady_clock::now();
    check_folders();
    make_folder(folder_.root);
    const StudyFolder own = params_.job ? open_share() : folder_;
    const auto lock = lock_folder(own.root, params_.patience);
    LayerStore store(own, study_);
    check_may_make(own, store);
    if (const auto replaced = params_.job ? std::nullopt : find_replaced(store))
      begin_change(folder_, *replaced);
    const bool is_changing = !find_change_mark(folder_).empty();
    fill_set_folder(own, study_);
    if (!params_.job) left_ = gather_jobs(folder_, study_, scene_, store);
    timing_.seconds["checking"] = seconds_since(start);
    complete_layers(own, store);
    // Shares that were kept for what the set lacked.
    if (!params_.job && has_shares(folder_)) left_ = gather_jobs(folder_, study_, scene_, store);
    warn(left_);
    if (!params_.job) {
      tonemap_wanted(study_, own, store, wanted_, summary_);
      end_change(own, is_changing && params_.only != "*", summary_);
      look_again(own, params_.study_path, summary_);
    }
    tell_times(own);
    return std::move(summary_);
  }

 private:
  Wanted find_share(Wanted all) const {
    if (!params_.job) return all;
    const JobShare& job = *params_.job;
    return join_work(plan_jobs(study_, scene_, all, job.count)[static_cast<std::size_t>(job.index - 1)]);
  }

  // Before anything is made.
  void check_folders() const {
    std::error_code none;
    if (fs::equivalent(params_.study_path, folder_.study(), none) &&
        load_text(folder_.study()) != format_json(study_.source))
      throw InputError(folder_.study().string(), "", "a folder whose study.json may be written",
                       "the study file itself; --out names another folder");
    for (const fs::path& other : params_.reuse) load_folder_study({other});
    if (!params_.render) check_same_version();
  }

  // What shares have rendered is of the study that they found.
  void check_same_version() const {
    load_folder_study(folder_);
    check_folder_of(study_, folder_);
  }

  // Before the first write.
  void check_may_make(const StudyFolder& folder, const LayerStore& store) const {
    check_set_folder(folder, study_);
    find_verdict(folder);  // damaged, it is said now
    check_unchanged(folder, list_layers(recipes_, wanted_), store);
  }

  // The set's own folder is prepared too, so that it can be gathered into.
  StudyFolder open_share() const {
    check_own_folders(folder_);
    prepare_once();
    check_folder_of(study_, folder_);
    check_unchanged(folder_, list_layers(recipes_, wanted_), LayerStore(folder_, study_));
    return {folder_.job(format_job_folder(*params_.job))};
  }

  // Shares that start together do it one after another; study.json is the last that is written.
  void prepare_once() const {
    constexpr int kTries = 600;
    for (int turn = 0; turn < kTries && !path_exists(folder_.study()); ++turn) {
      const FolderLock lock(folder_.root);
      if (lock.is_busy()) {
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
      } else if (!path_exists(folder_.study())) {
        check_may_make(folder_, LayerStore(folder_, study_));
        fill_set_folder(folder_, study_);
      }
    }
  }

  // Whether layers or the study of pictures that may be shown become others.
  std::optional<std::string> find_replaced(const LayerStore& store) const {
    if (!path_exists(folder_.manifest())) return {};
    if (load_manifest(folder_.manifest()).study_digest != study_.digest) return "those of another study";
    if (!has_shares(folder_)) return find_other(store, list_layers(recipes_, wanted_));
    const Wanted all = enumerate_wanted(study_, "*");  // is what shares may bring
    return find_other(store, list_layers(make_recipes(study_, scene_, all), all));
  }

  static std::optional<std::string> find_other(const LayerStore& store,
                                               const std::map<std::string, std::string>& layers) {
    for (const auto& [name, recipe] : layers) {
      if (store.is_other(name, recipe)) return "another " + name;
    }
    return {};
  }

  void adopt_from(const fs::path& root, LayerStore& store) {
    const StudyFolder other{root};
    if (!path_exists(other.layers()) && !path_exists(other.pending_layers())) return;
    LayerStore from(other, study_);
    summary_.layers_adopted += adopt_layers(list_layers(recipes_, wanted_), store, from);
    warn(from.warnings());
  }

  void warn(const std::vector<std::string>& warnings) {
    summary_.warnings.insert(summary_.warnings.end(), warnings.begin(), warnings.end());
  }

  void complete_layers(const StudyFolder& own, LayerStore& store) {
    if (params_.job) adopt_from(folder_.root, store);
    for (const fs::path& other : params_.reuse) adopt_from(other, store);
    if (summary_.layers_adopted > 0) store.save_record();  // else a killed run would leave them unknown
    const Wanted missing = find_missing(recipes_, wanted_, store);
    warn(store.warnings());
    if (!missing.empty()) {
      if (!params_.render) refuse_gaps(missing);
      tell_of_shares();
      render_missing(own, missing, store);
    }
    if (params_.only == "*") remove_room_stages(own.rooms());
    store.save_record();
  }

  [[noreturn]] void refuse_gaps(const Wanted& missing) const {
    const std::string first = missing.families.empty() ? format_key(missing.conditions.front())
                                                       : format_key(missing.families.front());
    throw InputError(folder_.root.string(), "", "every share of the set, rendered",
                     fmt::format("{} references and {} layers of VPL pictures missing, {} the first{}",
                                 missing.families.size(), missing.conditions.size(), first,
                                 join_warnings(left_) + join_warnings(summary_.warnings)));
  }

  // What they hold may be hours of work that is done again now.
  void tell_of_shares() const {
    for (const std::string& why : left_) {
      if (params_.remark) params_.remark(why + "; what the set lacks is rendered now");
    }
  }

  WorkCounts count_work(const Wanted& missing) const {
    const std::size_t references = wanted_.families.size(), layers = list_layers(recipes_, wanted_).size() -
                                                                     references * std::size(kFamilyContents);
    return {references, layers, references - missing.families.size(), layers - missing.conditions.size()};
  }

  void render_missing(const StudyFolder& own, const Wanted& missing, LayerStore& store) {
    summary_.layers_rendered =
        missing.families.size() * std::size(kFamilyContents) + missing.conditions.size();
    WorkLog log(own);
    try {
      timing_.work =
          render_layers(recipes_, scene_, missing, count_work(missing), store, log, timing_.seconds);
    } catch (const WorkCancelled&) {
      store.save_record();
      throw;
    }
  }

  void tell_times(const StudyFolder& own) {
    timing_.layers_rendered = summary_.layers_rendered;
    timing_.pictures_written = summary_.pictures_written;
    for (const auto& [stage, seconds] : summary_.seconds) timing_.seconds[stage] += seconds;
    timing_.processor_seconds = measure_processor_seconds() - processor_start_;
    summary_.processor_seconds = timing_.processor_seconds;
    summary_.peak_memory = measure_peak_memory();
    summary_.seconds = timing_.seconds;
    if (summary_.layers_rendered + summary_.pictures_written > 0) append_timing(own, timing_);
  }

  const SetParams& params_;
  Study study_;
  Scene scene_;
  StudyFolder folder_;
  Wanted wanted_;
  Recipes recipes_;
  SetSummary summary_;
  std::vector<std::string> left_;  // what the gathering of shares said last
  RunTiming timing_;
  double processor_start_ = measure_processor_seconds();
};

}  // namespace

SetSummary make_set(const SetParams& params) { return SetMaker(params).make(); }

SetSummary tonemap_set(const fs::path& root, const std::string& only) {
  const StudyFolder folder{root};
  const Study study = load_folder_study(folder);
  check_own_folders(folder);
  find_verdict(folder);  // damaged, it is said before the first write
  const auto lock = lock_folder(root);
  make_folder(folder.picture_folder());
  LayerStore store(folder, study);
  if (path_exists(folder.pending_layers())) store.save_record();
  const bool is_changing = !find_change_mark(folder).empty();
  SetSummary summary;
  summary.target = study.noise_target;
  summary.fixes_paths = study.paths.has_value();
  tonemap_wanted(study, folder, store, enumerate_wanted(study, only), summary);
  end_change(folder, is_changing, summary);
  look_again(folder, {}, summary);
  return summary;
}

bool is_within_limits(const SetSummary& summary) {
  return summary.missed.empty() && summary.findings.empty();
}

namespace {

std::string tell_noise(const SetSummary& summary) {
  if (summary.noise.empty()) return "";  // a share, which makes no pictures
  const NoiseTarget& target = summary.target;
  std::string text =
      fmt::format("\nStandard error of the references in steps of 255; target {:.1f}, {:.1f}, {:.1f}\n",
                  target.object_mean, target.object_p99, target.outside_mean);
  text += fmt::format("{:<22}{:>12}{:>12}{:>14}\n", "reference", "object mean", "object p99", "outside mean");
  for (const auto& [key, noise] : summary.noise) {
    const char* missed = summary.fixes_paths ? "over, not held to it: the study fixes its paths" : "MISSED";
    text += fmt::format("{:<22}{:>12.2f}{:>12.2f}{:>14.2f}  {}\n", key, noise.object_mean, noise.object_p99,
                        noise.outside_mean, meets_target(noise, target) ? "MET" : missed);
  }
  return text;
}

std::string tell_cut_errors(const SetSummary& summary) {
  if (summary.cut_errors.empty()) return "";
  std::string text = fmt::format(
      "\nError of lightcuts at the points drawn, per cent of the "
      "luminance\n{:<22}{:>12}{:>12}{:>12}{:>14}\n",
      "VPLs", "points", "rms", "p99", "max");
  for (const auto& [count, error] : summary.cut_errors) {
    text += fmt::format("{:<22}{:>12}{:>12.2f}{:>12.2f}{:>14.2f}\n", format_vpl_count(count), error.points,
                        100 * error.rms, 100 * error.p99, 100 * error.max);
  }
  return text;
}

}  // namespace

std::string format_summary(const SetSummary& summary) {
  std::string text = fmt::format("{} pictures, {} written now, {} layers rendered now", summary.pictures,
                                 summary.pictures_written, summary.layers_rendered);
  if (summary.layers_adopted > 0) text += fmt::format(", {} taken over", summary.layers_adopted);
  text += "\n\n";
  text += fmt::format("{:<14}{:>10}\n", "stage", "seconds");
  for (const auto& [stage, seconds] : summary.seconds)
    text += fmt::format("{:<14}{:>10.1f}\n", stage, seconds);
  if (summary.peak_memory > 0) {
    text += fmt::format("{:<14}{:>10.1f}\n{:<14}{:>10.2f} GiB\n", "processors", summary.processor_seconds,
                        "peak memory", summary.peak_memory / (1 << 30));
  }
  text += tell_noise(summary) + tell_cut_errors(summary);
  for (const std::string& warning : summary.warnings) text += "warning: " + warning + "\n";
  for (const std::string& missed : summary.missed) text += "beyond its limit: " + missed + "\n";
  if (!summary.missed.empty())
    text +=
        "Such a set does not verify, and the same study makes the same again. Give the study another seed or "
        "a\n"
        "wider noise_target and run `set` again: it makes anew what these change, and no file is to be "
        "removed.\n";
  if (!summary.findings.empty())
    text += fmt::format("{} findings of `equilux-render verify` stand, the first {}\n",
                        summary.findings.size(), format_finding(summary.findings.front()));
  return text;
}

}  // namespace equilux
