#include "output/page.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <iostream>

#include "output/format.hpp"

namespace assur::output {
namespace {

constexpr std::size_t kIndent = 2;
constexpr std::size_t kLabel = 16;      // columns of the label and the space after it
constexpr std::size_t kLeastText = 20;  // columns; a narrower terminal wraps the lines itself

std::string spaces(std::size_t count) { return std::string(count, ' '); }

}  // namespace

std::size_t terminal_columns(const std::ostream& out) {
  winsize size{};
  const bool error = out.rdbuf() == std::cerr.rdbuf();
  if (!error && out.rdbuf() != std::cout.rdbuf()) return 0;
  return ioctl(error ? STDERR_FILENO : STDOUT_FILENO, TIOCGWINSZ, &size) == 0 ? size.ws_col : 0;
}

void Table::print(std::ostream& out, std::size_t indent, std::size_t room) const {
  std::vector<std::size_t> width(columns_.size(), 0);
  for (const auto& cells : rows_) {
    for (std::size_t c = 0; c < cells.size(); ++c) width[c] = std::max(width[c], display_width(cells[c]));
  }
  for (const auto& cells : rows_) {
    std::string line = spaces(indent);
    const auto end_line = [&] {
      line.erase(line.find_last_not_of(' ') + 1);
      out << line << '\n';
    };
    std::size_t end = cells.size();
    while (end > 0 && cells[end - 1].empty()) --end;
    for (std::size_t c = 0; c < end; ++c) {
      const std::string padding = spaces(width[c] - display_width(cells[c]));
      std::string cell = columns_[c] == Align::right ? padding + cells[c] : cells[c];
      if (room > 0 && c > 0 && display_width(line) + display_width(cell) > room) {
        end_line();
        line = spaces(2 * indent);
        if (c + 1 == end) {
          std::vector<std::string> parts = wrapped(cell, std::max(room, 2 * indent + kLeastText) - 2 * indent);
          cell = std::move(parts.back());
          parts.pop_back();
          for (const std::string& part : parts) out << line << part << '\n';
        }
      }
      if (columns_[c] == Align::left) cell += padding;
      line += cell + "  ";
    }
    end_line();
  }
}

std::size_t Page::room(std::size_t column) const {
  const std::size_t all = columns_ > 0 ? std::min(columns_, kPageWidth) : kPageWidth;
  return std::max(all, column + kLeastText) - column;
}

void Page::title(std::string_view text) {
  for (const std::string& line : wrapped(text, room(0))) out_ << line << '\n';
}

void Page::fact(std::string_view label, std::string_view text) {
  std::string front = spaces(kIndent) + std::string(label);
  front += spaces(std::max(kIndent + kLabel, display_width(front) + 1) - display_width(front));
  for (const std::string& line : wrapped(text, room(kIndent + kLabel))) {
    out_ << front << line << '\n';
    front = spaces(kIndent + kLabel);
  }
}

void Page::list(std::string_view label, const std::vector<std::string>& texts) {
  for (std::size_t i = 0; i < std::min(texts.size(), kMostListed); ++i) fact(i == 0 ? label : "", texts[i]);
  if (texts.size() > kMostListed) {
    fact("", "and " + grouped(texts.size() - kMostListed) + " more");
  }
}

void Page::table(const Table& table) { table.print(out_, kIndent, columns_); }

}  // namespace assur::output
