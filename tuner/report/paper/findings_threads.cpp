#include <algorithm>
#include <cmath>
#include <vector>

#include "report/paper/findings.hpp"

namespace assur::report {
namespace {

Finding needs_threads(int threads) { return {std::nullopt, "takes " + std::to_string(threads) + " threads at least"}; }

// Time of one thread over that of groups side by side.
double speed_up(Times times, const PaperCell& cell, std::string_view version) {
  double several = std::nan("");
  for (const PaperTiming& t : times) {
    const bool it = t.timed() && t.version == version && t.reading == Reading::shared && t.p > 1 && t.q == 1;
    if (it && t.cell.same_work(cell)) several = std::fmin(several, t.seconds);
  }
  const PaperTiming* const one = timing(times, cell, version, 1, 1);
  return one == nullptr ? std::nan("") : one->seconds / several;
}

}  // namespace

Finding openmp_beats_mkl(const Source& s) {
  if (s.threads < 2) return needs_threads(2);
  const std::vector<PaperCell> cells = cells_of_table(2);
  std::vector<std::string> ahead_by_openmp, ahead_by_mkl;
  bool holds = true;
  for (const PaperCell& cell : cells) {
    double openmp = std::nan(""), mkl = std::nan("");
    for (const PaperTiming& t : s.table_2) {
      if (!t.timed() || t.version != kDense || t.reading != Reading::shared || !t.cell.same_work(cell)) continue;
      if (t.p > 1 && t.q == 1) openmp = std::fmin(openmp, t.seconds);
      if (t.q > 1 && t.p == 1) mkl = std::fmin(mkl, t.seconds);
    }
    if (std::isnan(openmp) && std::isnan(mkl)) continue;
    const bool by_openmp = std::isnan(mkl) || openmp < mkl;  // of the paper only the faster one is known
    (by_openmp ? ahead_by_openmp : ahead_by_mkl).push_back(std::to_string(cell.total()));
    holds = holds && by_openmp == (cell != cells.back());
  }
  if (ahead_by_openmp.empty() && ahead_by_mkl.empty()) return not_run();
  const auto list = [](const std::vector<std::string>& of) {
    std::string text;
    for (const std::string& size : of) text += (text.empty() ? "" : ", ") + size;
    return text.empty() ? "no size" : text;
  };
  return {holds, "OpenMP is ahead at " + list(ahead_by_openmp) + "; MKL at " + list(ahead_by_mkl)};
}

Finding three_threads(const Source& s) {
  if (s.threads < 4) return needs_threads(4);
  int three = 0, all = 0;
  for (const PaperCell& cell : cells_of_table(2)) {
    for (const std::string_view version : {kDense, kSparse}) {
      const PaperTiming* const t = fastest(s.table_2, cell, version);
      if (t == nullptr) continue;
      ++all;
      three += t->p == 3 && t->q == 1 ? 1 : 0;
    }
  }
  if (all == 0) return not_run();
  return {2 * three > all,
          "3x1 is the fastest split in " + std::to_string(three) + " of " + std::to_string(all) + " cells"};
}

Finding parallelism_grows(const Source& s) {
  if (s.threads < 2) return needs_threads(2);
  std::string numbers;
  bool holds = true, known = false;
  for (const std::string_view version : {kDense, kSparse}) {
    Range range;
    int cells = 0;
    double first = std::nan(""), last = std::nan("");
    for (const PaperCell& cell : cells_of_table(3)) {
      const double ratio = speed_up(s.table_3, cell, version);
      if (std::isnan(ratio)) continue;
      ++cells;
      range.add(ratio);
      if (std::isnan(first)) first = ratio;
      last = ratio;
    }
    if (cells < 2) continue;
    known = true;
    holds = holds && range.least > 1 && last > first;
    numbers += (numbers.empty() ? "" : "; ") + std::string(version) + ": " + range.text() + " times as fast as one " +
               "thread, from " + ratio_text(first) + " in the smallest to " + ratio_text(last) + " in the largest";
  }
  if (!known) return not_run();
  return {holds, numbers};
}

Finding hybrid_for_large(const Source& s) {
  if (s.threads < 4) return needs_threads(4);
  const PaperTiming *small = nullptr, *large = nullptr;
  for (const PaperCell& cell : cells_of_table(2)) {
    const PaperTiming* const t = fastest(s.table_2, cell, kDense);
    if (t == nullptr) continue;
    if (small == nullptr) small = t;
    large = t;
  }
  if (small == nullptr || small == large) return not_run();
  return {small->p > 1 && small->q == 1 && large->p > 1 && large->q > 1,
          "fastest splits: " + split_text(*small) + " at " + total(small->cell) + ", " + split_text(*large) + " at " +
              total(large->cell)};
}

// 6x2 over 2x6 in the smallest and the largest cell that has both.
Finding wide_for_small_narrow_for_large(const Source& s) {
  if (s.threads < 6) return needs_threads(6);
  double first = std::nan(""), last = std::nan("");
  PaperCell largest_cell;
  for (const PaperCell& cell : cells_of_table(5)) {
    double wide = std::nan(""), narrow = std::nan("");
    for (const PaperTiming& t : s.table_5) {
      if (!t.timed() || t.version != kDense || t.reading != Reading::shared || !t.cell.same_work(cell)) continue;
      if (t.q == 2 && t.p > 2) wide = t.seconds;
      if (t.p == 2 && t.q > 2) narrow = t.seconds;
    }
    if (std::isnan(wide / narrow)) continue;
    if (std::isnan(first)) first = wide / narrow;
    last = wide / narrow;
    largest_cell = cell;
  }
  if (std::isnan(last) || largest_cell.n < 400) return not_run();
  return {first < 1 && last > 1, "time of many groups at once over many threads in each: " + ratio_text(first) +
                                     " at n = 18, " + ratio_text(last) + " at n = " + std::to_string(largest_cell.n)};
}

Finding gpu_for_large_only(const Source& s) {
  const std::vector<PaperCell> cells = cells_of_table(5);
  const auto ratio = [&](const PaperCell& c) { return best(s.table_5, c, "GEMAGMA") / best(s.table_5, c, kDense); };
  if (std::isnan(ratio(cells.front()) + ratio(cells.back()))) return {std::nullopt, "no GPU here"};
  return {ratio(cells.front()) > 1 && ratio(cells.front()) > ratio(cells.back()),
          "MAGMA takes " + ratio_text(ratio(cells.front())) + " times as long as the CPU at n = 18, " +
              ratio_text(ratio(cells.back())) + " times at n = 4000"};
}

}  // namespace assur::report
