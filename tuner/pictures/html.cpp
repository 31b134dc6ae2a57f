#include "pictures/html.hpp"

#include <array>

namespace assur::pictures {
namespace {

constexpr std::string_view kStyle = R"(
:root { color-scheme: light dark; --ink: #1b1f24; --paper: #ffffff; --faint: #59636e; --rule: #d5dae0; --tint: #f3f6f9;
        --c0: #0068a5; --c1: #b36b00; --c2: #00805d; --c3: #b0508a; --c4: #c44f00; --c5: #5b5fc7; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e6e9ed; --paper: #14181d; --faint: #9aa5b1; --rule: #343b44; --tint: #1d232a;
          --c0: #58b0ea; --c1: #f0b34a; --c2: #3ccca0; --c3: #eb9cc8; --c4: #ff8e4d; --c5: #a5a8ff; }
}
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 1240px; padding: 1rem; background: var(--paper); color: var(--ink);
       font: 16px/1.5 system-ui, sans-serif; }
h1 { font-size: 1.5rem; line-height: 1.25; margin: 0.5rem 0; }
h2 { font-size: 1.15rem; margin: 2rem 0 0.5rem; }
p { margin: 0.5rem 0; }
.faint { color: var(--faint); }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-size: 0.875rem; font-variant-numeric: tabular-nums; }
th, td { vertical-align: top; white-space: nowrap; padding: 0.2rem 0.75rem 0.2rem 0; text-align: left; border-bottom: 1px solid var(--rule); }
.small table { font-size: 0.75rem; }
.tall th { white-space: normal; min-width: 4.5rem; vertical-align: bottom; }
th { color: var(--faint); font-weight: 600; }
th.number, td.number { text-align: right; }
th.words, td.words { white-space: normal; min-width: 7rem; }
@media (min-width: 641px) { td:not([class]) { white-space: normal; } }
.legend { list-style: none; display: flex; flex-wrap: wrap; gap: 0.25rem 1.25rem; margin: 0.5rem 0; padding: 0;
          font-size: 0.875rem; }
tr.strong td { background: var(--tint); font-weight: 600; }
)";

constexpr std::array<std::string_view, 3> kClasses = {"", " class=\"number\"", " class=\"words\""};  // of columns

// Allows line breaks after these characters.
std::string breakable(const std::string& text, std::string_view behind) {
  std::string out;
  for (const char c : text) {
    out += c;
    if (behind.find(c) != std::string_view::npos) out += "<wbr>";
  }
  return out;
}

std::string row(const HtmlTable& table, const HtmlTable::Row& row, std::string_view element) {
  std::string out = row.css_class.empty() ? "<tr>" : "<tr class=\"" + row.css_class + "\">";
  for (std::size_t c = 0; c < row.cells.size(); ++c) {
    out.append("<").append(element).append(kClasses[static_cast<std::size_t>(table.columns[c])]).append(">");
    const std::string_view behind = element == "th" ? "+/" : "+";
    out.append(breakable(escaped(row.cells[c]), behind)).append("</").append(element).append(">");
  }
  return out + "</tr>\n";
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const std::string_view name = c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '"' ? "&quot;" : "";
    out += name.empty() ? std::string_view(&c, 1) : name;
  }
  return out;
}

std::string html(const HtmlTable& table, std::string_view css_class) {
  std::string out = "<div class=\"scroll";
  if (!css_class.empty()) out.append(" ").append(css_class);
  out += "\"><table>\n<thead>" + row(table, {table.titles}, "th") + "</thead>\n<tbody>\n";
  for (const HtmlTable::Row& r : table.rows) out += row(table, r, "td");
  return out + "</tbody></table></div>\n";
}

std::string paragraph(const std::vector<std::string>& lines, std::string_view css_class) {
  std::string out = "<p";
  if (!css_class.empty()) out.append(" class=\"").append(css_class).append("\"");
  for (std::size_t i = 0; i < lines.size(); ++i) out.append(i == 0 ? ">" : "<br>").append(escaped(lines[i]));
  return out.append(lines.empty() ? ">" : "").append("</p>\n");
}

std::string html_page(std::string_view title, std::string_view style, std::string_view body) {
  std::string out = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n";
  out += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n";
  out.append("<title>").append(escaped(title)).append("</title>\n<style>").append(kStyle).append(style);
  return out.append("</style>\n</head>\n<body>\n").append(body).append("</body>\n</html>\n");
}

}  // namespace assur::pictures
