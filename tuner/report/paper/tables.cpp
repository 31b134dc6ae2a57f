#include "report/paper/tables.hpp"

#include "output/format.hpp"
#include "pictures/html.hpp"
#include "report/paper/conclusions.hpp"
#include "report/paper/parts.hpp"

namespace assur::report {

Section paper_conclusions(const PaperResults& r) {
  using enum pictures::HtmlTable::Column;
  Section s{"paper-conclusions", "The paper's conclusions, on this machine", "", {}};
  pictures::HtmlTable table{
      {"section", "they conclude", "theirs", "here", "verdict"}, {text, words, words, words, words}, {}};
  int count[3] = {0, 0, 0};
  for (const Conclusion& c : conclusions(r.times, r.threads)) {
    ++count[static_cast<std::size_t>(c.verdict)];
    table.rows.push_back({{c.where, c.claim, c.theirs, c.here, std::string(verdict_text(c.verdict))},
                          c.verdict == Verdict::does_not_hold ? "strong" : ""});
  }
  s.body +=
      paragraph(std::to_string(count[0]) + " hold here, " + std::to_string(count[1]) + " do not, " +
                std::to_string(count[2]) + " cannot be tested here. Each is decided by one rule that is asked of " +
                "the paper's own times and of those measured here.");
  s.body += html(table);
  if (r.stand_ins.sparse == "klu") {
    s.body += faint(
        "klu, which stands for MA27, finds its pivots once for a pattern and keeps them from step to step, and finds "
        "the groups in the global matrix by itself (block triangular form). All times are those with one "
        "factorisation for velocity and acceleration.");
  }
  return s;
}

std::vector<Section> paper_sections(const PaperResults& r, const PaperOptions& options) {
  std::vector<Section> out = {paper_table_2(r),          paper_figure_2(r), paper_table_3(r),    paper_figure_3(r),
                              paper_table_4(r, options), paper_table_5(r),  paper_conclusions(r)};
  if (r.noise.quiet != measure::Quiet::yes) {
    out[0].body = paragraph("The machine was not quiet: " + r.noise.reason + ".") + out[0].body;
  }
  if (r.interrupted) out[0].body = paragraph("Interrupted: only what was done until then is here.") + out[0].body;
  return out;
}

std::vector<Section> reproduce_paper(const PaperOptions& options) {
  return paper_sections(run_the_paper(options), options);
}

}  // namespace assur::report
