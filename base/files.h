// Files that appear under their name only when whole.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace equilux {

/// Whole text of a file. errors: InputError if missing, a folder, a pipe or device, unreadable or larger than
/// `max_bytes`.
std::string load_text(const std::filesystem::path& path, std::size_t max_bytes = std::size_t{64} << 20);

/// True if something of this name is there; false also where it cannot be reached.
bool path_exists(const std::filesystem::path& path);

/// True if the name leads to a regular file.
bool is_file(const std::filesystem::path& path);

/// Writes beside `path`, syncs, then renames over it. errors: StoreError; then nothing stands under the name,
/// or what stood there before. A name that is not a regular file's (a device, a folder) is never replaced.
void save_text(const std::filesystem::path& path, std::string_view text);

/// The same for a file that another library writes: `write` gets the temporary path.
void save_atomically(const std::filesystem::path& path,
                     const std::function<void(const std::filesystem::path&)>& write);

/// Before long work: errors: InputError unless the folder of `path` is there and the name is free or a
/// regular file's, so that save_text can succeed.
void check_writable(const std::filesystem::path& path);

/// Removes the half-written files that writers which no longer run left in a folder; those of another
/// machine's writers, of which that cannot be known, a day after they were last written to.
void remove_stale_parts(const std::filesystem::path& folder);

/// Makes the folder and its parents. errors: StoreError.
void make_folder(const std::filesystem::path& path);

}  // namespace equilux
