// The graph of an object as in the paper's Figure 4, drawn from findings that are already made.
#pragma once

#include <string>
#include <vector>

#include "analysis/equivalence.h"

namespace equilux {

/// How a graph stands in a page.
struct GraphPlace {
  double scale = 1;        ///< enlarges the whole
  std::string study = "";  ///< keeps the hatches apart from those of other studies in a page
};

/// An SVG element that stands alone in a file or inline in a page: x VPL count, y clamp level with no clamp
/// at the bottom; a column a count, a cell a level, coloured, hatched and lettered by its region; a dot at
/// the left for the artifact experiment and at the right for the material experiment, filled where flagged.
/// A cell is paler where not every experiment that its colour speaks of was asked there.
/// `columns` are those of the object, from few to many VPLs.
std::string draw_graph(const Object& object, const std::vector<const ColumnFinding*>& columns, Rule rule,
                       const GraphPlace& place = {});

/// The same for a file of its own: whose answers of which study it shows, by what rule, and the key below.
std::string draw_lone_graph(const Object& object, const std::vector<const ColumnFinding*>& columns, Rule rule,
                            const std::string& study, SubjectKind kind);

/// The key to the graphs, drawn with the same hand. `name` keeps its hatches apart from those of others in a
/// page.
std::string draw_legend(const std::string& name = "");

}  // namespace equilux
