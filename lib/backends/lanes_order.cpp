#include "backends/lanes_order.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <string>

#include "index.hpp"

namespace assur::lanes {
namespace {

constexpr double kLeastRatio = 1e-3;  // pivot over the largest of its row, if no pivot serves all lanes
constexpr int kLists = 16;  // rows, and columns, with the fewest entries that are searched for a pivot (Zlatev 1980)

// Rows or columns by their number of entries, in doubly linked lists.
class Buckets {
 public:
  Buckets(Index n, std::pmr::memory_resource* memory)
      : first_(idx(n) + 1, -1, memory),
        next_(idx(n), -1, memory),
        before_(idx(n), -1, memory),
        count_(idx(n), -1, memory) {}

  [[nodiscard]] Index first(Index count) const { return first_[idx(count)]; }
  [[nodiscard]] Index next(Index i) const { return next_[idx(i)]; }

  void remove(Index i) {
    if (count_[idx(i)] < 0) return;
    const Index before = before_[idx(i)], next = next_[idx(i)];
    (before < 0 ? first_[idx(count_[idx(i)])] : next_[idx(before)]) = next;
    if (next >= 0) before_[idx(next)] = before;
    count_[idx(i)] = -1;
  }
  void put(Index i, Index count) {
    remove(i);
    const Index next = first_[idx(count)];
    next_[idx(i)] = next;
    before_[idx(i)] = -1;
    if (next >= 0) before_[idx(next)] = i;
    first_[idx(count)] = i;
    count_[idx(i)] = count;
  }

 private:
  std::pmr::vector<Index> first_, next_, before_, count_;
};

// The remaining matrix, and the search for its next pivot.
class Elimination {
 public:
  Elimination(const Pattern& pattern, std::span<const double> values, int lanes, std::uint32_t wanted, PivotRule rule,
              std::pmr::memory_resource* memory);
  Order run();

 private:
  struct LaneRow {
    explicit LaneRow(std::pmr::memory_resource* memory) : column(memory), value(memory), largest(memory) {}

    std::pmr::vector<Index> column;
    std::pmr::vector<double> value;    // entries x lanes
    std::pmr::vector<double> largest;  // lanes: max |value|
  };
  struct Candidate {
    Index row = -1, entry = -1;
    std::int64_t cost = std::numeric_limits<std::int64_t>::max();
    Index level = 0;           // length of the longest chain of pivots before it
    double ratio = 0;          // entry over the largest entry of its row, in the worst lane
    std::uint32_t serves = 0;  // lanes
  };

  [[nodiscard]] Candidate candidate(Index row, Index entry) const;
  [[nodiscard]] bool better(const Candidate& a, const Candidate& b) const;
  [[nodiscard]] bool largest_of_column(Index column, int lane, double size) const;
  [[nodiscard]] Index find(Index row, Index column) const;
  [[nodiscard]] Candidate search() const;
  [[nodiscard]] Candidate compromise() const;
  void eliminate(const Candidate& pivot);
  void subtract(Index row, Index pivot_row, Index pivot_entry);
  void measure(Index row);

  Index n_;
  std::size_t lanes_;
  PivotRule rule_;
  std::uint32_t served_;
  std::int64_t products_ = 0;
  std::pmr::memory_resource* memory_;
  std::pmr::vector<LaneRow> rows_;
  std::pmr::vector<std::pmr::vector<Index>> columns_;  // rows of each column
  Buckets by_row_, by_column_;
  std::pmr::vector<Index> place_;                     // n: index of a column's entry in the current row, or -1
  std::pmr::vector<double> ratio_;                    // lanes
  std::pmr::vector<Index> row_level_, column_level_;  // n
};

Elimination::Elimination(const Pattern& pattern, std::span<const double> values, int lanes, std::uint32_t wanted,
                         PivotRule rule, std::pmr::memory_resource* memory)
    : n_(pattern.n),
      lanes_(static_cast<std::size_t>(lanes)),
      rule_(rule),
      served_(wanted),
      memory_(memory),
      rows_(memory),
      columns_(idx(n_), memory),
      by_row_(n_, memory),
      by_column_(n_, memory),
      place_(idx(n_), -1, memory),
      ratio_(lanes_, memory),
      row_level_(idx(n_), memory),
      column_level_(idx(n_), memory) {
  std::pmr::vector<std::size_t> entries(idx(n_), 0, memory);  // number of entries of each row
  for (const Index i : pattern.row) ++entries[idx(i)];
  rows_.reserve(idx(n_));
  for (Index i = 0; i < n_; ++i) {
    const auto most = [&](std::size_t count) {  // twice as many are usually enough for the fill
      return n_ <= kMostReserved ? idx(n_) : std::min(2 * count, idx(n_));
    };
    LaneRow& row = rows_.emplace_back(memory);
    row.column.reserve(most(entries[idx(i)]));
    row.value.reserve(most(entries[idx(i)]) * lanes_);
    columns_[idx(i)].reserve(most(idx(pattern.column_start[idx(i) + 1] - pattern.column_start[idx(i)])));
  }
  for (Index j = 0; j < n_; ++j) {
    for (Index k = pattern.column_start[idx(j)]; k < pattern.column_start[idx(j) + 1]; ++k) {
      LaneRow& row = rows_[idx(pattern.row[idx(k)])];
      row.column.push_back(j);
      const auto first = values.begin() + static_cast<std::ptrdiff_t>(idx(k) * lanes_);
      row.value.insert(row.value.end(), first, first + lanes);
      columns_[idx(j)].push_back(pattern.row[idx(k)]);
    }
  }
  for (Index i = n_; i-- > 0;) {
    measure(i);
    by_row_.put(i, static_cast<Index>(rows_[idx(i)].column.size()));
    by_column_.put(i, static_cast<Index>(columns_[idx(i)].size()));
  }
}

void Elimination::measure(Index i) {
  LaneRow& row = rows_[idx(i)];
  row.largest.assign(lanes_, 0.0);
  for (std::size_t k = 0; k < row.value.size(); k += lanes_) {
    for (std::size_t l = 0; l < lanes_; ++l) row.largest[l] = std::max(row.largest[l], std::abs(row.value[k + l]));
  }
}

Order Elimination::run() {
  Order order{std::pmr::vector<Index>(memory_), std::pmr::vector<Index>(memory_)};
  for (auto* v : {&order.row, &order.column}) v->reserve(idx(n_));
  for (Index k = 0; k < n_; ++k) {
    Candidate pivot = search();
    if (pivot.row < 0) pivot = compromise();
    if (pivot.row < 0) break;
    served_ &= pivot.serves;
    order.row.push_back(pivot.row);
    order.column.push_back(rows_[idx(pivot.row)].column[idx(pivot.entry)]);
    eliminate(pivot);
  }
  order.served = order.complete(n_) ? served_ : 0;
  return order;
}

Index Elimination::find(Index row, Index column) const {
  const auto& columns = rows_[idx(row)].column;
  return static_cast<Index>(std::find(columns.begin(), columns.end(), column) - columns.begin());
}

bool Elimination::largest_of_column(Index column, int lane, double size) const {
  return std::all_of(columns_[idx(column)].begin(), columns_[idx(column)].end(), [&](Index i) {
    return std::abs(rows_[idx(i)].value[idx(find(i, column)) * lanes_ + idx(lane)]) <= size;
  });
}

Elimination::Candidate Elimination::candidate(Index i, Index entry) const {
  const LaneRow& row = rows_[idx(i)];
  const Index column = row.column[idx(entry)];
  Candidate c{.row = i, .entry = entry};
  c.level = std::max(row_level_[idx(i)], column_level_[idx(column)]);
  c.cost =
      static_cast<std::int64_t>(row.column.size() - 1) * static_cast<std::int64_t>(columns_[idx(column)].size() - 1);
  c.ratio = 1;
  const double* value = row.value.data() + idx(entry) * lanes_;
  for (std::uint32_t left = served_; left != 0; left &= left - 1) {
    const int l = std::countr_zero(left);
    const double size = std::abs(value[l]), largest = row.largest[idx(l)];
    const double ratio = size > 0 ? size / largest : 0;
    c.ratio = std::min(c.ratio, ratio);
    if (!(ratio > 0) || ratio < (rule_.rook ? 1 : rule_.threshold)) continue;
    if (rule_.rook && !largest_of_column(column, l, size)) continue;
    c.serves |= 1u << l;
  }
  return c;
}

bool Elimination::better(const Candidate& a, const Candidate& b) const {
  if (a.cost != b.cost) return a.cost < b.cost;
  if (rule_.shallow && a.level != b.level) return a.level < b.level;
  return a.ratio > b.ratio;
}

// The cheapest entry that serves every lane, among rows and columns with few entries; row -1 if there is none.
Elimination::Candidate Elimination::search() const {
  Candidate best;
  int looked_at = 0;
  const auto consider = [&](const Candidate& c) {
    if (c.serves == served_ && better(c, best)) best = c;
  };
  for (Index count = 1; count <= n_; ++count) {
    const auto finished = [&] {
      return best.row >= 0 && (best.cost < std::int64_t{count - 1} * (count - 1) || looked_at >= 2 * kLists);
    };
    for (Index j = by_column_.first(count); j >= 0 && !finished(); j = by_column_.next(j), ++looked_at) {
      for (Index i : columns_[idx(j)]) consider(candidate(i, find(i, j)));
    }
    for (Index i = by_row_.first(count); i >= 0 && !finished(); i = by_row_.next(i), ++looked_at) {
      for (Index e = 0; e < count; ++e) consider(candidate(i, e));
    }
    if (finished() || (best.row >= 0 && best.cost <= std::int64_t{count} * count)) break;
  }
  return best;
}

// The entry that is largest in its worst lane. If it is too small there: the entry that serves most lanes, and the
// cheapest of these. Row -1 if there is none.
Elimination::Candidate Elimination::compromise() const {
  Candidate largest, most;
  for (Index i = 0; i < n_; ++i) {
    for (Index e = 0; e < static_cast<Index>(rows_[idx(i)].column.size()); ++e) {
      const Candidate c = candidate(i, e);
      const int more = std::popcount(c.serves) - std::popcount(most.serves);
      if (c.serves != 0 && (more > 0 || (more == 0 && better(c, most)))) most = c;
      if (c.ratio > largest.ratio) largest = c;
    }
  }
  if (rule_.rook || largest.ratio < kLeastRatio) return most;
  largest.serves = served_;
  return largest;
}

void Elimination::eliminate(const Candidate& pivot) {
  const LaneRow& row = rows_[idx(pivot.row)];
  const Index column = row.column[idx(pivot.entry)];
  products_ += pivot.cost;
  if (products_ > kMostProducts) {
    throw Error(Error::Kind::environment, "the elimination of " + std::to_string(n_) + " unknowns takes more than " +
                                              std::to_string(kMostProducts) +
                                              " products, too many for the backend lanes: use another backend");
  }
  for (Index j : row.column) column_level_[idx(j)] = std::max(column_level_[idx(j)], pivot.level + 1);
  for (Index i : columns_[idx(column)]) row_level_[idx(i)] = std::max(row_level_[idx(i)], pivot.level + 1);
  by_row_.remove(pivot.row);
  by_column_.remove(column);
  for (Index j : row.column) std::erase(columns_[idx(j)], pivot.row);
  for (Index i : columns_[idx(column)]) {
    subtract(i, pivot.row, pivot.entry);
    measure(i);
    by_row_.put(i, static_cast<Index>(rows_[idx(i)].column.size()));
  }
  columns_[idx(column)].clear();
  for (Index j : row.column) {
    if (j != column) by_column_.put(j, static_cast<Index>(columns_[idx(j)].size()));
  }
  rows_[idx(pivot.row)] = LaneRow(memory_);
}

// Divides, while the factorisation multiplies by a reciprocal, so that equal rows cancel to an exact zero.
void Elimination::subtract(Index i, Index pivot_row, Index pivot_entry) {
  LaneRow& row = rows_[idx(i)];
  const LaneRow& pivot = rows_[idx(pivot_row)];
  const auto own = idx(find(i, pivot.column[idx(pivot_entry)])), last = row.column.size() - 1;
  for (std::size_t l = 0; l < lanes_; ++l) {
    ratio_[l] = row.value[own * lanes_ + l] / pivot.value[idx(pivot_entry) * lanes_ + l];
    row.value[own * lanes_ + l] = row.value[last * lanes_ + l];
  }
  row.column[own] = row.column[last];
  row.column.pop_back();
  row.value.resize(last * lanes_);

  for (std::size_t e = 0; e < last; ++e) place_[idx(row.column[e])] = static_cast<Index>(e);
  for (std::size_t e = 0; e < pivot.column.size(); ++e) {
    if (e == idx(pivot_entry)) continue;
    const Index j = pivot.column[e];
    if (place_[idx(j)] < 0) {
      place_[idx(j)] = static_cast<Index>(row.column.size());
      row.column.push_back(j);
      row.value.resize(row.value.size() + lanes_);
      columns_[idx(j)].push_back(i);
    }
    double* value = row.value.data() + idx(place_[idx(j)]) * lanes_;
    for (std::size_t l = 0; l < lanes_; ++l) value[l] -= ratio_[l] * pivot.value[e * lanes_ + l];
  }
  for (Index j : row.column) place_[idx(j)] = -1;
}

}  // namespace

Order markowitz_order(const Pattern& pattern, std::span<const double> values, int lanes, std::uint32_t wanted,
                      PivotRule rule, std::pmr::memory_resource* memory) {
  if (wanted == 0) return {};
  return Elimination(pattern, values, lanes, wanted, rule, memory).run();
}

}  // namespace assur::lanes
