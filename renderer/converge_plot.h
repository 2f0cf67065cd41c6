// The plot of a convergence, drawn by gnuplot.
#pragma once

#include <filesystem>
#include <string>

#include "stimuli/convergence.h"

namespace equilux {

enum class PlotFormat { kSvg, kPng };

/// Commands for gnuplot that draw relative rms against wall time into a file, both by logarithms: a curve for
/// each series with its slope, the least error so far as a step line, and the noise of the reference.
std::string format_convergence_plot(const Convergence& convergence, PlotFormat format,
                                    const std::filesystem::path& file);

/// False where every error is lost in the reference's noise.
bool can_be_drawn(const Convergence& convergence);

/// errors: InputError where gnuplot cannot be run
void check_gnuplot();

/// errors: StoreError
void draw_convergence(const Convergence& convergence, PlotFormat format, const std::filesystem::path& file);

}  // namespace equilux
