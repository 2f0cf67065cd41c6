// Every answer that counts as a row: what mixed-effects models in R start from.
#pragma once

#include "analysis/csv.h"
#include "analysis/report.h"

namespace equilux {

/// answers.csv: a row for each answer of a finished session, in order of experiment, session and cell. The
/// columns are explained in csv-metadata.json beside it.
Table make_answers_table(const std::vector<Report>& reports);

}  // namespace equilux
