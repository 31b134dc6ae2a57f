// Errors of a solved pack: residuals, conditions, and the errors of the unknowns that follow from errors of the inputs,
// of the equations and of rounding.
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <span>

#include "backends/residual.hpp"
#include "group/branch.hpp"
#include "group/jacobian_solver.hpp"
#include "group/workspace.hpp"

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

// Relative residuals and conditions (GroupFigures) of the lanes of a pack.
struct GroupHealth {
  std::array<double, kMostLanes> residual{}, condition{};
};

// Probes the packs of one class.
class ErrorProbe {
 public:
  ErrorProbe(Workspace& work, JacobianSolver& solver, BlockConditions& blocks);

  // For each probe, computes the errors of the unknowns, to first order, from the errors of the inputs and from the
  // cause of the probe; `seed` draws the random signs. False if the Jacobian is singular.
  [[nodiscard]] bool perturb(Pack& pack, const double* const (&state)[3], Probes probes, std::uint64_t seed);

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
    return {work_.program.pattern, work_.jacobian, work_.lanes, Transpose::no};
  }
  [[nodiscard]] const double* solution(const Pack& pack, const double* state, int derivative);
  void left_of(const double* y);
  void round_unknowns(const double* x);
  [[nodiscard]] bool error_of(Pack& pack, const LaneArray& left, Probes probes, int derivative, std::uint64_t seed,
                              std::initializer_list<Bend> bends);
  void add_bend(const Pack& pack, const double* probe, const Bend& bend);

  Workspace& work_;
  JacobianSolver& solver_;
  BlockConditions& blocks_;
  LaneArray residual_, noise_, tolerance_, error_, bent_, moved_, whole_;  // n x W
  LaneArray input_errors_, moved_inputs_, resting_inputs_;                 // inputs x W
};

}  // namespace assur
