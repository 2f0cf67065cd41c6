// Graphs as values: well-formed, complete, and readable without colour.
#include "analysis/graph.h"

#include <boost/property_tree/xml_parser.hpp>
#include <gtest/gtest.h>
#include <sstream>

#include "analysis/markup.h"
#include "analysis/tables.h"
#include "base/error.h"
#include "tests/analysis/columns.h"

namespace equilux::tests {
namespace {

boost::property_tree::ptree read_xml(const std::string& text) {
  std::istringstream stream(text);
  boost::property_tree::ptree tree;
  boost::property_tree::read_xml(stream, tree);
  return tree;
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST(Graph, is_well_formed_xml_with_a_cell_for_each_level_and_count) {
  const PlantedStudy planted = make_planted_study("paper", 12, 14, 1, 0.02);
  const auto findings = find_in(planted);
  for (const Object& object : enumerate_objects(planted.study)) {
    const std::string svg = draw_graph(object, findings_of(findings, object), Rule::kPaper);
    ASSERT_NO_THROW(read_xml(svg)) << svg;
    ASSERT_EQ(read_xml(svg).get<std::string>("svg.<xmlattr>.xmlns"), "http://www.w3.org/2000/svg");
    ASSERT_EQ(count_of(svg, "class=\"cell\""), 3U * 11U);
    ASSERT_EQ(count_of(svg, "<title>"), 3U * 11U + 3U) << "of each cell and of each column";
  }
}

// G0-MS-ind-1k of pocket is planted free of artifacts from C10 on and of the same material up to C3.
TEST(Graph, says_of_a_material_cut_below_all_tested_levels_that_it_lies_there) {
  const PlantedStudy planted = make_planted_study("pocket", 200, 200, 1, 0.0);
  const Object object = enumerate_objects(planted.study)[0];
  const std::string svg = draw_graph(object, findings_of(find_in(planted), object), Rule::kPaper);
  EXPECT_EQ(count_of(svg, "material cut &lt; C10 (censored_low)"), 1U) << svg;
}

TEST(Graph, has_a_dot_for_each_tested_cell_of_either_experiment) {
  const PlantedStudy planted = make_planted_study("pocket", 12, 14, 1, 0.02);
  const auto findings = find_in(planted);
  std::size_t dots = 0;
  for (const Object& object : enumerate_objects(planted.study)) {
    dots += count_of(draw_graph(object, findings_of(findings, object), Rule::kPaper), "<circle");
  }
  EXPECT_EQ(dots, 8U * 4U + enumerate_selected_cells(planted.selection, planted.study).size());
}

TEST(Graph, puts_no_clamp_at_the_bottom_and_letters_every_region) {
  const PlantedStudy planted = make_planted_study("pocket", 200, 200, 1, 0.0);
  const auto findings = find_in(planted);
  const Object object = enumerate_objects(planted.study)[1];
  const std::string svg = draw_graph(object, findings_of(findings, object), Rule::kPaper);
  const auto height_of = [&](const std::string& label) {
    const std::size_t end = svg.find(">" + label + "</text>");
    const std::size_t at = svg.rfind(" y=\"", end);
    return std::stod(svg.substr(at + 4));
  };
  EXPECT_GT(height_of("C0"), height_of("C1"));
  EXPECT_GT(height_of("C9"), height_of("C10"));
  EXPECT_EQ(count_of(svg, ">A</text>") + count_of(svg, ">M</text>") + count_of(svg, ">E</text>") +
                count_of(svg, ">?</text>"),
            2U * 11U);
}

TEST(Graph, of_untested_columns_is_all_question_marks_without_dots) {
  const Study study = load_protocol("pocket");
  const Tally none = tally_answers({}, study);
  const auto findings = find_equivalence(study, none, none, nullptr);
  const Object object = enumerate_objects(study).front();
  const std::string svg = draw_graph(object, findings_of(findings, object), Rule::kPaper);
  EXPECT_EQ(count_of(svg, ">?</text>"), 22U);
  EXPECT_EQ(count_of(svg, "<circle"), 0U);
}

// Opacity of the cell of this level, which follows its title.
std::string find_opacity(const std::string& svg, const std::string& level) {
  const std::string name = "fill-opacity=\"";
  const std::size_t at = svg.find(name, svg.find("-" + level + ": ")) + name.size();
  return svg.substr(at, svg.find('"', at) - at);
}

std::string find_opacities(const std::string& svg) {
  std::string text;
  for (int level = 0; level < kClampLevelCount; ++level)
    text += find_opacity(svg, format_clamp(level)) == "1" ? '#' : '.';
  return text;
}

// Artifacts tested at C3 to C6, material at C2 and from C5 on every second level: only where both were does
// green, or red on a level free of artifacts, rest on answers.
TEST(Graph, draws_a_cell_paler_unless_every_experiment_its_colour_speaks_of_was_asked_there) {
  const Study study = load_protocol("pocket");
  Tally artifact = tally_answers({}, study), material = artifact;
  const Column column = enumerate_columns(study).front();
  const auto draw = [&] {
    const auto findings = find_equivalence(study, artifact, material, nullptr);
    return draw_graph(column.object, {&findings.front()}, Rule::kPaper);
  };
  for (const auto& [level, k] : {std::pair{3, 12}, {4, 12}, {5, 3}, {6, 3}})
    artifact[Cell{column, level, false}] = {k, 12};
  for (const int level : {5, 7, 9, 10}) material[Cell{column, level, false}] = {3, 14};
  EXPECT_EQ(find_opacities(draw()), "...###.....") << "green from C5 on, both asked at C5 alone";
  for (const int level : {6, 9, 10}) material[Cell{column, level, false}] = {14, 14};
  EXPECT_EQ(find_opacities(draw()), "...####....") << "red from C6 on, both asked at C6 alone";
  material[Cell{column, 2, false}] = {14, 14};
  EXPECT_EQ(find_opacities(draw()), ".....##....") << "both from C2 to C4, each asked of one alone";
  artifact[Cell{column, 2, false}] = {12, 12};
  material[Cell{column, 3, false}] = {14, 14};
  EXPECT_EQ(find_opacities(draw()), "..##.##....") << "at C4 nobody was asked of the material";
}

// A file of its own is all that a reader may have.
TEST(Graph, in_a_file_of_its_own_says_whose_answers_by_what_rule_it_shows_and_what_it_means) {
  const PlantedStudy planted = make_planted_study("pocket", 12, 14, 1, 0.02);
  const auto findings = find_in(planted);
  const Object object = enumerate_objects(planted.study).front();
  const auto draw = [&](SubjectKind kind, Rule rule) {
    return draw_lone_graph(object, findings_of(findings, object), rule, "po<cket", kind);
  };
  const std::string svg = draw(SubjectKind::kPlanted, Rule::kPaper);
  ASSERT_NO_THROW(read_xml(svg)) << svg;
  for (const char* words :
       {">PLANTED SUBJECTS, whose answers were put in<", ">study po&lt;cket, rule paper<", ">VPLs<",
        ">clamp level, C10 most clamped<", "bold and underlined: supported", "Paler: inferred"})
    EXPECT_EQ(count_of(svg, words), 1U) << words;
  EXPECT_EQ(count_of(svg, "class=\"cell\""), 2U * 11U);
  EXPECT_EQ(count_of(draw(SubjectKind::kPerson, Rule::kIsotonic), "PLANTED"), 0U);
  EXPECT_EQ(count_of(draw(SubjectKind::kPerson, Rule::kIsotonic), ">answers of persons<"), 1U);
  EXPECT_EQ(count_of(draw(SubjectKind::kLooking, Rule::kIsotonic), ">SIMULATED SUBJECTS"), 1U);
}

TEST(Graph, its_legend_is_well_formed_xml) { EXPECT_NO_THROW(read_xml(draw_legend())); }

TEST(Graph, the_xml_reader_of_these_tests_refuses_an_element_left_open) {
  EXPECT_ANY_THROW(read_xml("<svg><g></svg>"));
}

TEST(Markup, escapes_the_five_characters) {
  EXPECT_EQ(escape_xml("<a href='x'>\"&\""), "&lt;a href=&#39;x&#39;&gt;&quot;&amp;&quot;");
}

TEST(Markup, wraps_between_words_and_lets_a_long_one_stand) {
  EXPECT_EQ(wrap_words("ab cd efghijk l", 5), (std::vector<std::string>{"ab cd", "efghijk", "l"}));
  EXPECT_TRUE(wrap_words("", 5).empty());
}

TEST(Markup, fills_every_place_and_wants_every_value_used) {
  EXPECT_EQ(fill_template("{{a}}-{{b}}-{{a}}", {{"a", "{{b}}"}, {"b", "2"}}), "{{b}}-2-{{b}}");
  EXPECT_THROW(fill_template("{{a}}", {}), CheckFailure);
  EXPECT_THROW(fill_template("", {{"a", "1"}}), CheckFailure);
}

}  // namespace
}  // namespace equilux::tests
