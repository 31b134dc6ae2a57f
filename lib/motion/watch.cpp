#include "motion/watch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "program/step_rules.hpp"

namespace assur {

Watch::Watch(const System& system, const GroupedSystem& structure, std::span<const std::int32_t> address)
    : class_(structure.watch_class),
      evaluator_(make_evaluator(system, class_, 1)),
      coefficients_(class_.coefficients.size()),
      inputs_(structure.watch.inputs.size()),
      phi_(structure.watch_class.equations.size()),
      scale_(phi_.size()) {
  std::vector<double> constants;
  for (const std::int32_t k : structure.watch.constants)
    constants.push_back(system.constants[static_cast<std::size_t>(k)]);
  bind_coefficients(class_, constants.data(), coefficients_.data(), 1);
  for (const std::int32_t c : structure.watch.inputs) addresses_.push_back(address[static_cast<std::size_t>(c)]);
}

double Watch::residual(const double* q) {
  for (std::size_t i = 0; i < inputs_.size(); ++i) inputs_[i] = q[addresses_[i]];
  evaluator_->set_inputs(coefficients_.data(), inputs_.data());
  evaluator_->evaluate(nullptr, phi_.data(), nullptr);
  evaluator_->scale(scale_.data());
  const double of_terms = worst_ratio();
  if (of_terms <= kConverged) return of_terms;
  evaluator_->raise_scale(scale_.data());
  return worst_ratio();
}

double Watch::worst_ratio() {
  double worst = 0;
  for (std::size_t i = 0; i < phi_.size(); ++i) {
    const double r = scale_[i] > 0 ? std::abs(phi_[i]) / scale_[i] : std::abs(phi_[i]);
    if (!(r <= worst)) {
      worst = r;
      worst_ = i;
    }
  }
  return worst;
}

// Slopes are central differences, which are exact for quadratic equations.
double Watch::violation(const double* q) {
  constexpr double kStep = 0x1p-16;  // internal units; a power of 2, so that sums with it round little
  const auto phi = [&] {
    evaluator_->set_inputs(coefficients_.data(), inputs_.data());
    evaluator_->evaluate(nullptr, phi_.data(), nullptr);
    return phi_[worst_];
  };
  for (std::size_t i = 0; i < inputs_.size(); ++i) inputs_[i] = q[addresses_[i]];
  double sum = 0;
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    const double at = inputs_[i];
    inputs_[i] = at + kStep;
    const double after = phi();
    inputs_[i] = at - kStep;
    const double slope = (after - phi()) / (2 * kStep);
    inputs_[i] = at;
    sum += slope * slope;
  }
  return std::abs(phi()) / std::max(std::sqrt(sum), std::numeric_limits<double>::min());
}

}  // namespace assur
