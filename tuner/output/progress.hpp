// Progress of a long run on standard error: a bar on a terminal, else a line now and then.
#pragma once

#include <cstdint>
#include <ostream>
#include <string_view>

#include "output/page.hpp"

namespace assur::output {

class Progress {
 public:
  enum class Style : std::uint8_t { none, lines, bar };

  // bar if standard error is a terminal that can redraw a line, else lines.
  [[nodiscard]] static Style style_of_standard_error();

  // noun: name of the counted things, a literal. columns: width of the bar with its text, 0: unlimited.
  Progress(std::ostream& out, Style style, std::string_view noun, std::size_t columns)
      : out_(out), style_(style), noun_(noun), columns_(columns) {}
  Progress(std::ostream& out, Style style, std::string_view noun = "step")
      : Progress(out, style, noun, terminal_columns(out)) {}
  // On standard error.
  explicit Progress(bool quiet, std::string_view noun = "step");
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress() { clear(); }

  // Shows `done` of `of` after `seconds`. Prints nothing in the first second, and rarely afterwards.
  void show(double seconds, std::int64_t done, std::int64_t of) {
    if (seconds >= due_ && style_ != Style::none) print(seconds, done, of);
  }

  // Removes the bar.
  void clear();

 private:
  void print(double seconds, std::int64_t done, std::int64_t of);

  std::ostream& out_;
  Style style_;
  std::string_view noun_;
  std::size_t columns_;
  double due_ = 1;  // s: a shorter run needs no progress
  bool drawn_ = false;
};

}  // namespace assur::output
