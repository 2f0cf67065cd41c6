// From a truth file to what is planted in each column.
#include "protocols/truth.h"

#include "protocols/by_column.h"

namespace equilux {

extern const char kTruthSchema[];

Truth load_truth(const std::filesystem::path& path, const Study& study) {
  Truth truth;
  truth.source = load_json(path, kTruthSchema);
  truth.digest = digest_json(truth.source);
  truth.lapse_rate = truth.source.at("lapse_rate").as_double();
  truth.side_bias = truth.source.at("side_bias").as_double();
  const auto level = [&](const Json& row, const char* member, int never, const std::string& place) {
    const std::string& text = row.at(member).as_string();
    return text == "never" ? never : parse_clamp_level(text, path.string(), place + "/" + member);
  };
  truth.by_column = read_by_column<PlantedColumn>(
      truth.source.at("columns"), study, path.string(), "/columns",
      [&](const Json& row, const std::string& place) {
        return PlantedColumn{level(row, "artifact_free_from", kClampLevelCount, place),
                             level(row, "material_same_to", -1, place)};
      });
  return truth;
}

}  // namespace equilux
