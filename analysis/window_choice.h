// Which four clamp levels of each column to test: from a pilot's answers or from a predicted visibility.
#pragma once

#include <filesystem>
#include <map>
#include <string_view>

#include "analysis/thresholds.h"
#include "protocols/windows.h"

namespace equilux {

/// Window around a cut, two levels to either side: a cut beyond the tested levels moves the window on, so
/// that it overlaps them by one level. Where the study's levels have gaps, the nearest window that has all
/// its levels. Empty where the column was not tested. errors: InputError where no four levels are adjacent.
std::optional<int> choose_first_level(const ColumnCounts& counts, const std::vector<int>& clamp_levels,
                                      Rule rule, int percent = kFlagPercent);

/// Windows of a pilot's artifact answers; columns that it did not test keep what `standing` says.
std::map<Column, Window> choose_windows(const Study& study, const Tally& artifact, const Windows& standing,
                                        Rule rule, WindowOrigin origin);

/// A prediction as a tally, with n = 1,000,000 in each cell that has one. `text` is CSV with the columns
/// column (G1-MR-ind-100k), clamp (C4) and proportion (correct, 0 to 1), as spreadsheets write it too: with a
/// BOM, lines ended by CR LF, blank ones at the end. errors: InputError naming `source` and the line, also
/// for two rows of one cell, two columns of one name, and no rows.
Tally parse_prediction(std::string_view text, std::string_view source, const Study& study);

/// windows.json, ready to be edited by hand.
std::string format_windows(const std::map<Column, Window>& windows, const Study& study,
                           std::string_view description);

}  // namespace equilux
