// Keeps the packs of a class on their branch: decides if a new posture is on the branch of the last anchor. branch.hpp
// explains the mathematics.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "groups/attempt.hpp"
#include "groups/branch.hpp"
#include "groups/jacobian_solver.hpp"
#include "groups/workspace.hpp"

namespace assur {

// The test of one class.
class BranchGuard {
 public:
  BranchGuard(Workspace& work, JacobianSolver& solver);

  [[nodiscard]] BlockConditions& blocks() { return blocks_; }
  [[nodiscard]] const BlockConditions& blocks() const { return blocks_; }

  // True if Newton's first correction, in the workspace, is so small that its test needs nothing else.
  [[nodiscard]] bool is_near(const Pack& pack) const;
  // Tests Newton's first correction: ok if the iteration converges to the one solution nearby. To be called while phi
  // and the Jacobian of the workspace belong to the prediction.
  [[nodiscard]] Status check_first_correction(const Pack& pack);

  // Tests the solved posture in the workspace, with its rates: ok if it is inside the ball, or if a tube leads to it.
  // Each lane decides for itself: if its ball is used up or was not measured yet, its posture becomes the anchor.
  [[nodiscard]] Status check(Pack& pack, double* const (&state)[3], const Attempt& attempt, Counters& counters);

  // True if the next step of this length stays inside the ball, too; `before`, the used part of the ball, then becomes
  // `used`.
  [[nodiscard]] static bool stays_inside(double used, double& before);

 private:
  [[nodiscard]] bool is_near(const Pack& pack, std::int32_t block, int lane) const;
  void use_ball(const Pack& pack, const double* x, std::int32_t block);
  [[nodiscard]] Status check_tubes(const Pack& pack, double* const (&state)[3], std::int32_t block,
                                   const Attempt& attempt);
  [[nodiscard]] bool tube_leads_here(const Pack& pack, double* const (&state)[3], std::int32_t block, int lane,
                                     double seconds);
  [[nodiscard]] Status set_anchor(Pack& pack, double* const (&state)[3], std::int32_t block, const Attempt& attempt,
                                  Counters& counters);
  void move_anchor(Pack& pack, const double* const (&state)[3], std::int32_t block, std::size_t lane, double time);

  Workspace& work_;
  JacobianSolver& solver_;
  BlockConditions blocks_;
  LaneArray there_, there_inputs_;     // postures of a tube: n x 4, inputs x 4
  LaneArray omega_, posture_errors_;   // W: of one block
  LaneArray used_;                     // W: part of the ball, of one block
  std::vector<std::uint8_t> changes_;  // W: the anchor of this block
};

}  // namespace assur
