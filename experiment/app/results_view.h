// The results screen of the workspace: graphs and EE table of the answers so far.
#pragma once

#include <string>
#include <vector>

#include "analysis/interim.h"
#include "experiment/app/gui.h"
#include "experiment/app/window.h"

namespace equilux {

class ResultsView {
 public:
  ResultsView(StudyFolder folder, Study study);

  /// Reads the log anew. What is wrong with it is said on the screen.
  void read(SubjectKind kind);
  /// A key's GLFW code. False for one that this screen does not know.
  bool press(int code);
  void draw(AppWindow& window, const Gui& gui);

 private:
  void draw_table() const;
  void draw_graphs() const;
  std::vector<const ColumnFinding*> columns_of(const std::string& geometry,
                                               const std::string& material) const;
  std::vector<std::string> list_lines() const;

  StudyFolder folder_;
  Study study_;
  std::vector<std::string> geometries_, materials_;
  std::vector<Illumination> illuminations_;
  std::size_t illumination_ = 0;
  SubjectKind kind_ = SubjectKind::kPerson;
  Rule rule_ = Rule::kPaper;
  InterimFindings interim_;
  std::string message_;
  float scroll_x_ = 0, scroll_y_ = 0;  ///< by keys, since the last frame
};

}  // namespace equilux
