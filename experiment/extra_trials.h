// Trials that are not counted: practice before, and catch trials among those that are.
#pragma once

#include <string>
#include <vector>

#include "experiment/schedule.h"
#include "protocols/session_protocol.h"

namespace equilux {

/// Pictures whose difference nobody misses, one cell for each object: in the artifact experiment clamped the
/// least, in the material one the most, and of those with the fewest VPLs; none that is `counted`, so that
/// nothing counted is given away by a label, by feedback or by having been seen. An object all of whose cells
/// are counted gives one all the same.
std::vector<Cell> enumerate_obvious_cells(const Study& study, Experiment experiment,
                                          const std::vector<Cell>& counted);

/// The counted trials with the protocol's practice before them and its catch trials among them, one in each
/// of as many equal stretches, numbered anew. Views and sides of each kind are balanced as those of the
/// counted trials are. A function of (study, protocol, experiment, kind, session seed, index) alone.
std::vector<TrialRow> add_extra_trials(std::vector<TrialRow> counted, const Study& study,
                                       const SessionProtocol& protocol, Experiment experiment,
                                       SubjectKind kind, std::uint64_t session_seed, std::int64_t index);

/// A page of the familiarisation: one picture, or a pair of which the second shows what is asked for.
struct FamiliarPage {
  std::string left_key;
  std::string right_key;  ///< empty: the left picture alone
};

/// All objects as references, then labelled pairs. The same for every subject.
std::vector<FamiliarPage> enumerate_familiar_pages(const Study& study, const SessionProtocol& protocol,
                                                   Experiment experiment, const std::vector<Cell>& counted);

/// Pictures that practice, catch trials and familiarisation may show, each once, sorted.
std::vector<std::string> enumerate_extra_keys(const Study& study, const SessionProtocol& protocol,
                                              Experiment experiment, const std::vector<Cell>& counted);

}  // namespace equilux
