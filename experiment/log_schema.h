// The file of a log: known as one before anything is written, whole, of this schema or brought up to it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "experiment/database.h"

namespace equilux {

/// Opens a log to be written, or makes it where `create`, for its owner's eyes alone. One of an older schema
/// is brought up to this one; a copy of it as it was stays beside it, see kept_copies. errors: InputError for
/// a file that is no log, has a newer schema, or is missing and not to be made; StoreError where WAL cannot
/// work.
Database open_log(const std::filesystem::path& path, bool create);

/// The log as its last commit left it, in memory, of this schema: nothing beside the file is touched, also
/// where it is being written, its folder is read-only, or a WAL was left. errors: as open_log
Database open_log_snapshot(const std::filesystem::path& path);

/// Copies that open_log has kept beside a log before it brought it up to a newer schema, sorted.
std::vector<std::filesystem::path> find_kept_copies(const std::filesystem::path& path);

/// 32 random hexadecimal digits, from the system's entropy.
std::string draw_identity();

}  // namespace equilux
