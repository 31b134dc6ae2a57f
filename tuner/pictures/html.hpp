// Self-contained HTML pages.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace assur::pictures {

// The text with &, <, > and quotes escaped for HTML and SVG.
[[nodiscard]] std::string escaped(std::string_view text);

struct HtmlTable {
  enum class Column : std::uint8_t { text, number, words };  // numbers are aligned right; only words are wrapped

  std::vector<std::string> titles;
  std::vector<Column> columns;  // as many as titles
  struct Row {
    std::vector<std::string> cells;
    std::string css_class = {};
  };
  std::vector<Row> rows;
};
[[nodiscard]] std::string html(const HtmlTable& table, std::string_view css_class = {});

// A column of a table with a row for each of several things.
template <class Thing>
struct ColumnOf {
  std::string title;
  HtmlTable::Column kind;
  std::function<std::string(const Thing&)> cell;
};
template <class Thing>
[[nodiscard]] HtmlTable table_of(const std::vector<Thing>& things, const std::vector<ColumnOf<Thing>>& columns) {
  HtmlTable table;
  for (const ColumnOf<Thing>& column : columns) {
    table.titles.push_back(column.title);
    table.columns.push_back(column.kind);
  }
  for (const Thing& thing : things) {
    HtmlTable::Row& row = table.rows.emplace_back();
    for (const ColumnOf<Thing>& column : columns) row.cells.push_back(column.cell(thing));
  }
  return table;
}

// "<p>text</p>", escaped; each of several texts has its own line.
[[nodiscard]] std::string paragraph(const std::vector<std::string>& lines, std::string_view css_class = {});
[[nodiscard]] inline std::string paragraph(const std::string& text, std::string_view css_class = {}) {
  return paragraph(std::vector{text}, css_class);
}

// The whole page in light and dark colours; `style`: CSS for elements other than text and tables.
[[nodiscard]] std::string html_page(std::string_view title, std::string_view style, std::string_view body);

}  // namespace assur::pictures
