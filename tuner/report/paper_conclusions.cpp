#include "report/paper_conclusions.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <set>

#include "report/paper_figures.hpp"

namespace assur::report {
namespace {

using Times = std::span<const PaperTiming>;

// Times to ask: those of the paper are kept table by table, for two of its tables have cells in common.
struct Source {
  Times table_2, table_3, table_5;
  int threads;
};

struct Finding {
  std::optional<bool> holds;  // empty: cannot be told
  std::string numbers;        // or why it cannot
};

constexpr std::string_view kDense = "GEOMP+MKL", kSparse = "GEOMP+MA27";
constexpr double kAsFast = 1.05;  // times that are so near each other count as equal

double seconds(const PaperTiming* t) { return t == nullptr ? std::nan("") : t->seconds; }
double best(Times times, const PaperCell& cell, std::string_view version) {
  return seconds(fastest(times, cell, version));
}
double best_of_groups(Times times, const PaperCell& cell) {
  return std::fmin(best(times, cell, kDense), best(times, cell, kSparse));
}
double best_of_global(Times times, const PaperCell& cell) {
  return std::fmin(best(times, cell, "GMKL"), best(times, cell, "GMA27"));
}

struct Range {
  double least = HUGE_VAL, most = 0;
  void add(double value) {
    if (std::isnan(value)) return;
    least = std::min(least, value);
    most = std::max(most, value);
  }
  [[nodiscard]] bool empty() const { return most == 0; }
  [[nodiscard]] std::string text() const {
    return least == most ? ratio_text(least) : ratio_text(least) + " to " + ratio_text(most);
  }
};

const Finding kNothing{std::nullopt, "not run"};

Finding needs_threads(int threads) { return {std::nullopt, "takes " + std::to_string(threads) + " threads at least"}; }

// The last cell of table 2 for which both have a time.
std::optional<PaperCell> largest(Times times, std::string_view a, std::string_view b) {
  std::optional<PaperCell> last;
  for (const PaperCell& cell : cells_of_table(2)) {
    if (!std::isnan(best(times, cell, a) + best(times, cell, b))) last = cell;
  }
  return last;
}

std::string total(const PaperCell& cell) { return "total size " + std::to_string(cell.total()); }

// ---- 5.1

Finding dense_for_the_case_study(const Source& s) {
  const PaperCell cell = cells_of_table(2)[0];
  const double ratio = best(s.table_2, cell, "GMA27") / best(s.table_2, cell, "GMKL");
  if (std::isnan(ratio)) return kNothing;
  return {ratio > 1, "GMKL is " + ratio_text(ratio) + " times as fast as GMA27 at " + total(cell)};
}

Finding sparse_for_large(const Source& s) {
  const PaperCell first = cells_of_table(2)[0];
  const std::optional<PaperCell> last = largest(s.table_2, "GMKL", "GMA27");
  if (!last || last->total() < 2 * first.total()) return kNothing;
  const auto exponent = [&](std::string_view version) {
    return std::log(best(s.table_2, *last, version) / best(s.table_2, first, version)) /
           std::log(static_cast<double>(last->total()) / first.total());
  };
  const double ratio = best(s.table_2, *last, "GMKL") / best(s.table_2, *last, "GMA27");
  const double dense = exponent("GMKL"), sparse = exponent("GMA27");
  if (std::isnan(ratio + dense + sparse)) return kNothing;
  return {ratio > 1 && sparse < 1.5 && dense > sparse + 0.5,
          "GMA27 is " + ratio_text(ratio) + " times as fast as GMKL at " + total(*last) + "; times grow like size^" +
              ratio_text(sparse) + " and size^" + ratio_text(dense)};
}

Finding groups_beat_global(const Source& s) {
  Range range;
  for (const PaperCell& cell : cells_of_table(2)) {
    range.add(best_of_global(s.table_2, cell) / best_of_groups(s.table_2, cell));
  }
  if (range.empty()) return kNothing;
  return {range.least > 1, "groups are " + range.text() + " times as fast as the better global version"};
}

Finding four_times_for_the_largest(const Source& s) {
  std::optional<PaperCell> last;
  double ratio = 0;
  for (const PaperCell& cell : cells_of_table(2)) {
    const double here = best_of_global(s.table_2, cell) / best_of_groups(s.table_2, cell);
    if (!std::isnan(here)) {
      last = cell;
      ratio = here;
    }
  }
  if (!last) return kNothing;
  return {std::round(ratio) >= 4, ratio_text(ratio) + " times as fast at " + total(*last)};
}

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
  if (ahead_by_openmp.empty() && ahead_by_mkl.empty()) return kNothing;
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
  if (all == 0) return kNothing;
  return {2 * three > all,
          "3x1 is the fastest split in " + std::to_string(three) + " of " + std::to_string(all) + " cells"};
}

// Time of one thread over that of groups side by side.
double speed_up(Times times, const PaperCell& cell, std::string_view version) {
  double several = std::nan("");
  for (const PaperTiming& t : times) {
    const bool it = t.timed() && t.version == version && t.reading == Reading::shared && t.p > 1 && t.q == 1;
    if (it && t.cell.same_work(cell)) several = std::fmin(several, t.seconds);
  }
  return seconds(timing(times, cell, version, 1, 1)) / several;
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
  if (!known) return kNothing;
  return {holds, numbers};
}

Finding crossover_of_sparsity(const Source& s) {
  Range at_60, at_120;
  for (const PaperCell& cell : cells_of_table(3)) {
    const double ratio = best(s.table_3, cell, kSparse) / best(s.table_3, cell, kDense);
    if (cell.n == 60) at_60.add(ratio);
    if (cell.n == 120) at_120.add(ratio);
  }
  if (at_60.empty() || at_120.empty()) return kNothing;
  return {at_60.least > 1 && at_120.most < 1,
          "time of sparse over dense: " + at_60.text() + " at n = 60, " + at_120.text() + " at n = 120"};
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
  if (small == nullptr || small == large) return kNothing;
  return {small->p > 1 && small->q == 1 && large->p > 1 && large->q > 1,
          "fastest splits: " + split_text(*small) + " at " + total(small->cell) + ", " + split_text(*large) + " at " +
              total(large->cell)};
}

// ---- 5.3

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
  if (std::isnan(last) || largest_cell.n < 400) return kNothing;
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

// ---- 6

Finding sparse_large_dense_small(const Source& s) {
  const PaperCell first = cells_of_table(2)[0];
  const std::optional<PaperCell> last = largest(s.table_2, kDense, kSparse);
  if (!last || *last == first) return kNothing;
  const auto ratio = [&](const PaperCell& c) { return best(s.table_2, c, kSparse) / best(s.table_2, c, kDense); };
  if (std::isnan(ratio(first))) return kNothing;
  return {ratio(first) > 1 && ratio(*last) < 1, "time of sparse over dense groups: " + ratio_text(ratio(first)) +
                                                    " at " + total(first) + ", " + ratio_text(ratio(*last)) + " at " +
                                                    total(*last)};
}

Finding method_depends(const Source& s) {
  std::set<std::string_view> winners;
  for (const int table : {2, 3}) {
    const Times times = table == 2 ? s.table_2 : s.table_3;
    for (const PaperCell& cell : cells_of_table(table)) {
      const double dense = best(times, cell, kDense), sparse = best(times, cell, kSparse);
      if (!std::isnan(dense + sparse)) winners.insert(dense < sparse ? kDense : kSparse);
    }
  }
  if (winners.empty()) return kNothing;
  std::string names;
  for (const std::string_view w : winners) names += (names.empty() ? "" : " and ") + std::string(w);
  return {winners.size() > 1, "fastest in some cell of tables 2 and 3: " + names};
}

Finding four_to_eight(const Source& s) {
  Range range;
  for (const PaperCell& cell : cells_of_table(2)) {
    range.add(best(s.table_2, cell, "GMA27") / best_of_groups(s.table_2, cell));
  }
  if (range.empty()) return kNothing;
  return {std::round(range.least) >= 4 && std::round(range.most) <= 8, range.text() + " times as fast as GMA27"};
}

Finding auto_is_the_fastest(const Source& s) {
  Range range;
  for (const int table : {2, 3, 4, 5}) {
    for (const PaperCell& cell : cells_of_table(table)) {
      const double theirs = std::fmin(best_of_global(s.table_2, cell), best_of_groups(s.table_2, cell));
      range.add(theirs / best(s.table_2, cell, kAuto));
    }
  }
  if (range.empty()) return {std::nullopt, "none: it is an outlook"};
  return {range.least * kAsFast >= 1,
          "auto is " + range.text() + " times as fast as the fastest of the paper's versions in the same cell"};
}

Finding no_raspberry_pi(const Source&) { return {std::nullopt, "no Raspberry Pi here"}; }

struct Rule {
  const char *where, *claim;
  Finding (*find)(const Source&);
};

constexpr std::array kRules = {
    Rule{"5.1", "Multithreading MKL is preferable to MA27 for the case study", dense_for_the_case_study},
    Rule{"5.1", "With larger matrices sparsity pays: O(n) of MA27 against O(n³) of MKL", sparse_for_large},
    Rule{"5.1, 6", "Group equations clearly outperform the global formulation", groups_beat_global},
    Rule{"5.1", "... with a speed-up of close to four for the largest", four_times_for_the_largest},
    Rule{"5.1", "OpenMP achieves more than MKL's threads from the smallest size, except for the largest",
         openmp_beats_mkl},
    Rule{"5.1", "Three OpenMP threads are best for six groups", three_threads},
    Rule{"5.1", "Parallelism pays, and more so with more groups and coordinates", parallelism_grows},
    Rule{"5.1", "Exploiting sparsity is advantageous from between 60 and 120 coordinates", crossover_of_sparsity},
    Rule{"5.1", "OpenMP alone for small problems, OpenMP and MKL together for larger ones (figure 3)",
         hybrid_for_large},
    Rule{"5.2, 6", "A Raspberry Pi is competitive for small control problems", no_raspberry_pi},
    Rule{"5.3", "OpenMP for small sizes, hybrid parallelism for medium ones", wide_for_small_narrow_for_large},
    Rule{"5.3, 6", "The GPU is for large problems only", gpu_for_large_only},
    Rule{"6", "Sparse for large matrices, dense for small ones", sparse_large_dense_small},
    Rule{"6", "The preferred method depends on the number of groups and coordinates", method_depends},
    Rule{"6", "Speed-up over the global formulation: between four and eight", four_to_eight},
    Rule{"6", "Outlook: auto-tuning should select the best strategy by itself", auto_is_the_fastest},
};

// What table 4 says of the first and the last size.
std::string raspberry_pi_of_the_paper() {
  const auto of = [](std::string_view machine, const PaperCell& cell) {
    const auto& all = paper_energies();
    return *std::find_if(all.begin(), all.end(),
                         [&](const PaperEnergy& e) { return e.machine == machine && e.cell == cell; });
  };
  const std::vector<PaperCell> cells = cells_of_table(4);
  const auto line = [&](const PaperCell& cell) {
    const PaperEnergy pi = of("RP3", cell), i5 = of("i5", cell);
    return ratio_text(pi.seconds / i5.seconds) + " times the i5's time and " + ratio_text(pi.joules / i5.joules) +
           " times its energy at n = " + std::to_string(cell.n);
  };
  return "RP3: " + line(cells.front()) + ", " + line(cells.back());
}

Verdict verdict(const Finding& finding) {
  if (!finding.holds) return Verdict::cannot_be_tested;
  return *finding.holds ? Verdict::holds : Verdict::does_not_hold;
}

Source source_of_the_paper() { return {paper_times(2), paper_times(3), paper_times(5), 12}; }

std::string numbers_of_the_paper(const Rule& rule) {
  if (rule.find == no_raspberry_pi) return raspberry_pi_of_the_paper();
  if (rule.find == hybrid_for_large) return "in figure 3 only, without numbers";
  return rule.find(source_of_the_paper()).numbers;
}

}  // namespace

std::string_view verdict_text(Verdict verdict) noexcept {
  switch (verdict) {
    case Verdict::holds:
      return "holds here";
    case Verdict::does_not_hold:
      return "does not hold here";
    case Verdict::cannot_be_tested:
      break;
  }
  return "cannot be tested here";
}

std::string ratio_text(double ratio) {
  std::array<char, 32> out{};
  const char* const format = ratio < 0.0995   ? "%#.2g"
                             : ratio < 0.9995 ? "%.3f"
                             : ratio < 9.995  ? "%.2f"
                             : ratio < 99.95  ? "%.1f"
                                              : "%.0f";
  std::snprintf(out.data(), out.size(), format, ratio);
  return out.data();
}

std::vector<Conclusion> conclusions(std::span<const PaperTiming> times, int threads) {
  std::vector<Conclusion> out;
  for (const Rule& rule : kRules) {
    const Finding finding = rule.find({times, times, times, threads});
    out.push_back({rule.where, rule.claim, numbers_of_the_paper(rule), finding.numbers, verdict(finding)});
  }
  return out;
}

std::vector<Conclusion> conclusions_of_the_paper() {
  std::vector<Conclusion> out;
  for (const Rule& rule : kRules) {
    // The best splits that table 2 names are those of four cores; what figure 3 shows is nowhere in numbers.
    const bool untold = rule.find == hybrid_for_large;
    const Finding finding = untold ? Finding{} : rule.find(source_of_the_paper());
    out.push_back({rule.where, rule.claim, numbers_of_the_paper(rule), finding.numbers, verdict(finding)});
  }
  return out;
}

}  // namespace assur::report
