// Answers of a study and what is found in them, for tests of how sure that is.
#pragma once

#include <fmt/format.h>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "analysis/uncertainty.h"
#include "tests/analysis/columns.h"

namespace equilux::tests {

struct Answered {
  Study study;
  std::vector<AnswerRow> artifact, material;
  std::optional<Selection> selection = std::nullopt;

  std::vector<ColumnFinding> find() const {
    return find_equivalence(study, tally_answers(artifact, study), tally_answers(material, study),
                            selection ? &*selection : nullptr);
  }
  std::vector<ColumnUncertainty> disturb(const UncertaintyParams& params) const {
    return find_uncertainty(study, find(), make_response_matrix(artifact), make_response_matrix(material),
                            params)
        .columns;
  }
};

inline Answered from(const PlantedStudy& planted) {
  return {planted.study, planted.artifact, planted.material, planted.selection};
}

/// One column, one artifact level and one material level at the same clamp, k of n right in each.
inline Answered make_two_cells(int k_artifact, int n_artifact, int k_material, int n_material) {
  Answered answered;
  answered.study = load_protocol("pocket");
  const Column column = enumerate_columns(answered.study).front();
  for (int i = 0; i < n_artifact; ++i)
    answered.artifact.push_back({i + 1, i, {column, 5, false}, i < k_artifact});
  for (int i = 0; i < n_material; ++i)
    answered.material.push_back({i + 1, i, {column, 5, false}, i < k_material});
  return answered;
}

/// Sessions 1, 2, ... of persons who had so many each.
inline std::map<std::int64_t, std::string> make_codes(int sessions, int sessions_of_each) {
  std::map<std::int64_t, std::string> codes;
  for (int i = 0; i < sessions; ++i) codes[i + 1] = fmt::format("P{}", i / sessions_of_each);
  return codes;
}

}  // namespace equilux::tests
