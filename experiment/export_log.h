// Answers for other programs: tidy CSV, or a BIDS folder. A function of the log alone: made again, the same
// bytes.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "experiment/export_columns.h"
#include "protocols/study.h"

namespace equilux {

/// Bytes of each file, by its name within the folder.
using ExportFiles = std::map<std::string, std::string>;

/// Sessions of one kind, ordered by experiment, index and start, so that merged logs give the same order.
std::vector<SessionRecord> load_records(const TrialLog& log, SubjectKind kind);

/// sessions, fields, trials and events as CSV (RFC 4180, lines ended by a line feed), dictionary.csv,
/// export.json.
ExportFiles make_csv_export(const std::vector<SessionRecord>& records, const Study& study, SubjectKind kind);

/// A folder by BIDS 1.8 with the modality beh. errors: InputError where two codes give one label
ExportFiles make_bids_export(const std::vector<SessionRecord>& records, const Study& study, SubjectKind kind);

/// A BIDS label of a code: letters and digits; where it has others, 8 digits of its SHA-256 keep it apart.
std::string make_bids_label(const std::string& code);

/// The absolute path of an export's folder, without a slash at its end: one name, however it was typed.
std::filesystem::path find_export_folder(const std::filesystem::path& folder);

/// Where it is written before it is whole, and stays if its writer is killed.
std::filesystem::path find_export_part(const std::filesystem::path& folder);

/// Before anything is written. errors: InputError unless the name is free or an empty folder's, or, with
/// `force`, a folder's that holds an earlier export and nothing else; and where find_export_part holds
/// anything that no export left there
void check_can_export(const std::filesystem::path& folder, bool force);

/// Writes beside the folder, then gives it its name: there is all of it or what was there. errors: as
/// check_can_export; StoreError
void save_export(const std::filesystem::path& folder, const ExportFiles& files, bool force);

/// export.json, by which --force knows an earlier export: what it is of, and every file with its digest.
std::string format_export_record(const ExportFiles& files, const Study& study, SubjectKind kind,
                                 ExportFormat format);
inline constexpr const char* kExportRecord = "export.json";

}  // namespace equilux
