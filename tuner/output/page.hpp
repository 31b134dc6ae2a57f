// Pages of text for people. Facts with a label use 80 columns, or the width of a narrower terminal; tables use the
// width of the terminal.
#pragma once

#include <ostream>
#include <string>
#include <string_view>
#include <vector>

namespace assur::output {

// Width of the terminal that a standard stream writes to; 0 if there is none.
[[nodiscard]] std::size_t terminal_columns(const std::ostream& out);

// Rows of aligned columns, two spaces between them.
class Table {
 public:
  enum class Align { left, right };

  explicit Table(std::vector<Align> columns) : columns_(std::move(columns)) {}

  // Adds a row with a cell for each column.
  Table& row(std::vector<std::string> cells) {
    rows_.push_back(std::move(cells));
    return *this;
  }
  [[nodiscard]] bool empty() const { return rows_.empty(); }

  // Prints each line after `indent` spaces, without trailing spaces. room: width in columns, 0: unlimited. Cells that
  // do not fit go on in the next line, the last one in several lines if needed.
  void print(std::ostream& out, std::size_t indent, std::size_t room = 0) const;

 private:
  std::vector<Align> columns_;
  std::vector<std::vector<std::string>> rows_;
};

class Page {
 public:
  explicit Page(std::ostream& out) : Page(out, terminal_columns(out)) {}
  Page(std::ostream& out, std::size_t columns) : out_(out), columns_(columns) {}  // columns: width, 0: unlimited

  void title(std::string_view text);
  void gap() { out_ << '\n'; }

  // Prints "  label           text", with the text wrapped. An empty label continues the fact above.
  void fact(std::string_view label, std::string_view text);

  // Prints each text as a fact, with one label; texts beyond kMostListed are only counted.
  void list(std::string_view label, const std::vector<std::string>& texts);

  void table(const Table& table);

  static constexpr std::size_t kMostListed = 12;

 private:
  // Columns for text from this column on.
  [[nodiscard]] std::size_t room(std::size_t column) const;

  std::ostream& out_;
  std::size_t columns_;
};

}  // namespace assur::output
