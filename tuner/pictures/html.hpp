// Pages that need nothing but themselves.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace assur::pictures {

// With &, <, > and quotes as HTML and SVG want them.
[[nodiscard]] std::string escaped(std::string_view text);

struct HtmlTable {
  enum class Column : std::uint8_t { text, number, words };  // numbers stand to the right; only words are broken

  std::vector<std::string> titles;
  std::vector<Column> columns;  // as many as titles
  struct Row {
    std::vector<std::string> cells;
    std::string css_class = {};
  };
  std::vector<Row> rows;
};
[[nodiscard]] std::string html(const HtmlTable& table);

// The whole page, light and dark; `style`: of what the body has beyond text and tables.
[[nodiscard]] std::string html_page(std::string_view title, std::string_view style, std::string_view body);

}  // namespace assur::pictures
