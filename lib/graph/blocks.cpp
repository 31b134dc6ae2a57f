#include "graph/blocks.hpp"

#include <cs.h>

#include <algorithm>
#include <memory>
#include <numeric>

namespace assur {
namespace {

struct FreeSparse {
  void operator()(cs_di* a) const { cs_di_spfree(a); }
};
struct FreeDecomposition {
  void operator()(cs_did* d) const { cs_di_dfree(d); }
};

// Equations x unknowns, values all 1.
std::unique_ptr<cs_di, FreeSparse> incidence(const System& s, std::span<const Index> equations,
                                             std::span<const Index> unknowns) {
  std::vector<Index> column(s.coordinates.size(), -1);
  for (std::size_t j = 0; j < unknowns.size(); ++j)
    column[static_cast<std::size_t>(unknowns[j])] = static_cast<Index>(j);
  std::unique_ptr<cs_di, FreeSparse> triplets(cs_di_spalloc(static_cast<int>(equations.size()),
                                                            static_cast<int>(unknowns.size()),
                                                            static_cast<int>(equations.size() * 4 + 1), 1, 1));
  std::vector<Index> mentioned;
  for (std::size_t i = 0; i < equations.size(); ++i) {
    s.mentioned(equations[i], mentioned);
    for (const Index c : mentioned) {
      const Index j = column[static_cast<std::size_t>(c)];
      if (j >= 0) cs_di_entry(triplets.get(), static_cast<int>(i), j, 1.0);
    }
  }
  return std::unique_ptr<cs_di, FreeSparse>(cs_di_compress(triplets.get()));
}

std::vector<Index> pick(std::span<const Index> from, const int* permutation, int begin, int end) {
  std::vector<Index> out;
  for (int k = begin; k < end; ++k) out.push_back(from[static_cast<std::size_t>(permutation[k])]);
  std::sort(out.begin(), out.end());
  return out;
}

// Levels by longest path. Every block comes after the blocks that it needs.
void set_levels(const System& s, Blocks& b) {
  std::vector<Index> block_of(s.coordinates.size(), -1);
  for (Index k = 0; k < b.size(); ++k) {
    for (const Index u : b.unknowns_of(k)) block_of[static_cast<std::size_t>(u)] = k;
  }
  std::vector<Index> mentioned;
  for (Index k = 0; k < b.size(); ++k) {
    const auto first = static_cast<std::ptrdiff_t>(b.needs.size());
    Index level = 0;
    for (const Index e : b.equations_of(k)) {
      s.mentioned(e, mentioned);
      for (const Index c : mentioned) {
        const Index o = block_of[static_cast<std::size_t>(c)];
        if (o < 0 || o == k) continue;
        b.needs.push_back(o);
        level = std::max(level, b.level[static_cast<std::size_t>(o)] + 1);
      }
    }
    std::sort(b.needs.begin() + first, b.needs.end());
    b.needs.erase(std::unique(b.needs.begin() + first, b.needs.end()), b.needs.end());
    b.needs_start.push_back(static_cast<Index>(b.needs.size()));
    b.level.push_back(level);
  }
}

Blocks sorted(const Blocks& b) {
  std::vector<Index> order(static_cast<std::size_t>(b.size()));
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](Index x, Index y) {
    const auto key = [&](Index k) { return std::pair(b.level[static_cast<std::size_t>(k)], b.unknowns_of(k).front()); };
    return key(x) < key(y);
  });
  std::vector<Index> place(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) place[static_cast<std::size_t>(order[k])] = static_cast<Index>(k);
  Blocks out;
  out.surplus_equations = b.surplus_equations;
  out.surplus_unknowns = b.surplus_unknowns;
  out.over_unknowns = b.over_unknowns;
  out.under_equations = b.under_equations;
  for (const Index k : order) {
    const auto e = b.equations_of(k), u = b.unknowns_of(k);
    out.equations.insert(out.equations.end(), e.begin(), e.end());
    out.unknowns.insert(out.unknowns.end(), u.begin(), u.end());
    out.start.push_back(static_cast<Index>(out.unknowns.size()));
    out.level.push_back(b.level[static_cast<std::size_t>(k)]);
    for (const Index o : b.needs_of(k)) out.needs.push_back(place[static_cast<std::size_t>(o)]);
    std::sort(out.needs.begin() + out.needs_start.back(), out.needs.end());
    out.needs_start.push_back(static_cast<Index>(out.needs.size()));
  }
  return out;
}

}  // namespace

Blocks decompose(const System& s, std::span<const Index> equations, std::span<const Index> unknowns) {
  Blocks b;
  if (unknowns.empty() && equations.empty()) return b;
  const auto a = incidence(s, equations, unknowns);
  const std::unique_ptr<cs_did, FreeDecomposition> d(cs_di_dmperm(a.get(), 0));
  if (d == nullptr) throw std::bad_alloc();
  // Coarse parts (CSparse, cs_dmperm): columns [cc0, cc1, cc2, cc3, cc4] and rows [rr0 .. rr4] with the
  // underdetermined part first (columns cc0..cc2, rows rr0..rr1) and the overdetermined last (cc3..cc4, rr2..rr4).
  b.surplus_unknowns = pick(unknowns, d->q, d->cc[0], d->cc[2]);
  b.under_equations = pick(equations, d->p, d->rr[0], d->rr[1]);
  b.over_unknowns = pick(unknowns, d->q, d->cc[3], d->cc[4]);
  b.surplus_equations = pick(equations, d->p, d->rr[2], d->rr[4]);
  // Fine blocks of the well-determined part are upper triangular: the last one needs no other.
  for (int k = d->nb - 1; k >= 0; --k) {
    if (d->r[k] < d->rr[1] || d->r[k + 1] > d->rr[2] || d->s[k] < d->cc[2] || d->s[k + 1] > d->cc[3]) continue;
    const auto e = pick(equations, d->p, d->r[k], d->r[k + 1]);
    const auto u = pick(unknowns, d->q, d->s[k], d->s[k + 1]);
    if (u.empty()) continue;
    b.equations.insert(b.equations.end(), e.begin(), e.end());
    b.unknowns.insert(b.unknowns.end(), u.begin(), u.end());
    b.start.push_back(static_cast<Index>(b.unknowns.size()));
  }
  set_levels(s, b);
  return sorted(b);
}

}  // namespace assur
