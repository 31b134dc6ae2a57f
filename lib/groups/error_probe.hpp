// Errors of a solved pack: residuals, conditions, and the errors of the unknowns that follow from errors of the inputs,
// of the equations and of rounding.
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <span>

#include "backends/residual.hpp"
#include "equations/system.hpp"
#include "groups/branch.hpp"
#include "groups/change_point_posture.hpp"
#include "groups/coded_changes.hpp"
#include "groups/jacobian_solver.hpp"
#include "groups/workspace.hpp"

namespace assur {

// Possible errors of posture, velocity and acceleration, each in the layout of the state, with their cause.
struct Probe {
  enum class Cause : std::uint8_t {
    left,       // residuals of the equations, with their own signs
    rounding,   // rounding errors with random signs
    tolerance,  // a relative residual of kSumRounding in every equation, with random signs
  };
  Cause cause = Cause::left;
  std::array<double*, 3> errors{};
};
using Probes = std::span<const Probe>;
// Lanes: a relative residual that any equation may have, although the residuals at this posture do not show it.
using Unseen = std::array<double, kMostLanes>;

// Relative residuals and conditions (GroupFigures) of the lanes of a pack.
struct GroupHealth {
  std::array<double, kMostLanes> residual{}, condition{};
};

// Probes the packs of one class. Packs with fewer lanes than a vector take several probes side by side.
class ErrorProbe {
 public:
  ErrorProbe(const System& system, Workspace& work, JacobianSolver& solver, BlockConditions& blocks);

  // For each probe, computes the errors of the unknowns, to first order, from the errors of the inputs and from the
  // cause of the probe; `seed` draws the random signs. Unseen residuals count as rounding. False if the Jacobian is
  // singular.
  [[nodiscard]] bool perturb(Pack& pack, const double* const (&state)[3], Probes probes, const Unseen& unseen,
                             std::uint64_t seed);

  // The same on a change point.
  void perturb(const Pack& pack, const ChangePointPosture& posture, const double* const (&state)[3], Probes probes,
               std::uint64_t seed) const;

  // Computes the changes of the unknowns that follow from changes of the inputs, to first order. changes: arrays in the
  // layout of the state. False if the Jacobian is singular.
  [[nodiscard]] bool follow(Pack& pack, const double* posture, std::span<double* const> changes);

  // Residuals and conditions at a posture.
  [[nodiscard]] GroupHealth examine(Pack& pack, const double* state);

 private:
  struct Bend {  // times * Phi''[a probe's derivative, direction]
    std::size_t probe;
    const double* direction;  // of the unknowns
    const LaneArray* inputs;
    double times;
  };
  [[nodiscard]] PackSystem system() const {
    return {work_.group_class.pattern, work_.jacobian, work_.lanes, Transpose::no};
  }
  [[nodiscard]] Evaluator& evaluator() { return evaluator_ != nullptr ? *evaluator_ : *work_.evaluator; }
  [[nodiscard]] const double* solution(const Pack& pack, const double* state, int derivative);
  void left_of(const double* y);
  void round_unknowns(const double* x);
  template <class Work>
  void with_lanes(const Work& work) const;
  void repeat(const double* from, LaneArray& to) const;
  void gather(const Pack& pack, Probes probes, std::size_t d, double* unknowns);
  [[nodiscard]] bool error_of(Pack& pack, const LaneArray& left, Probes probes, int derivative, std::uint64_t seed,
                              std::initializer_list<Bend> bends);
  void add_bend(const Pack& pack, Probes probes, const Bend& bend);

  Workspace& work_;
  JacobianSolver& solver_;
  BlockConditions& blocks_;
  // Number of probes in the lanes of evaluator(), each with W lanes; 1 for callbacks, whose cost exceeds that of all
  // lanes.
  const std::size_t side_by_side_;
  const std::size_t lanes_, size_;              // W, n x W
  const std::unique_ptr<Evaluator> evaluator_;  // null: the workspace's evaluator, for one probe at a time
  CodedChanges coded_;
  Unseen unseen_{};
  LaneArray residual_, noise_, tolerance_, whole_;                    // n x W
  LaneArray rhs_;                                                     // probes x n x W
  LaneArray error_, bent_, direction_, probe_, unknowns_;             // n x probes x W
  LaneArray coefficients_, inputs_, input_errors_, input_direction_;  // rows x probes x W
};

}  // namespace assur
