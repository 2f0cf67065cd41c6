// Temporary name, fsync, rename, fsync of the folder: the order in which a file becomes real.
#include "base/files.h"

#include <cerrno>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <optional>
#include <unistd.h>
#include <utility>

#include "base/error.h"
#include "base/program.h"

namespace equilux {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void fail_store(const fs::path& path, std::string_view what) {
  throw StoreError(fmt::format("{}: cannot {}: {}", path.string(), what, std::strerror(errno)));
}

class OpenFile {
 public:
  OpenFile(const fs::path& path, int flags)
      : path_(path), descriptor_(::open(path.c_str(), flags | O_CLOEXEC, 0666)) {
    if (descriptor_ < 0) fail_store(path, "open");
  }
  ~OpenFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  void write(std::string_view text) {
    while (!text.empty()) {
      const ssize_t written = ::write(descriptor_, text.data(), text.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) fail_store(path_, "write");
      text.remove_prefix(static_cast<std::size_t>(written));
    }
  }
  void sync() {
    if (::fsync(descriptor_) != 0) fail_store(path_, "sync");
  }
  // Where a file system of the network tells that a disk or a quota is full.
  void close() {
    if (::close(std::exchange(descriptor_, -1)) != 0 && errno != EINTR) fail_store(path_, "close");
  }

 private:
  fs::path path_;
  int descriptor_;
};

fs::path folder_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

// Who writes a file: a folder may be seen from several machines, whose process numbers are their own.
struct Writer {
  pid_t process = 0;
  std::string host;
};

fs::path part_path(const fs::path& path) {
  return path.string() + fmt::format(".{}@{}.part", ::getpid(), find_host_name());
}

// The writer of a file named by part_path; empty for any other name.
std::optional<Writer> find_writer(const fs::path& part) {
  const std::string name = part.filename().string();
  static constexpr std::string_view kEnd = ".part";
  const std::size_t at = name.rfind('@');
  if (!name.ends_with(kEnd) || at == std::string::npos || at + 1 >= name.size() - kEnd.size()) return {};
  const std::size_t dot = name.rfind('.', at);
  if (dot == std::string::npos || dot == 0) return {};
  Writer writer{0, name.substr(at + 1, name.size() - kEnd.size() - at - 1)};
  const char* end = name.data() + at;
  if (std::from_chars(name.data() + dot + 1, end, writer.process).ptr != end || writer.process <= 0)
    return {};
  return writer;
}

bool has_ended(pid_t process) { return ::kill(process, 0) != 0 && errno == ESRCH; }

// A file takes seconds to write; that the process of another machine runs cannot be asked.
constexpr auto kLongestWrite = std::chrono::hours(24);

// `write` leaves the bytes of the temporary file on the disk.
void replace_file(const fs::path& path, const std::function<void(const fs::path&)>& write) {
  if (path_exists(path) && !is_file(path)) {
    throw StoreError(fmt::format("{}: cannot write: expected a regular file or a free name, got another kind",
                                 path.string()));
  }
  const fs::path temporary = part_path(path);
  try {
    write(temporary);
    if (::rename(temporary.c_str(), path.c_str()) != 0) fail_store(path, "rename a new file to");
    OpenFile(folder_of(path), O_RDONLY | O_DIRECTORY).sync();
  } catch (...) {
    ::unlink(temporary.c_str());
    throw;
  }
}

bool is_stale(const fs::path& part) {
  const auto writer = find_writer(part);
  if (!writer) return false;
  if (writer->host == find_host_name()) return has_ended(writer->process);
  std::error_code error;
  const auto written = fs::last_write_time(part, error);
  return !error && fs::file_time_type::clock::now() - written > kLongestWrite;
}

}  // namespace

std::string load_text(const fs::path& path, std::size_t max_bytes) {
  std::error_code error;
  if (fs::is_directory(path, error)) throw InputError(path.string(), "", "a file", "a folder");
  // A pipe would be waited for.
  if (path_exists(path) && !is_file(path))
    throw InputError(path.string(), "", "a regular file", "another kind");
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw InputError(path.string(), "", "a readable file", std::strerror(errno));
  std::string text;
  char buffer[1 << 16];
  while (stream) {
    stream.read(buffer, sizeof buffer);
    text.append(buffer, static_cast<std::size_t>(stream.gcount()));
    if (text.size() > max_bytes) {
      throw InputError(path.string(), "", fmt::format("at most {} bytes", max_bytes), "more");
    }
  }
  if (stream.bad()) throw InputError(path.string(), "", "a readable file", std::strerror(errno));
  return text;
}

void save_text(const fs::path& path, std::string_view text) {
  replace_file(path, [&](const fs::path& temporary) {
    OpenFile file(temporary, O_WRONLY | O_CREAT | O_TRUNC);
    file.write(text);
    file.sync();
    file.close();
  });
}

bool path_exists(const fs::path& path) {
  std::error_code error;
  return fs::exists(path, error);
}

bool is_file(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

void check_writable(const fs::path& path) {
  std::error_code error;
  if (path.empty() || !fs::is_directory(folder_of(path), error)) {
    throw InputError(path.string(), "", "a file name in a folder that is there", "none such");
  }
  if (path_exists(path) && !is_file(path)) {
    throw InputError(path.string(), "", "a regular file or a free name", "another kind");
  }
}

void save_atomically(const fs::path& path, const std::function<void(const fs::path&)>& write) {
  replace_file(path, [&](const fs::path& temporary) {
    write(temporary);
    OpenFile file(temporary, O_RDONLY);
    file.sync();
    file.close();
  });
}

void remove_stale_parts(const fs::path& folder) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    if (is_stale(entry.path())) fs::remove(entry.path(), ignored);
  }
}

void make_folder(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  const bool is_taken = error && path_exists(path) && !fs::is_directory(path);
  if (error)
    throw StoreError(fmt::format("{}: cannot make the folder: {}", path.string(),
                                 is_taken ? "a file has that name" : error.message()));
}

}  // namespace equilux
