// Blocked right-looking LU with partial pivoting by the threads of a team, with BLAS kernels on one thread each.
//
// The matrix is divided into panels of kPanel columns and tiles of kTile columns. The division depends on its order
// alone, so that the result is bitwise identical for every number of threads. The work is one list:
//
//   for each panel k:  [ update panel k + 1 by panel k and factorise it ]   the look-ahead: first, because all threads
//                      wait for it
//                      [ update each tile right of it by panel k ]
//   then for each panel:  [ swap its rows by the pivots of the later panels ]
//
// Each free thread takes the next item. An item waits for its panel and its columns. Both come from earlier items,
// which other threads have taken already, so that there is no deadlock.
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "backends/block.hpp"
#include "parallel/team.hpp"

namespace assur {

template <class T>
class TeamLu {
 public:
  // For matrices of order n.
  explicit TeamLu(DenseIndex n);

  // P a = L U in place; pivot: the row swapped with each row, counted from 1. False at a pivot that is zero or not
  // finite.
  [[nodiscard]] bool factorize(const Block<T>& a, std::int32_t* pivot, Team& team);

 private:
  struct alignas(64) Counter {
    std::atomic<std::uint32_t> value{0};
  };

  void work(int rank) noexcept;
  void do_item(DenseIndex panel, DenseIndex item) noexcept;
  void factorize_panel(DenseIndex panel);
  void update(DenseIndex panel, DenseIndex first, DenseIndex last);
  void swap_left(DenseIndex panel);
  DenseIndex items(DenseIndex panel) const;
  DenseIndex end(DenseIndex panel) const;
  void await(const Counter& counter, DenseIndex value) const;

  DenseIndex n_, panels_, tiles_;
  Block<T> a_{};
  std::int32_t* pivot_ = nullptr;
  Counter next_;                  // next item of the list
  Counter factorized_;            // number of factorised panels
  std::vector<Counter> updated_;  // tiles: number of panels that updated each
  std::atomic<bool> failed_ = false;
};

}  // namespace assur
