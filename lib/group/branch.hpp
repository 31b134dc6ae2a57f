// Staying on the branch. Around a posture q0 with Jacobian J0 of an irreducible block, the affine Lipschitz constant
//   omega = | |J0^-1| k |_inf,   k_i = Lipschitz constant of row i of the Jacobian in the maximum norm,
// makes J regular, and the solution unique, wherever omega |q - q0|_inf < 1 (Banach; Deuflhard 2004, section 2.1). The
// measured posture is the anchor: steps inside its ball cost one maximum norm, and omega is measured anew only when the
// ball is used up. J0^-1 itself is needed only up to blocks of 64; beyond, Hager's estimate (Higham 1988) takes its
// place.
//
// One norm is cheap, and too strict where coordinates are of different sizes or move together, as a small part on a
// long arm does. What it refuses is looked at again coordinate by coordinate: around a posture q of a cubic through the
// anchor and the new posture, the box |x - q| <= r holds exactly one solution if
//   e + M r <= r,   e = |C Phi(q)|,   M = |C| (|J1 - J(q)| + |Phi'' r|),   C = J1^-1
// (Krawczyk 1969). Where that is so all along the cubic, its boxes are a tube with one solution at every time, which
// leads from the one posture to the other. Looked at are four postures, with room for what lies between them, and the
// inputs are taken to move along the cubic as well: sure as far as a step resolves their motion, no proof.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "assur/backend.hpp"
#include "assur/structure.hpp"
#include "equations/program.hpp"

namespace assur {

class BlockConditions {
 public:
  BlockConditions(const GroupClass& group_class, const Program& program, int lanes);

  // Of one block in every lane from the Jacobian's values: omega = | |J^-1| k |_inf, and | |J^-1| s |_inf of the scales
  // (Evaluator::scale) of its equations, times the relative residual an error of the posture; infinite where the block
  // is singular. `solver` holds a factorisation of the same Jacobian if needs_solver(block); then the second is
  // omega times the largest s / k.
  struct Weights {  // equations x lanes
    const double* lipschitz;
    const double* scale;
  };
  struct Norms {  // lanes
    double* omega;
    double* scale;
  };
  void measure(std::int32_t block, const double* jacobian, const Weights& weights, LinearSolver* solver,
               const Norms& norms);

  [[nodiscard]] bool needs_solver(std::int32_t block) const;

  // C of one block in one lane, for holds_one_solution(). False if the block is singular, or has more than 64 unknowns.
  [[nodiscard]] bool invert(std::int32_t block, int lane, const double* jacobian);

  // Whether some box around a posture holds exactly one solution of the block that invert() was called for.
  // jacobian: where C is the inverse; there, phi, scale (Evaluator::scale): at the posture. coefficients: those of the
  // pack.
  [[nodiscard]] bool holds_one_solution(std::int32_t block, int lane, const double* jacobian, const double* there,
                                        const double* phi, const double* scale, const double* coefficients);

  // The coordinates that a block reads and that move: local numbers, unknowns and inputs.
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
  void dense_norms(std::int32_t block, int lane, const double* jacobian, const Weights& weights, const Norms& norms);
  void add_change(std::int32_t block, int lane, const double* coefficients, std::span<const double> radius);
  void sparse_norms(std::int32_t block, const double* weights, LinearSolver& solver, double* norms);

  const Program& program_;
  int lanes_;
  std::vector<std::int32_t> unknown_start_, unknowns_;  // by block
  std::vector<std::int32_t> equations_;                 // by block, same starts
  std::vector<std::int32_t> place_;                     // unknown -> column within its block
  std::vector<std::int32_t> row_place_;                 // equation -> row within its block
  std::vector<std::int32_t> nonzero_start_, nonzeros_;  // by block: indices of its entries
  std::vector<std::int32_t> nonzero_column_;            // nnz: column of each entry
  std::vector<double> matrix_, inverse_, change_;       // largest dense block
  std::vector<double> defect_, radius_, image_;         // its unknowns
  std::vector<double> register_change_;                 // registers
  std::vector<std::int32_t> reads_start_, reads_;       // by block
  std::vector<double> vector_;                          // n x lanes, if there are large blocks
};

}  // namespace assur
