// Keeps the packs of a class on their branch: how far a posture may move and still be on that of the last anchor. The
// mathematics is in branch.hpp.
#pragma once

#include <cstdint>

#include "group/attempt.hpp"
#include "group/branch.hpp"
#include "group/jacobian_solver.hpp"
#include "group/workspace.hpp"

namespace assur {

class BranchGuard {
 public:
  BranchGuard(Workspace& work, JacobianSolver& solver);

  [[nodiscard]] BlockConditions& blocks() { return blocks_; }
  [[nodiscard]] const BlockConditions& blocks() const { return blocks_; }

  // After Newton's first correction, while phi and the Jacobian are those of the prediction: whether it leads to the
  // one solution nearby.
  [[nodiscard]] Status check_first_correction(const Pack& pack);

  // Of a posture that is solved and in the workspace, with its rates: it is inside the ball, or a tube leads to it.
  // Where the ball is used up, or is to be measured first, the posture becomes the anchor.
  [[nodiscard]] Status check(Pack& pack, double* const (&state)[3], const Attempt& attempt, Counters& counters);

  // Keeps how much of a ball is used as `before`, if the next step of this length stays inside as well.
  [[nodiscard]] static bool stays_inside(double used, double& before);

 private:
  [[nodiscard]] double ball_use(const Pack& pack, const double* x, std::int32_t block) const;
  [[nodiscard]] double ball_use_of(const Pack& pack, const double* x, std::int32_t block, std::int32_t lane) const;
  [[nodiscard]] Status check_tubes(const Pack& pack, double* const (&state)[3], std::int32_t block,
                                   const Attempt& attempt);
  [[nodiscard]] bool tube_leads_here(const Pack& pack, double* const (&state)[3], std::int32_t block, int lane,
                                     double seconds);
  [[nodiscard]] Status set_anchor(Pack& pack, double* const (&state)[3], std::int32_t block, const Attempt& attempt,
                                  Counters& counters);

  Workspace& work_;
  JacobianSolver& solver_;
  BlockConditions blocks_;
  LaneArray there_, there_inputs_, there_phi_, there_jacobian_;  // of a posture on the way
  LaneArray omega_, posture_errors_;                             // W: of one block
};

}  // namespace assur
