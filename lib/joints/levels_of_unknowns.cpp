#include "joints/levels_of_unknowns.hpp"

#include <cs.h>

#include <algorithm>
#include <memory>
#include <new>

namespace assur {
namespace {

struct Free {
  void operator()(cs_di* a) const { cs_di_spfree(a); }
  void operator()(cs_did* d) const { cs_di_dfree(d); }
  void operator()(int* p) const { cs_di_free(p); }
};

template <class T>
std::unique_ptr<T, Free> owned(T* p) {
  if (p == nullptr) throw std::bad_alloc();
  return std::unique_ptr<T, Free>(p);
}

}  // namespace

std::vector<Index> levels_of_unknowns(Index unknowns, std::vector<std::vector<Index>> equations) {
  std::vector<Index> levels(idx(unknowns), 0);
  const auto rows = static_cast<Index>(equations.size());
  if (unknowns == 0 || rows == 0) return levels;
  // Sorts equations by their unknowns: if the drivers of a chain came last, the matching would search the whole chain
  // for each of them. If there are more equations than unknowns, their order decides which ones count, and is kept.
  if (rows == unknowns) {
    std::stable_sort(equations.begin(), equations.end(), [](const auto& a, const auto& b) {
      return *std::max_element(a.begin(), a.end()) < *std::max_element(b.begin(), b.end());
    });
  }
  // A column for each equation: cs_maxtrans then finds the equation of each unknown.
  const auto all = owned(cs_di_spalloc(unknowns, rows, unknowns + rows, 1, 1));
  for (Index e = 0; e < rows; ++e) {
    for (const Index u : equations[idx(e)]) {
      if (cs_di_entry(all.get(), u, e, 1.0) == 0) throw std::bad_alloc();
    }
  }
  const auto incidence = owned(cs_di_compress(all.get()));
  const auto matching = owned(cs_di_maxtrans(incidence.get(), 0));  // for each unknown its equation, -1: none
  // Unknowns x unknowns: column u has the unknowns of the equation of u.
  const auto pairs = owned(cs_di_spalloc(unknowns, unknowns, unknowns, 1, 1));
  const auto read_by = [&](Index u) -> const std::vector<Index>& {
    static const std::vector<Index> kNone;
    const int equation = matching.get()[u];
    return equation < 0 ? kNone : equations[idx(equation)];
  };
  for (Index u = 0; u < unknowns; ++u) {
    if (cs_di_entry(pairs.get(), u, u, 1.0) == 0) throw std::bad_alloc();
    for (const Index v : read_by(u)) {
      if (v != u && cs_di_entry(pairs.get(), v, u, 1.0) == 0) throw std::bad_alloc();
    }
  }
  const auto needs = owned(cs_di_compress(pairs.get()));
  const auto blocks = owned(cs_di_scc(needs.get()));
  std::vector<Index> block_of(idx(unknowns)), level(idx(blocks->nb), 0);
  for (int b = 0; b < blocks->nb; ++b) {
    for (int k = blocks->r[b]; k < blocks->r[b + 1]; ++k) block_of[idx(blocks->p[k])] = b;
  }
  // Blocks are upper triangular: a column reads rows of its own block and of earlier ones.
  for (int b = 0; b < blocks->nb; ++b) {
    for (int k = blocks->r[b]; k < blocks->r[b + 1]; ++k) {
      for (const Index v : read_by(blocks->p[k])) {
        if (block_of[idx(v)] != b) level[idx(b)] = std::max(level[idx(b)], level[idx(block_of[idx(v)])] + 1);
      }
    }
  }
  for (Index u = 0; u < unknowns; ++u) levels[idx(u)] = level[idx(block_of[idx(u)])];
  return levels;
}

}  // namespace assur
