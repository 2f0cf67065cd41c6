// From the #include lines of a tree to what is wrong with them.
#include "tests/architecture/include_check.h"

#include <algorithm>
#include <fstream>
#include <functional>
#include <map>
#include <set>

namespace equilux {
namespace {
namespace fs = std::filesystem;

using Names = std::set<std::string>;
using Includes = std::map<std::string, std::vector<std::string>>;  // file -> what it includes, as written

// Folder -> the folders whose headers it may include. One more word is a single header.
const std::map<std::string, Names> kAllowed = {
    {"base", {}},
    {"protocols", {"base"}},
    {"stimuli", {"base", "protocols"}},
    {"renderer", {"base", "protocols", "stimuli"}},
    {"experiment", {"base", "protocols", "stimuli"}},
    {"experiment/app", {"base", "protocols", "stimuli", "experiment"}},
    {"analysis", {"base", "protocols", "stimuli", "experiment/trial_log.h"}},
};

// The app may use this many public headers of each of these folders, whichever they are.
const std::map<std::string, std::size_t> kHeadersForApp = {{"renderer", 1}, {"analysis", 1}};

struct Foreign {
  const char* library;
  std::vector<const char*> beginnings;  ///< of the header's name
  const char* home;                     ///< file, or folder with a slash; empty: any one file
};
const std::vector<Foreign> kForeign = {
    {"Embree", {"embree"}, ""},
    {"TBB", {"tbb/", "oneapi/"}, ""},
    {"SQLite", {"sqlite3"}, ""},
    {"nlohmann-json", {"nlohmann/"}, "base/json.cpp"},
    {"valijson", {"valijson/"}, "base/json.cpp"},
    {"OpenSSL", {"openssl/"}, "base/digest.cpp"},
    {"OpenEXR", {"Imf", "Imath", "Iex", "OpenEXR/", "Imath/", "half.h"}, "stimuli/exr_file.cpp"},
    {"libpng", {"png.h", "libpng"}, "stimuli/png_file.cpp"},
    {"assimp", {"assimp/"}, "stimuli/mesh_file.cpp"},
    {"OpenImageIO", {"OpenImageIO/"}, ""},
    {"GLFW, ImGui and GL", {"GLFW/", "imgui", "GL/", "GLES", "EGL/", "KHR/", "X11/"}, "experiment/app/"},
};

std::vector<std::string> read_includes(const fs::path& path) {
  std::vector<std::string> included;
  std::ifstream stream(path);
  for (std::string line; std::getline(stream, line);) {
    const std::size_t hash = line.find_first_not_of(" \t");
    if (hash == std::string::npos || line[hash] != '#') continue;
    const std::size_t word = line.find_first_not_of(" \t", hash + 1);
    if (word == std::string::npos || line.compare(word, 7, "include") != 0) continue;
    const std::size_t open = line.find_first_of("\"<", word);
    const std::size_t close = open == std::string::npos ? open : line.find_first_of("\">", open + 1);
    included.push_back(close == std::string::npos ? line : line.substr(open + 1, close - open - 1));
  }
  return included;
}

Includes read_tree(const fs::path& root) {
  static const Names kinds = {".h", ".hpp", ".cpp", ".cc", ".c", ".inl", ".ipp", ".in"};
  Includes includes;
  for (const auto& [folder, unused] : kAllowed) {
    if (folder.find('/') != std::string::npos || !fs::is_directory(root / folder)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
      if (!entry.is_regular_file() || !kinds.contains(entry.path().extension().string())) continue;
      includes[fs::relative(entry.path(), root).generic_string()] = read_includes(entry.path());
    }
  }
  return includes;
}

// The longest folder of the table that holds the file; empty for a system's or a library's header.
std::string folder_of(const std::string& file) {
  std::string found;
  for (const auto& [folder, unused] : kAllowed) {
    if (file.starts_with(folder + "/") && folder.size() > found.size()) found = folder;
  }
  return found;
}

bool is_main(const std::string& file) { return file.ends_with("/main.cpp"); }

bool is_allowed(const std::string& file, const std::string& header) {
  const std::string from = folder_of(file), to = folder_of(header);
  const Names& allowed = kAllowed.at(from);
  if (to == from || allowed.contains(to) || allowed.contains(header)) return true;
  if (is_main(file) && from == "experiment" && header == "experiment/app/app.h") return true;
  return from == "experiment/app" && kHeadersForApp.contains(to);
}

void check_edges(const Includes& includes, std::vector<std::string>& faults) {
  for (const auto& [file, headers] : includes) {
    for (const std::string& header : headers) {
      if (folder_of(header).empty()) continue;
      if (!is_allowed(file, header)) faults.push_back(file + " may not include " + header);
      // version.h is made by CMake, not kept in the tree.
      if (header != "base/version.h" && !includes.contains(header))
        faults.push_back(file + " includes " + header + ", which is not there");
    }
  }
}

void check_headers_for_app(const Includes& includes, std::vector<std::string>& faults) {
  std::map<std::string, Names> used;
  for (const auto& [file, headers] : includes) {
    for (const std::string& header : headers) {
      if (folder_of(file) == "experiment/app" && kHeadersForApp.contains(folder_of(header)))
        used[folder_of(header)].insert(header);
    }
  }
  for (const auto& [folder, headers] : used) {
    if (headers.size() <= kHeadersForApp.at(folder)) continue;
    std::string list;
    for (const std::string& header : headers) list += " " + header;
    faults.push_back("experiment/app includes more than one header of " + folder + ":" + list);
  }
}

// Headers named by a path that does not begin at the root would escape the table.
void check_paths(const Includes& includes, std::vector<std::string>& faults) {
  for (const auto& [file, headers] : includes) {
    for (const std::string& header : headers) {
      const bool beside =
          includes.contains((fs::path(file).parent_path() / header).lexically_normal().generic_string());
      if (folder_of(header).empty() && beside)
        faults.push_back(file + " includes " + header + " not by its path from the root");
    }
  }
}

void check_cycles(const Includes& includes, std::vector<std::string>& faults) {
  enum class Mark { kNew, kOpen, kDone };
  std::map<std::string, Mark> marks;
  std::vector<std::string> way;
  const std::function<void(const std::string&)> visit = [&](const std::string& file) {
    marks[file] = Mark::kOpen;
    way.push_back(file);
    for (const std::string& header : includes.at(file)) {
      if (!includes.contains(header) || marks[header] == Mark::kDone) continue;
      if (marks[header] == Mark::kNew) {
        visit(header);
        continue;
      }
      std::string cycle = "cycle: ";
      for (auto step = std::find(way.begin(), way.end(), header); step != way.end(); ++step)
        cycle += *step + " -> ";
      faults.push_back(cycle + header);
    }
    way.pop_back();
    marks[file] = Mark::kDone;
  };
  for (const auto& [file, unused] : includes) {
    if (marks[file] == Mark::kNew) visit(file);
  }
}

bool belongs_to(const Foreign& foreign, const std::string& header) {
  return folder_of(header).empty() &&
         std::any_of(foreign.beginnings.begin(), foreign.beginnings.end(),
                     [&](const char* start) { return header.starts_with(start); });
}

void check_foreign(const Includes& includes, std::vector<std::string>& faults) {
  for (const Foreign& foreign : kForeign) {
    const std::string home = foreign.home;
    Names users;
    for (const auto& [file, headers] : includes) {
      if (std::any_of(headers.begin(), headers.end(),
                      [&](const auto& header) { return belongs_to(foreign, header); }))
        users.insert(file);
    }
    for (const std::string& user : users) {
      const bool at_home = home.ends_with('/') ? user.starts_with(home) : user == home;
      if (!home.empty() && !at_home)
        faults.push_back(user + " includes " + foreign.library + ", which belongs to " + home);
    }
    if (!home.empty() || users.size() <= 1) continue;
    std::string list;
    for (const std::string& user : users) list += " " + user;
    faults.push_back(std::string(foreign.library) + " is included by more than one file:" + list);
  }
}

}  // namespace

std::vector<std::string> find_include_faults(const fs::path& root) {
  const Includes includes = read_tree(root);
  std::vector<std::string> faults;
  check_edges(includes, faults);
  check_headers_for_app(includes, faults);
  check_paths(includes, faults);
  check_cycles(includes, faults);
  check_foreign(includes, faults);
  return faults;
}

}  // namespace equilux
