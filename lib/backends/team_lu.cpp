#include "backends/team_lu.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "backends/blas.hpp"
#include "parallel/thread_state.hpp"
#include "parallel/waiting.hpp"

namespace assur {
namespace {

constexpr DenseIndex kPanel = 48;  // columns; measured on n = 100 to 2000 with one and two threads
// wide enough for the kernels, narrow enough for the threads to end at the same time
constexpr DenseIndex kTile = 4 * kPanel;

// c -= a b. For products of up to kSmall multiplications, OpenBLAS 0.3's AVX-512 kernels allocate memory unless b is
// given transposed, which is as fast.
template <class T>
void subtract_product(const Block<T>& c, const Block<T>& a, const Block<T>& b) {
  constexpr DenseIndex kSmall = 1000000;
  if (c.rows * c.columns * b.rows > kSmall) return blas::subtract_product(c, a, b);
  T turned[kPanel * kTile];
  const Block<T> transposed{turned, b.columns, b.rows, b.columns};
  for (DenseIndex k = 0; k < b.rows; ++k) {
    for (DenseIndex j = 0; j < b.columns; ++j) transposed(j, k) = b(k, j);
  }
  blas::subtract_product(c, a, transposed, Transpose::yes);
}

}  // namespace

template <class T>
TeamLu<T>::TeamLu(DenseIndex n)
    : n_(n),
      panels_((n + kPanel - 1) / kPanel),
      tiles_((n + kTile - 1) / kTile),
      updated_(static_cast<std::size_t>(tiles_)) {}

template <class T>
bool TeamLu<T>::factorize(const Block<T>& a, std::int32_t* pivot, Team& team) {
  a_ = a;
  pivot_ = pivot;
  failed_ = false;
  next_.value = 0;
  factorized_.value = 0;
  for (Counter& tile : updated_) tile.value = 0;
  if (tiles_ > 1) {
    team.run([this](int rank) noexcept { work(rank); });
  } else {
    work(0);
  }
  // From here on, pivots are row numbers of the whole matrix.
  for (DenseIndex k = kPanel; k < n_; ++k) pivot_[k] += static_cast<std::int32_t>(k - k % kPanel);
  return !failed_;
}

// Items have consecutive numbers. Each thread finds the panel of its item by walking along the list.
template <class T>
void TeamLu<T>::work(int rank) noexcept {
  const BlasThreads one(1);
  if (rank == 0) {
    factorize_panel(0);
    advance(factorized_.value);
  }
  DenseIndex panel = 0, first = 0;  // first: number of the first item of this panel
  for (;;) {
    const DenseIndex number = next_.value.fetch_add(1, std::memory_order_relaxed);
    while (panel + 1 < panels_ && number - first >= items(panel)) first += items(panel++);
    if (panel + 1 < panels_) {
      do_item(panel, number - first);
    } else if (number - first + 1 < panels_) {
      await(factorized_, panels_);
      if (!failed_) swap_left(number - first);
    } else {
      return;
    }
  }
}

// One item for the next panel, and one for each tile that has columns right of it.
template <class T>
DenseIndex TeamLu<T>::items(DenseIndex panel) const {
  return 1 + (end(panel + 1) < n_ ? tiles_ - end(panel + 1) / kTile : 0);
}

template <class T>
DenseIndex TeamLu<T>::end(DenseIndex panel) const {
  return std::min((panel + 1) * kPanel, n_);
}

template <class T>
void TeamLu<T>::do_item(DenseIndex panel, DenseIndex item) noexcept {
  const DenseIndex next_end = end(panel + 1);
  const DenseIndex tile = item == 0 ? end(panel) / kTile : next_end / kTile + item - 1;
  Counter& updated = updated_[static_cast<std::size_t>(tile)];
  await(factorized_, panel + 1);
  await(updated, panel);
  if (item == 0) {
    if (!failed_) {
      update(panel, end(panel), next_end);
      factorize_panel(panel + 1);
    }
    advance(factorized_.value);
  } else {
    if (!failed_) update(panel, std::max(tile * kTile, next_end), std::min((tile + 1) * kTile, n_));
    advance(updated.value);
  }
}

template <class T>
void TeamLu<T>::await(const Counter& counter, DenseIndex value) const {
  const auto wanted = static_cast<std::uint32_t>(value);
  for (std::uint32_t is; (is = counter.value.load(std::memory_order_acquire)) < wanted;) wait_while(counter.value, is);
}

template <class T>
void TeamLu<T>::factorize_panel(DenseIndex panel) {
  const DenseIndex first = panel * kPanel, columns = end(panel) - first;
  const Block<T> block = a_.block(first, first, n_ - first, columns);
  if (!blas::getrf(block, pivot_ + first)) failed_ = true;
  for (DenseIndex k = 0; k < columns; ++k) {
    if (!std::isfinite(block(k, k))) failed_ = true;
  }
}

// Updates columns `first` to `last`, right of the panel: swaps rows, computes U by substitution, and subtracts the
// product from the rest. Until factorize() ends, pivots are row numbers relative to their panel.
template <class T>
void TeamLu<T>::update(DenseIndex panel, DenseIndex first, DenseIndex last) {
  const DenseIndex top = panel * kPanel, width = end(panel) - top, below = n_ - top - width, columns = last - first;
  const Block<T> upper = a_.block(top, first, width, columns);
  blas::swap_rows(a_.block(top, first, n_ - top, columns), pivot_ + top, width);
  blas::solve_unit_lower(a_.block(top, top, width, width), upper);
  subtract_product(a_.block(top + width, first, below, columns), a_.block(top + width, top, below, width), upper);
}

// Column by column, because a column fits into the cache.
template <class T>
void TeamLu<T>::swap_left(DenseIndex panel) {
  for (DenseIndex j = panel * kPanel; j < end(panel); ++j) {
    for (DenseIndex later = panel + 1; later < panels_; ++later) {
      T* const column = a_.column(j) + later * kPanel;
      const std::int32_t* const pivot = pivot_ + later * kPanel;
      for (DenseIndex k = 0; k < end(later) - later * kPanel; ++k) std::swap(column[k], column[pivot[k] - 1]);
    }
  }
}

template class TeamLu<double>;
template class TeamLu<float>;

}  // namespace assur
