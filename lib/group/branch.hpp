// Staying on the branch. Around a posture q0 with Jacobian J0 of an irreducible block, the affine Lipschitz constant
//   omega = | |J0^-1| k |_inf,   k_i = Lipschitz constant of row i of the Jacobian in the maximum norm,
// makes J regular, and the solution unique, wherever omega |q - q0|_inf < 1 (Banach; Deuflhard 2004, section 2.1). The
// posture where omega was measured is the anchor. The check of a step inside the ball costs one maximum norm; omega is
// measured again only when the ball is used up. Blocks of up to 64 unknowns invert J0; for larger blocks Hager's
// estimate (Higham 1988) replaces the inverse.
//
// One norm for all coordinates is cheap. It is too strict if coordinates differ in size or move together, like a small
// part on a long arm. Steps that it refuses are tested again coordinate by coordinate: around a posture q of a cubic
// through the anchor and the new posture, the box |x - q| <= r holds exactly one solution if
//   e + M r <= r,   e = |C Phi(q)|,   M = |C| (|J1 - J(q)| + |Phi'' r|),   C = J1^-1
// (Krawczyk 1969). If this holds all along the cubic, the boxes form a tube with one solution at every time, which
// leads from the anchor to the new posture. The test examines four postures, with a margin for the postures between
// them, and assumes that the inputs follow the cubic as well. It is therefore no proof: its quality depends on how well
// the step resolves the motion of the inputs.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "assur/backend.hpp"
#include "assur/structure.hpp"
#include "equations/program.hpp"

namespace assur {

// Conditions and uniqueness tests of the irreducible blocks of a class.
class BlockConditions {
 public:
  BlockConditions(const GroupClass& group_class, const Program& program, int lanes);

  // Computes for one block, in every lane, omega = | |J^-1| k |_inf and | |J^-1| s |_inf with the scales s
  // (Evaluator::scale) of its equations. The second one times the relative residual is an error of the posture. Both
  // are infinite if the block is singular. If needs_solver(block), `solver` must hold a factorisation of the same
  // Jacobian; the second norm is then bounded by omega times the largest s / k. lanes: 1 for each lane whose norms are
  // needed; empty: all are.
  struct Weights {  // equations x lanes
    const double* lipschitz;
    const double* scale;
  };
  struct Norms {  // lanes
    double* omega;
    double* scale;
  };
  void measure(std::int32_t block, const double* jacobian, const Weights& weights, LinearSolver* solver,
               const Norms& norms, std::span<const std::uint8_t> lanes = {});

  // True if the block is too large for a dense inverse.
  [[nodiscard]] bool needs_solver(std::int32_t block) const;

  // Computes C of one block in one lane, for holds_one_solution(). False if the block is singular, or has more than 64
  // unknowns.
  [[nodiscard]] bool invert(std::int32_t block, int lane, const double* jacobian);

  // True if a box was found around a posture that holds exactly one solution of the block that invert() was called for.
  // jacobian: the Jacobian that C inverts; there, phi, scale: Jacobian, equations and Evaluator::scale at the posture;
  // coefficients: of the pack.
  [[nodiscard]] bool holds_one_solution(std::int32_t block, int lane, const double* jacobian, const double* there,
                                        const double* phi, const double* scale, const double* coefficients);

  // The moving coordinates that a block reads: local numbers of unknowns and inputs.
  [[nodiscard]] std::span<const std::int32_t> reads(std::int32_t block) const {
    return {reads_.data() + reads_start(block), reads_.data() + reads_start(block + 1)};
  }
  [[nodiscard]] std::size_t reads_start(std::int32_t block) const {
    return static_cast<std::size_t>(reads_start_[static_cast<std::size_t>(block)]);
  }

  // Dense copy of one block of one lane, column-major: size x size.
  void extract(const double* jacobian, std::int32_t block, int lane, std::vector<double>& out) const;
  [[nodiscard]] std::int32_t size(std::int32_t block) const {
    return unknown_start_[static_cast<std::size_t>(block) + 1] - unknown_start_[static_cast<std::size_t>(block)];
  }
  [[nodiscard]] std::span<const std::int32_t> unknowns(std::int32_t block) const;
  [[nodiscard]] std::span<const std::int32_t> equations(std::int32_t block) const;

 private:
  void find_reads(const GroupClass& group_class);
  // The entries of its Jacobian that a block has: nonzero of the pattern, and its place in the block.
  struct Entry {
    std::int32_t nonzero, row, column;
  };
  [[nodiscard]] std::span<const Entry> entries(std::int32_t block) const {
    const auto b = static_cast<std::size_t>(block);
    return {entries_.data() + entry_start_[b], entries_.data() + entry_start_[b + 1]};
  }
  [[nodiscard]] bool invert_matrix(std::int32_t n);
  void dense_norms(std::int32_t block, int lane, const double* jacobian, const Weights& weights, const Norms& norms);
  void change_registers(std::int32_t block, int lane, const double* coefficients, std::span<const double> radius);
  void sparse_norms(std::int32_t block, const double* weights, LinearSolver& solver, double* norms);

  const Program& program_;
  int lanes_;
  std::vector<std::int32_t> unknown_start_, unknowns_;  // by block
  std::vector<std::int32_t> equations_;                 // by block, same starts
  std::vector<std::int32_t> entry_start_;               // by block
  std::vector<Entry> entries_;                          // column after column of each block
  std::vector<double> matrix_, inverse_, inverted_;     // largest dense block; inverted_: the matrix of inverse_
  std::vector<double> change_;                          // its entries
  std::vector<double> defect_, radius_, image_, sums_;  // its unknowns
  std::vector<double> register_change_;                 // registers
  std::vector<std::int32_t> reads_start_, reads_;       // by block
  std::vector<double> vector_;                          // n x lanes, if there are large blocks
};

}  // namespace assur
