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

// The name that save_text was to give a half-written file, NAME.PROCESS@HOST.part.
std::string strip_writer(const std::string& name) {
  const std::size_t host = name.rfind('@');
  const std::size_t process = host == std::string::npos ? host : name.rfind('.', host);
  return process == std::string::npos || !name.ends_with(".part") ? name : name.substr(0, process);
}

// A file that is certainly not of an export which was killed: what its record lists may be whole or
// half-written; before there is a record, only that is. Empty where there is none.
std::string find_stranger(const fs::path& part) {
  if (!fs::is_directory(part)) return part.filename().string();
  std::set<std::string> files = {kExportRecord};
  try {
    if (path_exists(part / kExportRecord)) files = load_listed_files(part);
  } catch (const InputError&) {
    return kExportRecord;
  }
  for (const auto& entry : fs::recursive_directory_iterator(part)) {
    if (entry.is_directory() && !entry.is_symlink()) continue;
    const fs::path name = entry.path().lexically_relative(part);
    if (!files.contains(strip_writer(name.generic_string()))) return name.string();
  }
  return {};
}

void check_part(const fs::path& folder) {
  const fs::path part = find_export_part(folder);
  if (!path_exists(part)) return;
  const std::string stranger = find_stranger(part);
  if (stranger.empty()) return;
  throw InputError(
      part.string(), "", "a free name, or what an export that was killed has left",
      fmt::format("{}, which no export has written. An export to {} is written there first, and "
                  "answers may lie there: look into it, move or delete it, or export to another name",
                  stranger, folder.string()));
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
    fs::remove_all(path_);  // of an export that was killed, see check_part
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

fs::path find_export_part(const fs::path& folder) { return find_export_folder(folder).string() + ".part"; }

void check_can_export(const fs::path& folder, bool force) {
  if (folder.empty()) throw InputError("--out", "", "a folder to make", "an empty name");
  const fs::path name = find_export_folder(folder);
  check_part(name);
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
  const fs::path name = find_export_folder(folder), part = find_export_part(name);
  const bool replaces = fs::exists(name) && !fs::is_empty(name);
  const PartFolder guard(part);
  write_files(part, files);
  rename_folder(part, name, replaces ? RENAME_EXCHANGE : 0);
}

}  // namespace equilux
