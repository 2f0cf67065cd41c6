// The file of a log: known as one before anything is written, whole, of this schema or brought up to it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "experiment/database.h"
#include "experiment/trial_log.h"

namespace equilux {

/// What to do about a file that is not as this program leaves it.
inline constexpr const char* kDamageAdvice = "keep this file as it is, and go on with a copy from before";

/// Whether a file of this name is there, unless its maker was stopped before the first transaction: then
/// nothing was ever recorded in it, and open_log makes it.
bool has_log(const std::filesystem::path& path);

/// Opens a log to be written, or makes it where `create`, for its owner's eyes alone. One of an older schema
/// is brought up to this one; a copy of it as it was stays beside it, see kept_copies. errors: InputError for
/// a file that is no log, has a newer schema, or is missing and not to be made; StoreError where WAL cannot
/// work.
Database open_log(const std::filesystem::path& path, bool create);

/// The same for one that must be there, while no other program has it open. errors: as above; StoreError if
/// one has
Database open_log_alone(const std::filesystem::path& path);

/// The log as its last commit left it, in memory, of this schema: nothing beside the file is touched, also
/// where it is being written, its folder is read-only, or a WAL was left (whose index a reader may
/// make). errors: as open_log
Database open_log_snapshot(const std::filesystem::path& path, LogCheck check = LogCheck::kWhole);

/// Copies that open_log has kept beside a log before it brought it up to a newer schema, sorted.
std::vector<std::filesystem::path> find_kept_copies(const std::filesystem::path& path);

/// Opens one of them to be written, of whatever schema it is. errors: InputError if it is no log
Database open_kept_copy(const std::filesystem::path& path);

/// Copies that were being made when their maker was killed.
std::vector<std::filesystem::path> find_unfinished_copies(const std::filesystem::path& path);

/// What is said of a row whose session is not there, and of a finished session without trials.
[[noreturn]] void refuse_orphan(const std::string& source, std::int64_t session, const std::string& row);
[[noreturn]] void refuse_without_trials(const std::string& source, std::int64_t session);

/// 32 random hexadecimal digits, from the system's entropy.
std::string draw_identity();

}  // namespace equilux
