#include "backends/lanes_elimination.hpp"

#include <algorithm>
#include <functional>
#include <numeric>
#include <utility>

#include "backends/backends.hpp"

namespace assur::lanes {
namespace {

using Number = Elimination::Number;

// The permuted matrix and its factors by rows; positions count pivots.
struct Factors {
  struct Entry {
    Number column, source;
  };
  std::vector<std::vector<Entry>> a;
  std::vector<std::vector<Number>> l, u;  // columns left and right of the diagonal, ascending
};

Factors factor_symbolically(const Pattern& pattern, const std::vector<std::int32_t>& row,
                            const std::vector<std::int32_t>& column) {
  const auto n = row.size();
  std::vector<Number> position(n);
  for (Number k = 0; k < n; ++k) position[static_cast<std::size_t>(row[k])] = k;
  Factors f{std::vector<std::vector<Factors::Entry>>(n), std::vector<std::vector<Number>>(n),
            std::vector<std::vector<Number>>(n)};
  std::vector<Number> entries(n, 0);  // number of entries of each row
  for (const std::int32_t i : pattern.row) ++entries[position[static_cast<std::size_t>(i)]];
  for (Number i = 0; i < n; ++i) {
    f.a[i].reserve(entries[i]);
    f.l[i].reserve(2 * entries[i]);  // usually rows have fewer
    f.u[i].reserve(2 * entries[i]);
  }
  for (Number j = 0; j < n; ++j) {
    const auto c = static_cast<std::size_t>(column[j]);
    for (auto k = pattern.column_start[c]; k < pattern.column_start[c + 1]; ++k) {
      const auto i = position[static_cast<std::size_t>(pattern.row[static_cast<std::size_t>(k)])];
      f.a[i].push_back({j, static_cast<Number>(k)});
    }
  }
  std::vector<Number> seen(n, 0);  // columns: 1 + the last row that has an entry there
  std::vector<Number> open;        // columns left of the diagonal, a heap with the smallest on top
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
std::vector<Number> by_level(const Factors& f) {
  const auto n = f.l.size();
  std::vector<Number> level(n, 0), order(n);
  for (Number i = 0; i < n; ++i) {
    for (Number k : f.l[i]) level[i] = std::max(level[i], level[k] + 1);
    for (Number j : f.u[i]) level[j] = std::max(level[j], level[i] + 1);
  }
  std::iota(order.begin(), order.end(), Number{0});
  std::stable_sort(order.begin(), order.end(), [&](Number a, Number b) { return level[a] < level[b]; });
  return order;
}

// For each row the last unknown of the matrix that needs it: the row is computed if first_wanted is at most this
// unknown.
std::vector<Number> last_need(const Factors& f, const std::vector<std::int32_t>& column) {
  std::vector<Number> need(column.begin(), column.end());
  for (Number i = 0; i < need.size(); ++i) {
    for (Number j : f.u[i]) need[j] = std::max(need[j], need[i]);
  }
  return need;
}

}  // namespace

Elimination write_program(const Pattern& pattern, const Order& order) {
  const auto n = static_cast<Number>(pattern.n);
  std::vector<std::int32_t> row(n), column(n);
  {
    const std::vector<Number> levels = by_level(factor_symbolically(pattern, order.row, order.column));
    for (Number k = 0; k < n; ++k) {
      row[k] = order.row[levels[k]];
      column[k] = order.column[levels[k]];
    }
  }
  const Factors f = factor_symbolically(pattern, row, column);
  Elimination p;
  p.n = n;
  p.permutation_sign = parity(row) * parity(column);

  // The backward substitution starts with the rows that the most unknowns need; every row comes after the rows that it
  // needs.
  const std::vector<Number> need = last_need(f, column);
  std::vector<Number> back(n);
  std::iota(back.rbegin(), back.rend(), Number{0});
  std::stable_sort(back.begin(), back.end(), [&](Number a, Number b) { return need[a] > need[b]; });
  p.wanted_rows.assign(n + 1, 0);
  for (Number last : need) ++p.wanted_rows[last];
  std::partial_sum(p.wanted_rows.rbegin(), p.wanted_rows.rend(), p.wanted_rows.rbegin());

  std::vector<Number> l_start(n), u_start(n);
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
  std::vector<Number> source(n, Elimination::kZero);
  std::vector<std::vector<Product>> products(n);
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
  p.upper_slot = std::move(u_start);
  return p;
}

}  // namespace assur::lanes
