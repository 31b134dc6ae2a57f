// Settings of one attempt at a step, and the errors that it measured.
#pragma once

#include <algorithm>
#include <cstdint>

#include "assur/report.hpp"
#include "groups/change_point_posture.hpp"
#include "numbers.hpp"
#include "program/step_rules.hpp"

namespace assur {

// Errors of one attempt, which enter the report when the step is accepted. Negative: not measured.
struct StepErrors {
  double position = -1, velocity = -1, acceleration = -1;
  void merge(const StepErrors& o) {
    position = std::max(position, o.position);
    velocity = std::max(velocity, o.velocity);
    acceleration = std::max(acceleration, o.acceleration);
  }
  void add_to(ErrorFigures& worst) const {
    const auto raise = [](double& figure, double error) {
      if (error >= 0 && !(error <= figure)) figure = error;
    };
    raise(worst.position, position);
    raise(worst.velocity, velocity);
    raise(worst.acceleration, acceleration);
  }
  [[nodiscard]] double worst() const { return std::max({position, velocity, acceleration}); }
};

// Settings of one attempt.
struct Attempt {
  // Test that the solution is on the branch.
  enum class Branch : std::uint8_t {
    start,         // the posture is given: measure the ball around it
    inside,        // stay inside the ball
    pass,          // through a change point: the corrections must contract
    change_point,  // nothing is solved, `change_point` is the posture
    anywhere,      // no test: find out if there is a solution; the packs keep nothing
  };
  Branch branch = Branch::inside;
  std::int64_t number = 0;  // unique, from 1 on; identifies the attempt when packs undo it
  int iterations = 0;       // exact number of Newton iterations; 0: until convergence
  int most_iterations = 12;
  double converged = kConverged;  // relative residual that counts as solved
  double known_residual = 0;      // largest relative residual of the run so far; upper bounds below it are good enough
  double time = kNan;             // time of the posture relative to any fixed origin, s; NaN: unknown
  double largest_correction = 0;  // pass: a larger first correction (maximum norm) may lead to the other branch
  const ChangePointPosture* change_point = nullptr;
  bool all_rates = false;   // compute rates of all unknowns, wanted or not; accelerations of all or none
  bool makes_code = false;  // start: machine code may be made, which takes time; else only existing code is used
};

}  // namespace assur
