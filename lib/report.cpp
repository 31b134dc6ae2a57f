#include "assur/report.hpp"

#include <algorithm>
#include <cmath>

#include "numbers.hpp"

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
  level_by_level += o.level_by_level;
  stored_values += o.stored_values;
  return *this;
}

double ErrorFigures::residual() const { return std::fmax(position, std::fmax(velocity, acceleration)); }

void ErrorFigures::merge(const ErrorFigures& o) {
  for (const auto figure : {&ErrorFigures::position, &ErrorFigures::velocity, &ErrorFigures::acceleration}) {
    if (o.*figure > this->*figure || std::isnan(this->*figure)) this->*figure = o.*figure;
  }
  for (const auto figure :
       {&ErrorFigures::estimated_position, &ErrorFigures::estimated_velocity, &ErrorFigures::estimated_acceleration,
        &ErrorFigures::certified_radius, &ErrorFigures::forward_position, &ErrorFigures::forward_velocity,
        &ErrorFigures::forward_acceleration}) {
    // An empty figure is less than any other.
    this->*figure = std::max(this->*figure, o.*figure);
  }
}

Certificate worst_of(std::span<const Certificate> certificates) {
  Certificate worst;
  if (certificates.empty()) {
    worst.radius = kInfinity;
    worst.why_not = "there is no posture to certify";
    return worst;
  }
  const auto is_worse = [](const Certificate& a, const Certificate& b) { return a.radius < b.radius; };
  worst = *std::max_element(certificates.begin(), certificates.end(), is_worse);
  for (const Certificate& c : certificates) worst.uniqueness = std::min(worst.uniqueness, c.uniqueness);
  return worst;
}

}  // namespace assur
