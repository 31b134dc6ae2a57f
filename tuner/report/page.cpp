#include "report/page.hpp"

#include "output/format.hpp"
#include "pictures/plot.hpp"

namespace assur::report {
namespace {

using pictures::escaped;

constexpr std::size_t kMostRows = 200;  // rows of the table of all numbers; the CSV has the rest

constexpr std::string_view kStyle = R"(
html { scroll-behavior: smooth; }
h2 { border-top: 1px solid var(--rule); padding-top: 1rem; margin-top: 2.5rem; font-size: 1.3rem; }
h3 { margin: 2rem 0 0.5rem; font-size: 1.15rem; }
h4 { margin: 1.5rem 0 0.25rem; font-size: 1rem; }
p, li { max-width: 75ch; }
a { color: inherit; text-decoration-color: var(--faint); text-underline-offset: 0.2em; }
dl.facts { display: grid; grid-template-columns: max-content 1fr; gap: 0.15rem 1rem; margin: 1rem 0; font-size: 0.9rem; }
dl.facts dt { color: var(--faint); } dl.facts dd { margin: 0; overflow-wrap: anywhere; }
nav { columns: 24rem 2; margin: 1rem 0; } nav p { margin: 0; break-after: avoid; }
nav ul { margin: 0.25rem 0 0.75rem; padding-left: 1.25rem; }
.notice, .missing { border-left: 3px solid var(--faint); background: var(--tint); padding: 0.5rem 0.75rem; max-width: none; }
details { margin: 0.75rem 0; } summary { color: var(--faint); cursor: pointer; font-size: 0.875rem; }
section { overflow-wrap: break-word; }
@media (max-width: 640px) {
  dl.facts { grid-template-columns: 1fr; gap: 0; } dl.facts dd { margin-bottom: 0.4rem; }
}
@media print {
  :root { --ink: #000; --paper: #fff; --faint: #444; --rule: #bbb; --tint: #f3f3f3; }
  body { max-width: none; font-size: 10pt; } nav, details { display: none; }
  figure, tr { break-inside: avoid; } h2, h3, h4, h4 + p { break-after: avoid; }
  figure svg { max-height: 11cm; } .scroll { overflow: visible; } .scroll table { font-size: 6.5pt; }
  .scroll th, .scroll td { padding: 1pt 3pt; }
}
)";

std::string facts_list(const Facts& facts) {
  std::string out = "<dl class=\"facts\">\n";
  for (const auto& [name, text] : facts) out += "<dt>" + escaped(name) + "</dt><dd>" + escaped(text) + "</dd>\n";
  return out + "</dl>\n";
}

std::string contents(const std::vector<Part>& parts) {
  std::string out = "<nav aria-label=\"Contents\">\n", chapter;
  for (const Part& part : parts) {
    if (part.chapter != chapter) {
      out += (chapter.empty() ? "" : "</ul>\n") + ("<p>" + escaped(part.chapter) + "</p>\n<ul>\n");
      chapter = part.chapter;
    }
    for (const Section& s : part.sections) {
      out += "<li><a href=\"#" + escaped(s.id) + "\">" + escaped(s.title) + "</a></li>\n";
    }
    if (part.sections.empty()) out += "<li class=\"faint\">" + escaped(part.title) + ": missing</li>\n";
  }
  return out + (chapter.empty() ? "" : "</ul>\n") + "</nav>\n";
}

std::string numbers(const Section& section) {
  const std::vector<Measurement>& all = section.measurements;
  if (all.empty()) return "";
  std::string out = "<details><summary>All numbers of this section with their origin (" + output::grouped(all.size()) +
                    ")</summary>\n" + html(table_of(all, kMostRows));
  if (all.size() > kMostRows) out += paragraph("The rest is in report.csv.", "faint");
  return out + "</details>\n";
}

std::string html_of(const Section& section) {
  return "<section id=\"" + escaped(section.id) + "\">\n<h3>" + escaped(section.title) + "</h3>\n" + section.body +
         numbers(section) + "</section>\n";
}

}  // namespace

std::string page(const PageHead& head, const std::vector<Part>& parts) {
  const std::string title = "assur: benchmark report";
  std::string body = "<h1>" + title + "</h1>\n" + facts_list(head.facts);
  if (!head.state.empty()) body += paragraph(head.state, "faint");
  if (!head.notice.empty()) body += paragraph(head.notice, "notice");
  body += contents(parts);
  std::string chapter;
  for (const Part& part : parts) {
    if (part.chapter != chapter) body += "<h2>" + escaped(part.chapter) + "</h2>\n";
    chapter = part.chapter;
    for (const Section& section : part.sections) body += html_of(section);
    if (!part.missing.empty()) body += paragraph(part.title + ": " + part.missing, "missing");
  }
  body += paragraph(
      "All numbers are in report.csv, with strategy, repetitions, spread and error, and in report.json in the format "
      "of "
      "Google Benchmark. Times are medians; a spread is the median absolute deviation over the median.",
      "faint");
  return pictures::html_page(title, std::string(pictures::plot_style()) + std::string(kStyle), body);
}

}  // namespace assur::report
