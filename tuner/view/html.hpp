// Pages that need nothing but themselves.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace assur::view {

// With &, <, > and quotes as HTML and SVG want them.
[[nodiscard]] std::string escaped(std::string_view text);

// Rows of cells, which are texts; the first row are titles. Columns of numbers stand to the right.
struct HtmlTable {
  std::vector<std::string> titles;
  std::vector<bool> is_number;  // columns
  struct Row {
    std::vector<std::string> cells;
    std::string css_class = {};
  };
  std::vector<Row> rows;
};
[[nodiscard]] std::string html(const HtmlTable& table);

// The whole page, light and dark; `style`: of what the body has beyond text and tables.
[[nodiscard]] std::string html_page(std::string_view title, std::string_view style, std::string_view body);

}  // namespace assur::view
