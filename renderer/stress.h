// Stiff and extreme cases: what each should give, and what it gives.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace equilux {

enum class StressOutcome { kHolds, kFails };

struct StressRow {
  std::string subject;  ///< what is stressed
  std::string what;
  std::string expected;
  std::string got;
  StressOutcome outcome = StressOutcome::kFails;
};

/// A row that holds or fails.
StressRow make_stress_row(std::string subject, std::string what, std::string expected, std::string got,
                          bool holds);

/// A case whose right answer is an InputError: the row shows its message.
StressRow expect_input_error(std::string subject, std::string what, const std::function<void()>& body);

/// BRDFs: roughness from 1e-4 to 1, cosines down to 1e-7.
std::vector<StressRow> stress_materials();
/// VPLs on, near and behind the point; extreme powers and clamps; so many millions of them.
std::vector<StressRow> stress_vpls(int millions = 25);
/// Bounds around the point, and cuts through lights of every distance and power.
std::vector<StressRow> stress_lightcuts();
/// Scenes scaled, degenerate meshes, lights where they should not be.
std::vector<StressRow> stress_scenes();
/// Tone mapping and files.
std::vector<StressRow> stress_pictures();

/// All rows as a Markdown table.
std::string format_stress(const std::vector<StressRow>& rows);

}  // namespace equilux
