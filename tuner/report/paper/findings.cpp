#include "report/paper/findings.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace assur::report {

double best(Times times, const PaperCell& cell, std::string_view version) {
  const PaperTiming* const t = fastest(times, cell, version);
  return t == nullptr ? std::nan("") : t->seconds;
}

std::string total(const PaperCell& cell) { return "total size " + std::to_string(cell.total()); }

void Range::add(double value) {
  if (std::isnan(value)) return;
  least = std::min(least, value);
  most = std::max(most, value);
}

std::string Range::text() const {
  return least == most ? ratio_text(least) : ratio_text(least) + " to " + ratio_text(most);
}

namespace {

constexpr double kAsFast = 1.05;  // times that are so near each other count as equal

double best_of_groups(Times times, const PaperCell& cell) {
  return std::fmin(best(times, cell, kDense), best(times, cell, kSparse));
}
double best_of_global(Times times, const PaperCell& cell) {
  return std::fmin(best(times, cell, "GMKL"), best(times, cell, "GMA27"));
}

// The last cell of table 2 for which both have a time.
std::optional<PaperCell> largest(Times times, std::string_view a, std::string_view b) {
  std::optional<PaperCell> last;
  for (const PaperCell& cell : cells_of_table(2)) {
    if (!std::isnan(best(times, cell, a) + best(times, cell, b))) last = cell;
  }
  return last;
}

}  // namespace

Finding dense_for_the_case_study(const Source& s) {
  const PaperCell cell = cells_of_table(2)[0];
  const double ratio = best(s.table_2, cell, "GMA27") / best(s.table_2, cell, "GMKL");
  if (std::isnan(ratio)) return not_run();
  return {ratio > 1, "GMKL is " + ratio_text(ratio) + " times as fast as GMA27 at " + total(cell)};
}

Finding sparse_for_large(const Source& s) {
  const PaperCell first = cells_of_table(2)[0];
  const std::optional<PaperCell> last = largest(s.table_2, "GMKL", "GMA27");
  if (!last || last->total() < 2 * first.total()) return not_run();
  const auto exponent = [&](std::string_view version) {
    return std::log(best(s.table_2, *last, version) / best(s.table_2, first, version)) /
           std::log(static_cast<double>(last->total()) / first.total());
  };
  const double ratio = best(s.table_2, *last, "GMKL") / best(s.table_2, *last, "GMA27");
  const double dense = exponent("GMKL"), sparse = exponent("GMA27");
  if (std::isnan(ratio + dense + sparse)) return not_run();
  return {ratio > 1 && sparse < 1.5 && dense > sparse + 0.5,
          "GMA27 is " + ratio_text(ratio) + " times as fast as GMKL at " + total(*last) + "; times grow like size^" +
              ratio_text(sparse) + " and size^" + ratio_text(dense)};
}

Finding groups_beat_global(const Source& s) {
  Range range;
  for (const PaperCell& cell : cells_of_table(2)) {
    range.add(best_of_global(s.table_2, cell) / best_of_groups(s.table_2, cell));
  }
  if (range.empty()) return not_run();
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
  if (!last) return not_run();
  return {std::round(ratio) >= 4, ratio_text(ratio) + " times as fast at " + total(*last)};
}

Finding crossover_of_sparsity(const Source& s) {
  Range at_60, at_120;
  for (const PaperCell& cell : cells_of_table(3)) {
    const double ratio = best(s.table_3, cell, kSparse) / best(s.table_3, cell, kDense);
    if (cell.n == 60) at_60.add(ratio);
    if (cell.n == 120) at_120.add(ratio);
  }
  if (at_60.empty() || at_120.empty()) return not_run();
  return {at_60.least > 1 && at_120.most < 1,
          "time of sparse over dense: " + at_60.text() + " at n = 60, " + at_120.text() + " at n = 120"};
}

Finding sparse_large_dense_small(const Source& s) {
  const PaperCell first = cells_of_table(2)[0];
  const std::optional<PaperCell> last = largest(s.table_2, kDense, kSparse);
  if (!last || *last == first) return not_run();
  const auto ratio = [&](const PaperCell& c) { return best(s.table_2, c, kSparse) / best(s.table_2, c, kDense); };
  if (std::isnan(ratio(first))) return not_run();
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
  if (winners.empty()) return not_run();
  std::string names;
  for (const std::string_view w : winners) names += (names.empty() ? "" : " and ") + std::string(w);
  return {winners.size() > 1, "fastest in some cell of tables 2 and 3: " + names};
}

Finding four_to_eight(const Source& s) {
  Range range;
  for (const PaperCell& cell : cells_of_table(2)) {
    range.add(best(s.table_2, cell, "GMA27") / best_of_groups(s.table_2, cell));
  }
  if (range.empty()) return not_run();
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

}  // namespace assur::report
