// An export appears under its name when it is whole, and takes the place of nothing but an earlier export.
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <set>

#include "base/error.h"
#include "base/files.h"
#include "base/json.h"
#include "experiment/export_log.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

fs::path part_of(const fs::path& folder) { return folder.string() + ".part"; }

const std::string* find_text(const Json& json, const char* name) {
  const Json* member = json.find(name);
  return member && member->is_string() ? &member->as_string() : nullptr;
}

std::set<std::string> load_listed_files(const fs::path& folder) {
  const fs::path path = folder / kExportRecord;
  const Json json = parse_json(load_text(path), path.string());
  const std::string* schema = find_text(json, "schema");
  if (!schema || *schema != "equilux-export")
    throw InputError(path.string(), "/schema", "\"equilux-export\"", schema ? *schema : "none");
  std::set<std::string> files = {kExportRecord};
  const Json* list = json.find("files");
  if (!list || !list->is_array()) throw InputError(path.string(), "/files", "an array", "none");
  for (const Json& entry : list->as_array()) {
    if (const std::string* file = find_text(entry, "file")) files.insert(*file);
  }
  return files;
}

void check_is_export(const fs::path& folder) {
  if (!is_file(folder / kExportRecord))
    throw InputError(folder.string(), "", "an earlier export, with its export.json", "another folder");
  const std::set<std::string> files = load_listed_files(folder);
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const fs::path name = entry.path().lexically_relative(folder);
    if (entry.is_directory() && !entry.is_symlink()) continue;
    if (!files.contains(name.generic_string()))
      throw InputError(folder.string(), "", "nothing but files of an earlier export",
                       fmt::format("{}, which is none", name.string()));
  }
}

void write_files(const fs::path& folder, const ExportFiles& files) {
  save_text(folder / kExportRecord, files.at(kExportRecord));
  for (const auto& [name, bytes] : files) {
    make_folder((folder / name).parent_path());
    save_text(folder / name, bytes);
  }
}

void rename_folder(const fs::path& from, const fs::path& to, unsigned flags) {
  if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), flags) != 0)
    throw StoreError(
        fmt::format("{}: cannot rename {} to it: {}", to.string(), from.string(), std::strerror(errno)));
}

// Removed at the end of its scope; after an exchange that is the earlier export.
class PartFolder {
 public:
  explicit PartFolder(const fs::path& path) : path_(path) {
    if (fs::exists(path_) && !fs::is_empty(path_)) load_listed_files(path_);  // of an interrupted export
    fs::remove_all(path_);
    make_folder(path_);
    std::error_code ignored;  // where there are no permissions
    fs::permissions(path_, fs::perms::owner_all, ignored);
  }
  ~PartFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  PartFolder(const PartFolder&) = delete;
  PartFolder& operator=(const PartFolder&) = delete;

 private:
  fs::path path_;
};

}  // namespace

fs::path find_export_folder(const fs::path& folder) {
  const fs::path name = fs::absolute(folder).lexically_normal();
  return name.has_filename() ? name : name.parent_path();
}

void check_can_export(const fs::path& folder, bool force) {
  const fs::path name = find_export_folder(folder);
  if (!fs::exists(name)) return;
  if (!fs::is_directory(name)) throw InputError(name.string(), "", "a folder's name", "a file's");
  if (fs::is_empty(name)) return;
  if (!force)
    throw InputError(name.string(), "", "a free name or an empty folder",
                     "a folder that holds something; --force replaces an earlier export");
  check_is_export(name);
}

void save_export(const fs::path& folder, const ExportFiles& files, bool force) {
  check_can_export(folder, force);
  const fs::path name = find_export_folder(folder), part = part_of(name);
  const bool replaces = fs::exists(name) && !fs::is_empty(name);
  const PartFolder guard(part);
  write_files(part, files);
  rename_folder(part, name, replaces ? RENAME_EXCHANGE : 0);
}

}  // namespace equilux
