#include "report/paper/cells.hpp"

#include <cmath>

#include "assur/status.hpp"
#include "decimal.hpp"

namespace assur::report {
namespace {

bool matches(const PaperTiming& t, const PaperCell& cell, std::string_view version, Reading reading) {
  return t.timed() && t.version == version && t.reading == reading && t.cell.same_work(cell);
}

}  // namespace

std::string PaperCell::scene() const {
  if (n == 15 && terminal == 12) return groups == 6 ? "stewart" : "stewart:legs=" + std::to_string(groups);
  return "rings:legs=" + std::to_string(groups) + ",n=" + std::to_string(n) + ",terminal=" + std::to_string(terminal);
}

std::vector<PaperCell> cells_of_table(int table) {
  std::vector<PaperCell> cells;
  const auto terminal = [](int n) { return n == 15 ? 12 : 24; };
  switch (table) {
    case 2:
      for (const int n : {15, 30, 60, 120, 240, 360, 480, 720}) cells.push_back({6, n, terminal(n), 20000, 1});
      return cells;
    case 3:
      for (const int groups : {6, 16, 22}) {
        for (const int n : {15, 30, 60, 120}) cells.push_back({groups, n, terminal(n), 20000, 1});
      }
      return cells;
    case 4:
      for (int t = 12; t <= 96; t += 12) cells.push_back({6, t + t / 2, t, 300, 20});
      return cells;
    case 5:
      for (int t = 12; t <= 72; t += 12) cells.push_back({6, t + t / 2, t, 10, 10});
      for (const int n : {400, 600, 800, 1000, 2000, 3000, 4000}) cells.push_back({6, n, n, 10, 10});
      return cells;
    default:
      throw Error(Error::Kind::input, "the paper's tables with cells are 2, 3, 4 and 5, not " + std::to_string(table));
  }
}

const PaperTiming* fastest(std::span<const PaperTiming> times, const PaperCell& cell, std::string_view version,
                           Reading reading) {
  const PaperTiming* best = nullptr;
  for (const PaperTiming& t : times) {
    if (matches(t, cell, version, reading) && (best == nullptr || t.seconds < best->seconds)) best = &t;
  }
  return best;
}

const PaperTiming* timing(std::span<const PaperTiming> times, const PaperCell& cell, std::string_view version, int p,
                          int q, Reading reading) {
  const PaperTiming* best = nullptr;
  for (const PaperTiming& t : times) {
    const bool it = matches(t, cell, version, reading) && t.p == p && t.q == q;
    if (it && (best == nullptr || t.seconds < best->seconds)) best = &t;
  }
  return best;
}

std::string split_text(const PaperTiming& timing) { return std::to_string(timing.p) + "x" + std::to_string(timing.q); }

std::string ratio_text(double ratio) {
  if (ratio < 0.0995) return fixed(ratio, ratio > 0 ? 1 - static_cast<int>(std::floor(std::log10(ratio))) : 2);
  return fixed(ratio, ratio < 0.9995 ? 3 : ratio < 9.995 ? 2 : ratio < 99.95 ? 1 : 0);
}

}  // namespace assur::report
