// How each subject did, and how all did from the first half of a session to the second.
#include <algorithm>
#include <fmt/format.h>

#include "analysis/markup.h"
#include "analysis/page_sections.h"
#include "analysis/tables.h"
#include "analysis/words.h"

namespace equilux {
namespace {

std::string format_standing(const SubjectFinding& finding) {
  const SessionSummary& summary = finding.summary;
  if (summary.complete) return format_marks(finding.marks);
  if (!summary.abort_reason) return "not finished, left out";
  return fmt::format("ended early ({}), left out",
                     summary.abort_reason->empty() ? "no reason given" : escape_xml(*summary.abort_reason));
}

std::string format_catch(const SessionSummary& summary) {
  if (summary.caught.n == 0) return kDash;
  return fmt::format("{} of {}{}", summary.caught.k, summary.caught.n,
                     summary.catch_pass ? fmt::format(" (at least {})", *summary.catch_pass) : "");
}

std::vector<std::string> subject_fields(Experiment experiment, const SubjectFinding& finding) {
  const SessionSummary& s = finding.summary;
  const std::int64_t correct = s.first_half.k + s.second_half.k;
  return {
      format_experiment(experiment),
      (s.folder.empty() ? "" : escape_xml(s.folder) + ": ") +
          fmt::format(R"(<span class="key">{}</span>)", escape_xml(s.participant)),
      format_standing(finding),
      fmt::format("{} of {}", s.answered, s.scheduled),
      s.answered > 0 ? fmt::format("{:.3f}", static_cast<double>(correct) / static_cast<double>(s.answered))
                     : kDash,
      s.answered > 0 ? fmt::format("{:.3f}", static_cast<double>(s.left) / static_cast<double>(s.answered))
                     : kDash,
      finding.p_side ? format_small(*finding.p_side) : kDash,
      s.median_response_s ? fmt::format("{:.2f}", *s.median_response_s) : kDash,
      fmt::format("{}", s.too_fast),
      format_catch(s),
      format_share(finding.agreement)};
}

// "=&nbsp;0.0123", "&lt; 0.0001": what stands behind a p.
std::string format_equal_or_small(double p) {
  const std::string number = format_small(p);
  return number.starts_with('&') ? number : "=&nbsp;" + number;
}

std::string format_order(const OrderEffect& order, Experiment experiment) {
  const std::string name = format_experiment(experiment);
  if (!order.correct || !order.p)
    return fmt::format("<li>{}: {} with answers in both halves of a finished session, too few to say.</li>\n",
                       name, format_count(order.subjects, "subject"));
  return fmt::format(
      "<li>{}: from the first half of a session to the second the share of right answers of {} subjects "
      "changed by "
      "{:+.1f} percentage points (95&nbsp;% interval {:+.1f} to {:+.1f}, p&nbsp;{} by sign "
      "flips){}.</li>\n",
      name, order.subjects, 100 * *order.correct, 100 * order.interval->lower, 100 * order.interval->upper,
      format_equal_or_small(*order.p),
      order.speed ? fmt::format("; an answer took {:.2f} times as long", *order.speed) : "");
}

std::string format_flipped(const Report& report) {
  std::size_t marked = 0;
  for (const auto* subjects : {&report.artifact_subjects, &report.material_subjects}) {
    marked +=
        static_cast<std::size_t>(std::count_if(subjects->sessions.begin(), subjects->sessions.end(),
                                               [](const auto& finding) { return !finding.marks.empty(); }));
  }
  if (marked == 0) return "<p>No session is marked.</p>\n";
  std::vector<std::string> keys;
  for (const Column& column : report.flipped_without_marked) keys.push_back(escape_xml(format_key(column)));
  return fmt::format("<p>{} {} all the same. Without {} {}.</p>\n", format_count(marked, "marked session"),
                     choose_form(marked, "counts", "count"), choose_form(marked, "it", "them"),
                     keys.empty()
                         ? "no verdict would be another"
                         : fmt::format("these verdicts would be another: {}", fmt::join(keys, ", ")));
}

}  // namespace

std::string format_subjects(const Report& report) {
  Table table{{"experiment", "participant", "marks", "answered", "correct", "left", "p of side", "median, s",
               "too fast", "catch trials right", "agreement"},
              {}};
  for (const SubjectFinding& finding : report.artifact_subjects.sessions)
    table.rows.push_back(subject_fields(Experiment::kArtifact, finding));
  for (const SubjectFinding& finding : report.material_subjects.sessions)
    table.rows.push_back(subject_fields(Experiment::kMaterial, finding));
  return format_flipped(report) + "<ul>\n" +
         format_order(report.artifact_subjects.order, Experiment::kArtifact) +
         format_order(report.material_subjects.order, Experiment::kMaterial) + "</ul>\n" +
         fmt::format("<details><summary>Each of the {}</summary>\n{}</details>\n",
                     format_count(table.rows.size(), "session"), format_html_table(table, 3)) +
         "<p class=\"note\">Correct, left: shares of the answers. p of side: left against one half, "
         "two-sided exact "
         "binomial. Median: from onset to press. Catch trials right: of those answered, in brackets the "
         "least that the "
         "session&rsquo;s protocol asks for. Agreement: share of cells where the subject was right if and "
         "only if most "
         "of the others were, ties left out.</p>\n<p class=\"note\">The rules: only finished sessions count; "
         "one that was aborted is "
         "shown here "
         "and left out everywhere else; of one who withdrew nothing is left. A finished one always counts, "
         "and is marked where a reader should "
         "look "
         "twice: <i>side</i>, left and right differ (two-sided exact p of 0.001 or less); <i>fast</i>, a "
         "median "
         "below 0.3&nbsp;s; <i>catch</i>, fewer catch trials right than the session&rsquo;s protocol asks "
         "for (where that is not "
         "known, more than a quarter of at least four wrong); <i>disagrees</i>, "
         "agreement with the majority of the others three robust deviations below the median. Too fast: "
         "answers in less than the protocol&rsquo;s least time, kept and counted. From "
         "<code>subjects.csv</code> and <code>order.csv</code>.</p>\n";
}

}  // namespace equilux
