// A convergence as a table and as a page.
#pragma once

#include <string>

#include "stimuli/convergence.h"

namespace equilux {

/// A row for each setting. units: seconds; errors of 1. columns: docs/error-vs-time.md
std::string format_convergence_csv(const Convergence& convergence);

/// Markdown: the advice, the plot in that file (empty: none), what more time buys, parts of the error, every
/// setting.
std::string format_convergence_page(const Convergence& convergence, const std::string& plot_file);

}  // namespace equilux
