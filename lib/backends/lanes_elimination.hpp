// Factorisation and solution of a sparse matrix with a fixed pivot order, as a list of the operands of all
// multiplications. U has a unit diagonal, P A Q = L U:
//
//   row i of L   l_ik = a_ik - sum_m l_im u_mk,   k <= i
//   row i of U   u_ij = (a_ij - sum_m l_im u_mj) / l_ii
//   forward      y_i = (b_i - sum_k l_ik y_k) / l_ii
//   backward     x_i = y_i - sum_j u_ij x_j
//
// Factors are stored in `slots` of one number for each lane: the rows of L, each with the reciprocal of its pivot at
// the end; then the rows of U in the order of the backward substitution; then, for each row, the sum of its squares in
// A.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <memory_resource>
#include <vector>

#include "assur/backend.hpp"
#include "backends/lanes_order.hpp"

namespace assur::lanes {

struct Elimination {
  using Number = std::uint32_t;
  static constexpr Number kZero = 0xFFFFFFFF;  // source of an entry that is fill

  Number n = 0, slots = 0;
  int permutation_sign = 0;  // of the row order times that of the column order

  // For each row: number of entries of L left of the diagonal, number of entries of U, slot of the first entry of U.
  // Then for each entry (L, the diagonal, U): its source among the nonzeros or kZero, the number of its products, and
  // for each product the slots of l and u.
  std::vector<Number> factor;
  // For each row: row of the matrix, number of entries of L; for each entry its position in y.
  std::vector<Number> forward;
  // For each row, from the last on: its position in y, unknown of the matrix, number of entries of U; for each entry
  // its position in y.
  std::vector<Number> backward;
  std::vector<Number> wanted_rows;  // n + 1: rows of `backward` that unknowns from first_wanted on need

  // For access to single rows, n each: slot of its reciprocal, first slot of its U, places in `forward` and `backward`.
  std::vector<Number> pivot_slot, upper_slot, forward_row, backward_row;
  Number square_slot = 0;  // slot of the sum of squares of row 0 of A; those of the next rows follow

  friend bool operator==(const Elimination&, const Elimination&) = default;
  [[nodiscard]] Number lower_count(std::size_t row) const { return forward[forward_row[row] + 1]; }
  [[nodiscard]] Number upper_count(std::size_t row) const { return backward[backward_row[row] + 2]; }
};

// Writes the list for a complete pivot order. Takes memory from `memory`, and for the list if it has not enough.
void write_program(const Pattern& pattern, const Order& order, std::pmr::memory_resource* memory, Elimination& into);
[[nodiscard]] Elimination write_program(const Pattern& pattern, const Order& order);

// The list of a solver of the backend `lanes` in double whose pivots serve every lane; else null. The program of a step
// may eliminate by it.
[[nodiscard]] std::shared_ptr<const Elimination> elimination_of(const LinearSolver& solver);
// True if that list is this one.
[[nodiscard]] bool eliminates_by(const LinearSolver& solver, const Elimination* elimination);
// Counts factorisations that a program made instead of such a solver, whose next new pivots depend on their number.
void count_factorizations(LinearSolver& solver, std::int64_t factorizations);

// Memory of a solver that chooses pivots.
class PivotMemory {
 public:
  // Memory is reserved for up to kMostReserved unknowns, and only then used again. holders: factors that keep an
  // Elimination each; 0: nothing is reserved.
  PivotMemory(std::int32_t n, int lanes, std::size_t holders);
  [[nodiscard]] bool is_reserved() const { return is_reserved_; }

  // For markowitz_order() and write_program(); what was taken before is free again.
  [[nodiscard]] std::pmr::memory_resource* anew();
  // An Elimination that no factors hold.
  [[nodiscard]] std::shared_ptr<Elimination> program();
  // Another solver keeps this one: it will not be written again.
  void give_away(const std::shared_ptr<const Elimination>& program);

 private:
  [[nodiscard]] std::shared_ptr<Elimination> reserved() const;

  std::int32_t n_;
  bool is_reserved_;
  std::vector<std::byte> bytes_;
  std::pmr::monotonic_buffer_resource temporary_;
  std::vector<std::shared_ptr<Elimination>> programs_;
};

}  // namespace assur::lanes
