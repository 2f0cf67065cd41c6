// Listed, written, cleared up, listed again.
#include "analysis/report_folder.h"

#include <algorithm>
#include <atomic>
#include <future>
#include <set>
#include <utility>
#include <vector>

#include "base/digest.h"
#include "base/error.h"
#include "base/files.h"
#include "base/json.h"
#include "base/version.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

// Name and digest. Of a file that two reports wrote there are two: the folder holds one or the other.
using FileList = std::set<std::pair<std::string, std::string>>;

FileList list_files(const ReportFiles& files) {
  FileList list;
  for (const auto& [name, bytes] : files) list.emplace(name, digest_text(bytes));
  return list;
}

// A list from elsewhere must not lead out of its folder.
bool is_plain_name(const std::string& name) {
  return !name.empty() && name != "." && name != ".." && fs::path(name).filename() == name;
}

const std::string& get_text(const Json& json, const char* key, const std::string& path,
                            const std::string& place) {
  const Json* member = json.find(key);
  if (!member || !member->is_string())
    throw InputError(path, place + "/" + key, "a string", member ? describe_json(*member) : "none");
  return member->as_string();
}

void check_schema(const Json& json, const std::string& path) {
  if (const std::string& schema = get_text(json, "schema", path, ""); schema != "equilux-report-files")
    throw InputError(path, "/schema", "\"equilux-report-files\"", schema);
  const Json* version = json.find("schema_version");
  if (!version || *version != Json(1))
    throw InputError(path, "/schema_version", "1", version ? describe_json(*version) : "none");
}

FileList load_list(const fs::path& folder) {
  const fs::path path = folder / kReportList;
  if (!path_exists(path)) return {};
  const std::string source = path.string();
  const Json json = parse_json(load_text(path), source);
  check_schema(json, source);
  const Json* entries = json.find("files");
  if (!entries || !entries->is_array()) throw InputError(source, "/files", "an array", "none");
  FileList list;
  for (std::size_t i = 0; i < entries->as_array().size(); ++i) {
    const std::string place = fmt::format("/files/{}", i);
    const std::string& name = get_text(entries->at(i), "file", source, place);
    if (!is_plain_name(name)) throw InputError(source, place + "/file", "a file's name", name);
    list.emplace(name, get_text(entries->at(i), "digest", source, place));
  }
  return list;
}

void save_list(const FileList& list, const fs::path& folder) {
  Json json, entries{Json::Array{}};
  for (const auto& [name, digest] : list) entries.push(Json().set("file", name).set("digest", digest));
  json.set("schema", "equilux-report-files").set("schema_version", 1);
  json.set("producer", std::string("equilux-analyze ") + kVersion).set("files", std::move(entries));
  save_text(folder / kReportList, format_json(json));
}

// Each waits for the disk to have it: side by side they wait once for several.
void write_side_by_side(const std::vector<const ReportFiles::value_type*>& files, const fs::path& folder) {
  constexpr std::size_t kWriters = 8;
  std::atomic<std::size_t> next{0};
  std::vector<std::future<void>> running;
  for (std::size_t writer = 0; writer < std::min(kWriters, files.size()); ++writer) {
    running.push_back(std::async(std::launch::async, [&] {
      for (std::size_t i = next++; i < files.size(); i = next++)
        save_text(folder / files[i]->first, files[i]->second);
    }));
  }
  for (auto& future : running) future.wait();
  for (auto& future : running) future.get();
}

// The page last.
void write_files(const ReportFiles& files, const fs::path& folder) {
  std::vector<const ReportFiles::value_type*> rest;
  for (const auto& file : files) {
    if (file.first != kReportPage) rest.push_back(&file);
  }
  write_side_by_side(rest, folder);
  if (const auto page = files.find(kReportPage); page != files.end())
    save_text(folder / kReportPage, page->second);
}

void remove_file(const fs::path& path) {
  std::error_code error;
  fs::remove(path, error);
  if (error) throw StoreError(fmt::format("{}: cannot remove: {}", path.string(), error.message()));
}

// One that was changed since is somebody's work.
void remove_earlier(const FileList& earlier, const ReportFiles& files, const fs::path& folder) {
  for (const auto& [name, digest] : earlier) {
    const fs::path path = folder / name;
    if (files.contains(name) || fs::is_symlink(path) || !is_file(path)) continue;
    if (digest_file(path) == digest) remove_file(path);
  }
}

// Builds before the list left none; what they wrote is known by its report.json.
bool has_unlisted_report(const fs::path& folder) {
  const fs::path path = folder / "report.json";
  if (path_exists(folder / kReportList) || !is_file(path)) return false;
  try {
    const Json json = parse_json(load_text(path), path.string());
    return get_text(json, "schema", path.string(), "") == "equilux-report";
  } catch (const InputError&) {
    return false;
  }
}

void check_replaced(const FileList& earlier, const FileList& now, const fs::path& folder) {
  if (has_unlisted_report(folder)) return;
  for (const auto& [name, digest] : now) {
    const fs::path path = folder / name;
    if (!is_file(path)) continue;
    const std::string found = digest_file(path);
    if (found == digest || earlier.contains({name, found})) continue;
    throw InputError(path.string(), "", "no file of this name, or one that a report wrote",
                     earlier.empty() ? "one of no report; --force replaces it"
                                     : "one of no report or changed since; --force replaces it");
  }
}

std::vector<std::string> find_others(const ReportFiles& files, const fs::path& folder) {
  std::vector<std::string> others;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name != kReportList && !files.contains(name)) others.push_back(name);
  }
  std::sort(others.begin(), others.end());
  return others;
}

}  // namespace

std::vector<std::string> save_report(const ReportFiles& files, const fs::path& folder, bool force) {
  const FileList earlier = load_list(folder), now = list_files(files);
  if (!force) check_replaced(earlier, now, folder);
  make_folder(folder);
  remove_stale_parts(folder);
  FileList both = earlier;
  both.insert(now.begin(), now.end());
  save_list(both, folder);
  write_files(files, folder);
  remove_earlier(earlier, files, folder);
  save_list(now, folder);
  return find_others(files, folder);
}

}  // namespace equilux
