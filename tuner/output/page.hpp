// A page of text for people: facts with a label, in 80 columns or those of a narrower terminal; tables as wide as it.
#pragma once

#include <ostream>
#include <string>
#include <string_view>
#include <vector>

namespace assur::output {

// Of the terminal that a standard stream writes to; 0 if it writes to none.
[[nodiscard]] std::size_t terminal_columns(const std::ostream& out);

// Rows of aligned columns, two spaces between them.
class Table {
 public:
  enum class Align { left, right };

  explicit Table(std::vector<Align> columns) : columns_(std::move(columns)) {}

  // As many cells as columns.
  Table& row(std::vector<std::string> cells) {
    rows_.push_back(std::move(cells));
    return *this;
  }
  [[nodiscard]] bool empty() const { return rows_.empty(); }

  // Each line with `indent` spaces in front and none behind. room: columns, 0: any number; cells that find no more of
  // it go on in a line below, the last one in several if need be.
  void print(std::ostream& out, std::size_t indent, std::size_t room = 0) const;

 private:
  std::vector<Align> columns_;
  std::vector<std::vector<std::string>> rows_;
};

class Page {
 public:
  explicit Page(std::ostream& out) : Page(out, terminal_columns(out)) {}
  Page(std::ostream& out, std::size_t columns) : out_(out), columns_(columns) {}  // 0: any number

  void title(std::string_view text);
  void gap() { out_ << '\n'; }

  // "  label           text", the text wrapped under itself. An empty label continues the fact above.
  void fact(std::string_view label, std::string_view text);

  // Each text as a fact, the label once; what goes beyond kMostListed is counted.
  void list(std::string_view label, const std::vector<std::string>& texts);

  void table(const Table& table);

  static constexpr std::size_t kMostListed = 12;

 private:
  // Those that text has from this one on.
  [[nodiscard]] std::size_t room(std::size_t column) const;

  std::ostream& out_;
  std::size_t columns_;
};

}  // namespace assur::output
