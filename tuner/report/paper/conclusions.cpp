#include "report/paper/conclusions.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <set>

#include "output/format.hpp"
#include "report/paper/plan.hpp"

namespace assur::report {
namespace {

constexpr double kAsFast = 1.05;  // times up to this ratio are equal

// The times of the paper or of this machine. Those of the paper are kept by table, because two tables share cells.
struct Source {
  std::optional<Times> here;  // empty: times of the paper
  int threads;                // available to the versions

  [[nodiscard]] Times table(int number) const { return here ? *here : paper_times(number); }
};

struct Finding {
  std::optional<bool> holds = {};   // empty: undecided
  std::string numbers = "not run";  // the numbers, or why it is undecided
};

Finding needs_threads(int threads) { return {{}, "needs at least " + std::to_string(threads) + " threads"}; }

std::string total(const PaperCell& cell) { return "total size " + std::to_string(cell.total()); }

// Ratios of several cells, without unknown ones (NaN).
struct Ratios {
  struct Of {
    PaperCell cell;
    double ratio;
  };
  std::vector<Of> all;

  [[nodiscard]] bool empty() const { return all.empty(); }
  [[nodiscard]] double least() const { return limit(std::fmin); }
  [[nodiscard]] double most() const { return limit(std::fmax); }
  [[nodiscard]] const Of& first() const { return all.front(); }
  [[nodiscard]] const Of& last() const { return all.back(); }
  [[nodiscard]] std::string text() const {  // "3.83 to 7.98"
    return least() == most() ? ratio_text(least()) : ratio_text(least()) + " to " + ratio_text(most());
  }

 private:
  [[nodiscard]] double limit(double (*of)(double, double)) const {
    double limit = kNan;
    for (const Of& r : all) limit = of(limit, r.ratio);
    return limit;
  }
};

Ratios ratios(const std::vector<PaperCell>& cells, const std::function<double(const PaperCell&)>& of) {
  Ratios out;
  for (const PaperCell& cell : cells) {
    if (const double ratio = of(cell); !std::isnan(ratio)) out.all.push_back({cell, ratio});
  }
  return out;
}

// Time of version `a` over time of version `b`, for all cells of a table.
Ratios ratios(const Source& s, int table, std::string_view a, std::string_view b) {
  return ratios(cells_of_table(table),
                [&](const PaperCell& c) { return best(s.table(table), c, a) / best(s.table(table), c, b); });
}

double best_of_groups(const Source& s, const PaperCell& cell) {
  return std::fmin(best(s.table(2), cell, kDense), best(s.table(2), cell, kSparse));
}
double best_of_global(const Source& s, const PaperCell& cell) {
  return std::fmin(best(s.table(2), cell, kGlobalDense), best(s.table(2), cell, kGlobalSparse));
}
Ratios groups_over_global(const Source& s) {
  return ratios(cells_of_table(2), [&](const PaperCell& c) { return best_of_global(s, c) / best_of_groups(s, c); });
}

bool is_first(const PaperCell& cell, int table) { return cell == cells_of_table(table)[0]; }

// ---- global formulation and groups, dense and sparse

Finding dense_for_the_case_study(const Source& s) {
  const Ratios r = ratios(s, 2, kGlobalSparse, kGlobalDense);
  if (r.empty() || !is_first(r.first().cell, 2)) return {};
  return {r.first().ratio > 1,
          "GMKL is " + ratio_text(r.first().ratio) + " times as fast as GMA27 at " + total(r.first().cell)};
}

Finding sparse_for_large(const Source& s) {
  const Ratios r = ratios(s, 2, kGlobalDense, kGlobalSparse);
  if (r.empty() || !is_first(r.first().cell, 2)) return {};
  const PaperCell first = r.first().cell, last = r.last().cell;
  if (last.total() < 2 * first.total()) return {};
  const auto exponent = [&](std::string_view version) {
    return std::log(best(s.table(2), last, version) / best(s.table(2), first, version)) /
           std::log(static_cast<double>(last.total()) / first.total());
  };
  const double dense = exponent(kGlobalDense), sparse = exponent(kGlobalSparse);
  return {r.last().ratio > 1 && sparse < 1.5 && dense > sparse + 0.5,
          "GMA27 is " + ratio_text(r.last().ratio) + " times as fast as GMKL at " + total(last) +
              "; times grow like size^" + ratio_text(sparse) + " and size^" + ratio_text(dense)};
}

Finding groups_beat_global(const Source& s) {
  const Ratios r = groups_over_global(s);
  if (r.empty()) return {};
  return {r.least() > 1, "groups are " + r.text() + " times as fast as the better global version"};
}

Finding four_times_for_the_largest(const Source& s) {
  const Ratios r = groups_over_global(s);
  if (r.empty()) return {};
  return {std::round(r.last().ratio) >= 4, ratio_text(r.last().ratio) + " times as fast at " + total(r.last().cell)};
}

Finding crossover_of_sparsity(const Source& s) {
  const auto at = [all = ratios(s, 3, kSparse, kDense)](int n) {
    Ratios out = all;
    std::erase_if(out.all, [n](const Ratios::Of& r) { return r.cell.n != n; });
    return out;
  };
  const Ratios at_60 = at(60), at_120 = at(120);
  if (at_60.empty() || at_120.empty()) return {};
  return {at_60.least() > 1 && at_120.most() < 1,
          "time of sparse over dense: " + at_60.text() + " at n = 60, " + at_120.text() + " at n = 120"};
}

Finding sparse_large_dense_small(const Source& s) {
  const Ratios r = ratios(s, 2, kSparse, kDense);
  if (r.all.size() < 2 || !is_first(r.first().cell, 2)) return {};
  return {r.first().ratio > 1 && r.last().ratio < 1,
          "time of sparse over dense groups: " + ratio_text(r.first().ratio) + " at " + total(r.first().cell) + ", " +
              ratio_text(r.last().ratio) + " at " + total(r.last().cell)};
}

Finding method_depends(const Source& s) {
  std::set<std::string> winners;
  for (const int table : {2, 3}) {
    for (const Ratios::Of& r : ratios(s, table, kDense, kSparse).all) winners.emplace(r.ratio < 1 ? kDense : kSparse);
  }
  if (winners.empty()) return {};
  std::string names;
  for (const std::string& w : winners) names += (names.empty() ? "" : " and ") + w;
  return {winners.size() > 1, "fastest in some cell of tables 2 and 3: " + names};
}

Finding four_to_eight(const Source& s) {
  const Ratios r = ratios(
      cells_of_table(2), [&](const PaperCell& c) { return best(s.table(2), c, kGlobalSparse) / best_of_groups(s, c); });
  if (r.empty()) return {};
  return {std::round(r.least()) >= 4 && std::round(r.most()) <= 8, r.text() + " times as fast as GMA27"};
}

Finding auto_is_the_fastest(const Source& s) {
  Ratios r;
  for (const int table : {2, 3, 4, 5}) {
    const Ratios more = ratios(cells_of_table(table), [&](const PaperCell& c) {
      return std::fmin(best_of_global(s, c), best_of_groups(s, c)) / best(s.table(2), c, kAuto);
    });
    r.all.insert(r.all.end(), more.all.begin(), more.all.end());
  }
  if (r.empty()) return {{}, "none: an outlook"};
  return {r.least() * kAsFast >= 1,
          "auto is " + r.text() + " times as fast as the fastest of the paper's versions in the same cell"};
}

// ---- threads, and the GPU

bool several_groups(const Split& s) { return s.p > 1 && s.q == 1; }
bool several_threads(const Split& s) { return s.p == 1 && s.q > 1; }

Finding openmp_beats_mkl(const Source& s) {
  if (s.threads < 2) return needs_threads(2);
  const std::vector<PaperCell> cells = cells_of_table(2);
  std::vector<std::string> ahead_by_openmp, ahead_by_mkl;
  bool holds = true;
  for (const PaperCell& cell : cells) {
    const double openmp = best(s.table(2), cell, kDense, several_groups);
    const double mkl = best(s.table(2), cell, kDense, several_threads);
    if (std::isnan(openmp) && std::isnan(mkl)) continue;
    const bool by_openmp = std::isnan(mkl) || openmp < mkl;  // the paper only has the faster one
    (by_openmp ? ahead_by_openmp : ahead_by_mkl).push_back(std::to_string(cell.total()));
    holds = holds && by_openmp == (cell != cells.back());
  }
  if (ahead_by_openmp.empty() && ahead_by_mkl.empty()) return {};
  const auto list = [](const std::vector<std::string>& of) { return of.empty() ? "no size" : output::listed(of); };
  return {holds, "OpenMP is faster at " + list(ahead_by_openmp) + "; MKL at " + list(ahead_by_mkl)};
}

Finding three_threads(const Source& s) {
  if (s.threads < 4) return needs_threads(4);
  int three = 0, all = 0;
  for (const PaperCell& cell : cells_of_table(2)) {
    for (const std::string_view version : {kDense, kSparse}) {
      const PaperTiming* const t = fastest(s.table(2), cell, version);
      if (t == nullptr) continue;
      ++all;
      three += t->split == Split{3, 1} ? 1 : 0;
    }
  }
  if (all == 0) return {};
  return {2 * three > all,
          "3x1 is the fastest split in " + std::to_string(three) + " of " + std::to_string(all) + " cells"};
}

Finding parallelism_grows(const Source& s) {
  if (s.threads < 2) return needs_threads(2);
  std::string numbers;
  bool holds = true;
  for (const std::string_view version : {kDense, kSparse}) {
    const Ratios r = ratios(cells_of_table(3), [&](const PaperCell& c) {
      return best(s.table(3), c, version, just({1, 1})) / best(s.table(3), c, version, several_groups);
    });
    if (r.all.size() < 2) continue;
    holds = holds && r.least() > 1 && r.last().ratio > r.first().ratio;
    numbers += (numbers.empty() ? "" : "; ") + std::string(version) + ": " + r.text() + " times as fast as one " +
               "thread, from " + ratio_text(r.first().ratio) + " in the smallest to " + ratio_text(r.last().ratio) +
               " in the largest";
  }
  if (numbers.empty()) return {};
  return {holds, numbers};
}

Finding hybrid_for_large(const Source& s) {
  if (s.threads < 4) return needs_threads(4);
  std::vector<const PaperTiming*> all;
  for (const PaperCell& cell : cells_of_table(2)) {
    if (const PaperTiming* const t = fastest(s.table(2), cell, kDense)) all.push_back(t);
  }
  if (all.size() < 2) return {};
  const PaperTiming &small = *all.front(), &large = *all.back();
  return {several_groups(small.split) && large.split.p > 1 && large.split.q > 1,
          "fastest splits: " + text_of(small.split) + " at " + total(small.cell) + ", " + text_of(large.split) +
              " at " + total(large.cell)};
}

// 6x2 over 2x6, in the smallest and the largest cell with both.
Finding wide_for_small_narrow_for_large(const Source& s) {
  if (s.threads < 6) return needs_threads(6);
  const Ratios r = ratios(cells_of_table(5), [&](const PaperCell& c) {
    return best(s.table(5), c, kDense, [](const Split& x) { return x.q == 2 && x.p > 2; }) /
           best(s.table(5), c, kDense, [](const Split& x) { return x.p == 2 && x.q > 2; });
  });
  if (r.empty() || r.last().cell.n < 400) return {};
  return {r.first().ratio < 1 && r.last().ratio > 1,
          "time of many groups at once over many threads in each: " + ratio_text(r.first().ratio) + " at n = 18, " +
              ratio_text(r.last().ratio) + " at n = " + std::to_string(r.last().cell.n)};
}

Finding gpu_for_large_only(const Source& s) {
  const Split wide = s.here ? wide_and_narrow(s.threads).wide : Split{6, 2};
  const Ratios r = ratios(cells_of_table(5), [&](const PaperCell& c) {
    return best(s.table(5), c, kGpu) / best(s.table(5), c, kDense, just(wide));
  });
  if (r.empty()) return {{}, "no GPU here"};
  if (!is_first(r.first().cell, 5) || r.last().cell.n < 400) return {{}, "not run from n = 18 to 400"};
  int from = 0;  // n from which on the GPU is faster; 0: nowhere
  for (const Ratios::Of& of : r.all) from = of.ratio >= 1 ? 0 : from == 0 ? of.cell.n : from;
  const auto at = [](const Ratios::Of& of) { return ratio_text(of.ratio) + " at n = " + std::to_string(of.cell.n); };
  return {r.first().ratio > 1 && r.first().ratio > r.last().ratio,
          "time of the GPU over that of " + text_of(wide) + " on the CPU: " + at(r.first()) + ", " + at(r.last()) +
              "; the GPU is faster " +
              (from == 0 ? "at no n of the table" : "from n = " + std::to_string(from) + " on")};
}

Finding no_raspberry_pi(const Source&) { return {{}, "no Raspberry Pi here"}; }

struct Rule {
  const char *where, *claim;
  Finding (*find)(const Source&);
};

constexpr std::array kRules = {
    Rule{"5.1", "Multithreading MKL is preferable to MA27 for the case study", dense_for_the_case_study},
    Rule{"5.1", "With larger matrices sparsity pays: O(n) of MA27 against O(n³) of MKL", sparse_for_large},
    Rule{"5.1, 6", "SolvedGroup equations clearly outperform the global formulation", groups_beat_global},
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

// The figures of table 4 for the first and the last size.
std::string raspberry_pi_of_the_paper() {
  const auto of = [](std::string_view machine, const PaperCell& cell) {
    const auto& all = paper_times(4);
    return *std::find_if(all.begin(), all.end(),
                         [&](const PaperTiming& t) { return t.machine == machine && t.cell == cell; });
  };
  const auto line = [&](const PaperCell& cell) {
    const PaperTiming pi = of("RP3", cell), i5 = of("i5", cell);
    return ratio_text(pi.seconds / i5.seconds) + " times the i5's time and " + ratio_text(pi.joules / i5.joules) +
           " times its energy at n = " + std::to_string(cell.n);
  };
  const std::vector<PaperCell> cells = cells_of_table(4);
  return "RP3: " + line(cells.front()) + ", " + line(cells.back());
}

// The paper gives figure 3 without numbers; the best splits of its table 2 are for four cores.
Finding finding_of_the_paper(const Rule& rule) {
  if (rule.find == no_raspberry_pi) return {{}, raspberry_pi_of_the_paper()};
  if (rule.find == hybrid_for_large) return {{}, "only in figure 3, without numbers"};
  return rule.find({{}, 12});
}

std::vector<Conclusion> all_of(const std::function<Finding(const Rule&, const Finding& theirs)>& find) {
  std::vector<Conclusion> out;
  for (const Rule& rule : kRules) {
    const Finding theirs = finding_of_the_paper(rule), here = find(rule, theirs);
    const Verdict verdict = !here.holds   ? Verdict::cannot_be_tested
                            : *here.holds ? Verdict::holds
                                          : Verdict::does_not_hold;
    out.push_back({rule.where, rule.claim, theirs.numbers, here.numbers, verdict});
  }
  return out;
}

}  // namespace

std::string_view verdict_text(Verdict verdict) noexcept {
  constexpr std::array<std::string_view, 3> kTexts = {"holds here", "does not hold here", "cannot be tested here"};
  return kTexts[static_cast<std::size_t>(verdict)];
}

std::vector<Conclusion> conclusions(Times times, int threads) {
  return all_of([&](const Rule& rule, const Finding&) { return rule.find({times, threads}); });
}

std::vector<Conclusion> conclusions_of_the_paper() {
  return all_of([](const Rule&, const Finding& theirs) { return theirs; });
}

}  // namespace assur::report
