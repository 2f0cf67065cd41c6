// Rows and their table.
#include "renderer/stress.h"

#include "base/error.h"

namespace equilux {
namespace {

const char* name_of(StressOutcome outcome) { return outcome == StressOutcome::kHolds ? "holds" : "FAILS"; }

// Without the temporary folder's name, which differs from run to run.
std::string without_folder(std::string message) {
  const std::size_t name = message.find("equilux-stress-");
  if (name == std::string::npos) return message;
  return message.substr(message.find('/', name) + 1);
}

}  // namespace

StressRow make_stress_row(std::string subject, std::string what, std::string expected, std::string got,
                          bool holds) {
  return {std::move(subject), std::move(what), std::move(expected), std::move(got),
          holds ? StressOutcome::kHolds : StressOutcome::kFails};
}

StressRow expect_input_error(std::string subject, std::string what, const std::function<void()>& body) {
  const char* expected = "a clear error";
  try {
    body();
  } catch (const InputError& error) {
    return make_stress_row(std::move(subject), std::move(what), expected, without_folder(error.what()), true);
  }
  return make_stress_row(std::move(subject), std::move(what), expected, "none", false);
}

std::string format_stress(const std::vector<StressRow>& rows) {
  std::string text = "| subject | case | expected | got | |\n|---|---|---|---|---|\n";
  for (const StressRow& row : rows) {
    text += fmt::format("| {} | {} | {} | {} | {} |\n", row.subject, row.what, row.expected, row.got,
                        name_of(row.outcome));
  }
  return text;
}

}  // namespace equilux
