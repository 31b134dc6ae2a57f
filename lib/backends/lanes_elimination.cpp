#include "backends/lanes_elimination.hpp"

#include <algorithm>
#include <functional>
#include <numeric>
#include <span>

#include "backends/backends.hpp"

namespace assur::lanes {
namespace {

using Number = Elimination::Number;

// The permuted matrix and its factors by rows; positions count pivots.
struct Factors {
  struct Nonzero {
    Number column, source;
  };
  std::pmr::vector<std::pmr::vector<Nonzero>> a;
  std::pmr::vector<std::pmr::vector<Number>> l, u;  // columns left and right of the diagonal, ascending

  Factors(std::size_t n, std::pmr::memory_resource* memory) : a(n, memory), l(n, memory), u(n, memory) {}
};

Factors factor_symbolically(const Pattern& pattern, std::span<const std::int32_t> row,
                            std::span<const std::int32_t> column, std::pmr::memory_resource* memory) {
  const auto n = row.size();
  std::pmr::vector<Number> position(n, memory);
  for (Number k = 0; k < n; ++k) position[static_cast<std::size_t>(row[k])] = k;
  Factors f(n, memory);
  std::pmr::vector<Number> entries(n, 0, memory);  // number of entries of each row
  for (const std::int32_t i : pattern.row) ++entries[position[static_cast<std::size_t>(i)]];
  for (Number i = 0; i < n; ++i) {
    f.a[i].reserve(entries[i]);
    const std::size_t most = pattern.n <= kMostReserved ? n : 2 * entries[i];  // usually rows have fewer
    f.l[i].reserve(most);
    f.u[i].reserve(most);
  }
  for (Number j = 0; j < n; ++j) {
    const auto c = static_cast<std::size_t>(column[j]);
    for (auto k = pattern.column_start[c]; k < pattern.column_start[c + 1]; ++k) {
      const auto i = position[static_cast<std::size_t>(pattern.row[static_cast<std::size_t>(k)])];
      f.a[i].push_back({j, static_cast<Number>(k)});
    }
  }
  std::pmr::vector<Number> seen(n, 0, memory);  // columns: 1 + the last row that has an entry there
  std::pmr::vector<Number> open(memory);        // columns left of the diagonal, a heap with the smallest on top
  open.reserve(n);
  for (Number i = 0; i < n; ++i) {
    const auto meet = [&](Number j) {
      if (seen[j] == i + 1) return;
      seen[j] = i + 1;
      if (j < i) {
        open.push_back(j);
        std::push_heap(open.begin(), open.end(), std::greater<>());
      } else if (j > i) {
        f.u[i].push_back(j);
      }
    };
    for (const auto& entry : f.a[i]) meet(entry.column);
    while (!open.empty()) {
      std::pop_heap(open.begin(), open.end(), std::greater<>());
      const Number m = open.back();
      open.pop_back();
      f.l[i].push_back(m);
      for (Number j : f.u[m]) meet(j);
    }
    std::sort(f.u[i].begin(), f.u[i].end());
  }
  return f;
}

// Orders pivots by level: neighbours are independent, so that a processor can overlap them.
std::pmr::vector<Number> by_level(const Factors& f, std::pmr::memory_resource* memory) {
  const auto n = f.l.size();
  std::pmr::vector<Number> level(n, 0, memory), order(n, memory);
  for (Number i = 0; i < n; ++i) {
    for (Number k : f.l[i]) level[i] = std::max(level[i], level[k] + 1);
    for (Number j : f.u[i]) level[j] = std::max(level[j], level[i] + 1);
  }
  std::iota(order.begin(), order.end(), Number{0});
  std::sort(order.begin(), order.end(),
            [&](Number a, Number b) { return level[a] != level[b] ? level[a] < level[b] : a < b; });
  return order;
}

// For each row the last unknown of the matrix that needs it: the row is computed if first_wanted is at most this
// unknown.
std::pmr::vector<Number> last_need(const Factors& f, std::span<const std::int32_t> column,
                                   std::pmr::memory_resource* memory) {
  std::pmr::vector<Number> need(column.begin(), column.end(), memory);
  for (Number i = 0; i < need.size(); ++i) {
    for (Number j : f.u[i]) need[j] = std::max(need[j], need[i]);
  }
  return need;
}

// Elimination objects that choose_pivots() tries while others are held: the present one, the best, the next, and that
// of the program of a step.
constexpr std::size_t kTried = 4;

// Temporary memory for n unknowns: full rows with their values, three times the positions of their entries, and the
// products of an entry; with room for the objects that hold them.
std::size_t bytes_for(std::size_t n, std::size_t lanes) {
  const std::size_t of_order = n * (n + 1) * (sizeof(double) * lanes + 2 * sizeof(Number));
  const std::size_t of_list = n * n * (2 * (sizeof(Factors::Nonzero) + 2 * sizeof(Number)) + 2 * sizeof(Number));
  return of_order + of_list + (n + 1) * 1024 + lanes * sizeof(double);
}

// Numbers of the lists of a full matrix.
std::size_t most_factors(std::size_t n) { return 3 * n + 2 * n * n + 2 * (n * (n + 1) * (2 * n + 1) / 6); }
std::size_t most_entries(std::size_t n) { return 3 * n + n * n / 2; }

}  // namespace

PivotMemory::PivotMemory(std::int32_t n, int lanes, std::size_t holders)
    : n_(n),
      is_reserved_(n <= kMostReserved && holders > 0),
      bytes_(is_reserved_ ? bytes_for(static_cast<std::size_t>(n), static_cast<std::size_t>(lanes)) : 0),
      temporary_(bytes_.data(), bytes_.size()) {
  if (!is_reserved_) return;
  for (std::size_t i = 0; i < holders + kTried; ++i) programs_.push_back(reserved());
}

std::pmr::memory_resource* PivotMemory::anew() {
  if (!is_reserved_) return std::pmr::new_delete_resource();
  temporary_.release();
  return &temporary_;
}

std::shared_ptr<Elimination> PivotMemory::program() {
  if (!is_reserved_) return std::make_shared<Elimination>();
  const auto is_free = [](const auto& p) { return p.use_count() == 1; };
  const auto found = std::find_if(programs_.begin(), programs_.end(), is_free);
  return found != programs_.end() ? *found : programs_.emplace_back(reserved());
}

void PivotMemory::give_away(const std::shared_ptr<const Elimination>& program) {
  const auto found = std::find(programs_.begin(), programs_.end(), program);
  if (found != programs_.end()) *found = reserved();
}

std::shared_ptr<Elimination> PivotMemory::reserved() const {
  const auto n = static_cast<std::size_t>(n_);
  auto p = std::make_shared<Elimination>();
  p->factor.reserve(most_factors(n));
  p->forward.reserve(most_entries(n));
  p->backward.reserve(most_entries(n));
  p->wanted_rows.reserve(n + 1);
  for (auto* v : {&p->pivot_slot, &p->upper_slot, &p->forward_row, &p->backward_row}) v->reserve(n);
  return p;
}

Elimination write_program(const Pattern& pattern, const Order& order) {
  Elimination out;
  write_program(pattern, order, std::pmr::get_default_resource(), out);
  return out;
}

void write_program(const Pattern& pattern, const Order& order, std::pmr::memory_resource* memory, Elimination& p) {
  const auto n = static_cast<Number>(pattern.n);
  std::pmr::vector<std::int32_t> row(n, memory), column(n, memory);
  {
    const std::pmr::vector<Number> levels =
        by_level(factor_symbolically(pattern, order.row, order.column, memory), memory);
    for (Number k = 0; k < n; ++k) {
      row[k] = order.row[levels[k]];
      column[k] = order.column[levels[k]];
    }
  }
  const Factors f = factor_symbolically(pattern, row, column, memory);
  p.n = n;
  p.slots = 0;
  for (auto* v : {&p.factor, &p.forward, &p.backward, &p.pivot_slot, &p.forward_row}) v->clear();
  p.permutation_sign = parity(row, memory) * parity(column, memory);

  // The backward substitution starts with the rows that the most unknowns need; every row comes after the rows that it
  // needs.
  const std::pmr::vector<Number> need = last_need(f, column, memory);
  std::pmr::vector<Number> back(n, memory);
  std::iota(back.rbegin(), back.rend(), Number{0});
  std::sort(back.begin(), back.end(),
            [&](Number a, Number b) { return need[a] != need[b] ? need[a] > need[b] : a > b; });
  p.wanted_rows.assign(n + 1, 0);
  for (Number last : need) ++p.wanted_rows[last];
  std::partial_sum(p.wanted_rows.rbegin(), p.wanted_rows.rend(), p.wanted_rows.rbegin());

  std::pmr::vector<Number> l_start(n, memory), u_start(n, memory);
  for (Number i = 0; i < n; ++i) {
    l_start[i] = p.slots;
    p.slots += static_cast<Number>(f.l[i].size());
    p.pivot_slot.push_back(p.slots++);
  }
  for (Number i : back) {
    u_start[i] = p.slots;
    p.slots += static_cast<Number>(f.u[i].size());
  }
  p.square_slot = p.slots;
  p.slots += n;

  struct Product {
    Number l, u;
  };
  std::pmr::vector<Number> source(n, Elimination::kZero, memory);
  std::pmr::vector<std::pmr::vector<Product>> products(n, memory);
  for (Number j = 0; j < n && pattern.n <= kMostReserved; ++j) products[j].reserve(n);
  for (Number i = 0; i < n; ++i) {
    const auto &l = f.l[i], &u = f.u[i];
    for (const auto& entry : f.a[i]) source[entry.column] = entry.source;
    for (Number e = 0; e < l.size(); ++e) {
      for (Number v = 0; v < f.u[l[e]].size(); ++v) {
        products[f.u[l[e]][v]].push_back({l_start[i] + e, u_start[l[e]] + v});
      }
    }
    p.factor.insert(p.factor.end(), {static_cast<Number>(l.size()), static_cast<Number>(u.size()), u_start[i]});
    const auto write = [&](Number j) {
      p.factor.insert(p.factor.end(), {source[j], static_cast<Number>(products[j].size())});
      for (const Product& product : products[j]) p.factor.insert(p.factor.end(), {product.l, product.u});
      source[j] = Elimination::kZero;
      products[j].clear();
    };
    std::for_each(l.begin(), l.end(), write);
    write(i);
    std::for_each(u.begin(), u.end(), write);

    p.forward_row.push_back(static_cast<Number>(p.forward.size()));
    p.forward.insert(p.forward.end(), {static_cast<Number>(row[i]), static_cast<Number>(l.size())});
    p.forward.insert(p.forward.end(), l.begin(), l.end());
  }
  p.backward_row.resize(n);
  for (Number i : back) {
    p.backward_row[i] = static_cast<Number>(p.backward.size());
    p.backward.insert(p.backward.end(), {i, static_cast<Number>(column[i]), static_cast<Number>(f.u[i].size())});
    p.backward.insert(p.backward.end(), f.u[i].begin(), f.u[i].end());
  }
  p.upper_slot.assign(u_start.begin(), u_start.end());
}

}  // namespace assur::lanes
