// The files of a report that other programs read: CSV tables with a dictionary, and the whole as JSON.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "analysis/csv.h"
#include "analysis/report.h"
#include "base/json.h"

namespace equilux {

/// A file of the report and what is in it.
struct ReportTable {
  std::string file;  ///< cells.csv
  Table table;
};

/// cells.csv, thresholds.csv, ee.csv, subjects.csv, order.csv and trends.csv of all studies, one below the
/// other; the first columns name the study and the kind of those
/// who answered.
std::vector<ReportTable> make_report_tables(const std::vector<Report>& reports);

/// What a column of a file means.
struct DictionaryEntry {
  const char* files;  ///< separated by spaces
  const char* column;
  const char* datatype;  ///< of CSVW: string, integer, number, boolean
  const char* meaning;
};

/// The entry of a column; a column without one is our bug.
const DictionaryEntry& find_entry(std::string_view file, std::string_view column);

/// One object for each row, typed by the dictionary.
Json make_rows_json(const ReportTable& table);

/// csv-metadata.json: the tables and the meaning of each column.
/// source: W3C, Metadata Vocabulary for Tabular Data (CSVW), 2015.
Json make_csv_metadata(const std::vector<ReportTable>& tables);

/// report.json: versions, digests, seeds, rules, and every finding.
Json make_report_json(const std::vector<Report>& reports);

/// "C4", or "none" for a place beyond either end of the scale.
std::string format_place(int place, const Study& study);

}  // namespace equilux
