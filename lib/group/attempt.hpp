// How a step is to be solved, and what of it was measured.
#pragma once

#include <algorithm>
#include <cstdint>

#include "assur/report.hpp"
#include "group/step_rules.hpp"
#include "numbers.hpp"

namespace assur {

// Errors of one attempt; merged into the report when the step is accepted. Less than 0: nothing was measured.
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

struct Attempt {
  enum class Branch : std::uint8_t {
    start,     // the posture is given: measure the ball around it
    inside,    // stay inside the ball
    pass,      // through a change point: corrections have to contract
    anywhere,  // is there a solution at all? nothing is kept
  };
  Branch branch = Branch::inside;
  std::int64_t number = 0;  // its own, from 1 on: by it a rejected attempt is undone in the packs
  int iterations = 0;       // exactly so many; 0: until convergence
  int most_iterations = 12;
  double converged = kConverged;  // relative residual that counts as solved
  double time = kNan;             // s, of the posture, or from any beginning; NaN: not known
  double largest_correction = 0;  // pass: the first one, in the maximum norm; a larger one may lead to the other branch
  bool all_rates = false;         // of all unknowns, also where none are wanted; accelerations of all if of some
};

}  // namespace assur
