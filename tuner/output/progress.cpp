#include "output/progress.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <string>

#include "output/format.hpp"

namespace assur::output {
namespace {

constexpr double kRedraw = 0.1;  // s between two updates of the bar
constexpr double kLine = 5;      // s between two lines
constexpr int kBarWidth = 30;    // columns
constexpr std::string_view kEraseLine = "\r\x1b[K";

std::string bar(double share) {
  const int full = static_cast<int>(share * kBarWidth);
  std::string text;
  for (int i = 0; i < kBarWidth; ++i) text += i < full ? "━" : "╌";
  return text;
}

// "3 s", "12 min", "2.5 h"
std::string roughly(double seconds) {
  if (seconds < 90) return number(std::ceil(seconds)) + " s";
  if (seconds < 5400) return number(std::round(seconds / 60)) + " min";
  return number(std::round(seconds / 360) / 10) + " h";
}

}  // namespace

Progress::Style Progress::style_of_standard_error() {
  const char* const terminal = std::getenv("TERM");
  const bool redraws = terminal == nullptr || (*terminal != '\0' && std::string_view(terminal) != "dumb");
  return isatty(STDERR_FILENO) == 1 && redraws ? Style::bar : Style::lines;
}

Progress::Progress(bool quiet, std::string_view noun)
    : Progress(std::cerr, quiet ? Style::none : style_of_standard_error(), noun) {}

void Progress::print(double seconds, std::int64_t done, std::int64_t of) {
  const double share = of > 0 ? static_cast<double>(done) / static_cast<double>(of) : 1;
  std::string text = grouped(done) + " of " + counted(of, noun_);
  if (done > 0 && done < of) text += ", about " + roughly(seconds / share - seconds) + " left";
  const std::string percent = number(std::floor(100 * share)) + " %";
  if (style_ == Style::bar) {
    // A wrapped line cannot be erased; a narrow terminal gets a cut line without the bar.
    std::string line = percent + "  " + text;
    const std::size_t room = columns_ > 0 ? columns_ - 1 : std::string::npos;
    if (line.size() + kBarWidth + 4 <= room) {
      line = "  " + bar(share) + "  " + line;
    } else {
      line.resize(std::min(line.size(), room));
    }
    out_ << kEraseLine << line << std::flush;
    drawn_ = true;
  } else {
    out_ << percent << ", " << text << std::endl;
  }
  due_ = seconds + (style_ == Style::bar ? kRedraw : kLine);
}

void Progress::clear() {
  if (drawn_) out_ << kEraseLine << std::flush;
  drawn_ = false;
}

}  // namespace assur::output
