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
// them, and assumes that the inputs follow the cubic as well. It is no proof: its quality depends on how well
// the step resolves the motion of the inputs.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "assur/backend.hpp"
#include "evaluation/coefficients.hpp"
#include "groups/box_test.hpp"
#include "numbers.hpp"
#include "structure/grouped_system.hpp"

namespace assur {

// Conditions and uniqueness tests of the irreducible blocks of a class.
class BlockConditions {
 public:
  // by_solver: blocks of more than three unknowns are inverted by solutions of a LinearSolver
  BlockConditions(const GroupClass& group_class, int lanes, bool by_solver = false);

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

  // True if the block is too large for an inverse: its norms are estimates, which need factors of every lane.
  [[nodiscard]] bool is_large(std::int32_t block) const;
  // True if measure() may need a solver.
  [[nodiscard]] bool needs_solver(std::int32_t block) const {
    return is_large(block) || (by_solver_ && size(block) > 3);
  }
  // True if it needs one for these lanes: not if the test of a tube has left the inverse of this Jacobian.
  [[nodiscard]] bool needs_solver(std::int32_t block, const double* jacobian, std::span<const std::uint8_t> lanes);
  // To be called before the tests of a posture, so that earlier ones leave nothing.
  void forget_inverse() {
    if (!inverted_.empty()) inverted_[0] = kNan;
  }

  // True if a box around each of four postures holds exactly one solution of a block. of.jacobian: of the posture at
  // the end of a tube, say, in whose inverse boxes are tested. False also if it is singular, or if the block has more
  // than 64 unknowns. unknowns, inputs: n x 4, inputs x 4
  [[nodiscard]] bool hold_one_solution(std::int32_t block, const BoxTest::Lane& of, const double* unknowns,
                                       const double* inputs);
  // The same for the posture of the Jacobian, by its equations and their scales.
  [[nodiscard]] bool holds_one_solution(std::int32_t block, const BoxTest::Lane& of, const double* phi,
                                        const double* scale);

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
  [[nodiscard]] std::span<const BoxTest::JacobianEntry> entries(std::int32_t block) const {
    const auto b = static_cast<std::size_t>(block);
    return {entries_.data() + entry_start_[b], entries_.data() + entry_start_[b + 1]};
  }
  [[nodiscard]] bool invert(std::int32_t block, const BoxTest::Lane& of);
  [[nodiscard]] bool hold(std::int32_t block, const BoxTest::Lane& of);
  [[nodiscard]] bool invert_matrix(std::int32_t n);
  void dense_norms(std::int32_t block, int lane, const double* jacobian, const Weights& weights, const Norms& norms);
  [[nodiscard]] bool has_inverse(std::int32_t block, int lane, const double* jacobian);
  void norms_by_solver(std::int32_t block, const Weights& weights, LinearSolver& solver, const Norms& norms,
                       const double* jacobian, std::span<const std::uint8_t> lanes);
  void sparse_norms(std::int32_t block, const double* weights, LinearSolver& solver, double* norms);

  const GroupClass& class_;
  int lanes_;
  bool by_solver_;
  std::vector<std::int32_t> unknown_start_, unknowns_;  // by block
  std::vector<std::int32_t> equations_;                 // by block, same starts
  std::vector<std::int32_t> entry_start_;               // by block
  std::vector<BoxTest::JacobianEntry> entries_;         // column after column of each block
  std::vector<double> matrix_, inverse_, inverted_;     // largest dense block; inverted_: the matrix of inverse_
  std::vector<double> of_lipschitz_, of_scale_;         // its unknowns x lanes
  std::unique_ptr<BoxTest> boxes_;
  std::vector<std::int32_t> reads_start_, reads_;  // by block
  std::vector<double> vector_;                     // right-hand sides x n x lanes, if a block needs a solver
};

}  // namespace assur
