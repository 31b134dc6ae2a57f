#include "assur/report.hpp"

#include <algorithm>

namespace assur {

Counters& Counters::operator+=(const Counters& o) {
  steps += o.steps;
  substeps += o.substeps;
  rejected += o.rejected;
  group_solutions += o.group_solutions;
  newton_iterations += o.newton_iterations;
  most_iterations = std::max(most_iterations, o.most_iterations);
  evaluated_equations += o.evaluated_equations;
  factorizations += o.factorizations;
  factorized_unknowns += o.factorized_unknowns;
  solved_unknowns += o.solved_unknowns;
  branch_checks += o.branch_checks;
  stored_values += o.stored_values;
  return *this;
}

void ErrorFigures::merge(const ErrorFigures& o) {
  position = std::max(position, o.position);
  velocity = std::max(velocity, o.velocity);
  acceleration = std::max(acceleration, o.acceleration);
}

}  // namespace assur
