#include "output/page.hpp"

#include <algorithm>

#include "output/format.hpp"

namespace assur::output {
namespace {

constexpr std::size_t kIndent = 2;
constexpr std::size_t kLabel = 16;  // columns of the label and the space behind it

std::string spaces(std::size_t count) { return std::string(count, ' '); }

}  // namespace

void Table::print(std::ostream& out, std::size_t indent) const {
  std::vector<std::size_t> width(columns_.size(), 0);
  for (const auto& cells : rows_) {
    for (std::size_t c = 0; c < cells.size(); ++c) width[c] = std::max(width[c], display_width(cells[c]));
  }
  for (const auto& cells : rows_) {
    std::string line = spaces(indent);
    for (std::size_t c = 0; c < cells.size(); ++c) {
      const std::string padding = spaces(width[c] - display_width(cells[c]));
      line += columns_[c] == Align::right ? padding + cells[c] : cells[c] + padding;
      line += "  ";
    }
    line.erase(line.find_last_not_of(' ') + 1);
    out << line << '\n';
  }
}

void Page::title(std::string_view text) {
  for (const std::string& line : wrapped(text, kPageWidth)) out_ << line << '\n';
}

void Page::fact(std::string_view label, std::string_view text) {
  std::string front = spaces(kIndent) + std::string(label);
  front += spaces(std::max(kIndent + kLabel, display_width(front) + 1) - display_width(front));
  for (const std::string& line : wrapped(text, kPageWidth - kIndent - kLabel)) {
    out_ << front << line << '\n';
    front = spaces(kIndent + kLabel);
  }
}

void Page::list(std::string_view label, const std::vector<std::string>& texts) {
  for (std::size_t i = 0; i < std::min(texts.size(), kMostListed); ++i) fact(i == 0 ? label : "", texts[i]);
  if (texts.size() > kMostListed) {
    fact("", "and " + grouped(static_cast<std::int64_t>(texts.size() - kMostListed)) + " more");
  }
}

void Page::table(const Table& table) { table.print(out_, kIndent); }

}  // namespace assur::output
