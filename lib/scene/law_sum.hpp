// The sum of many laws, multiples of a law, and its value as a number of the scene.
#pragma once

#include <span>
#include <variant>
#include <vector>

#include "assur/law.hpp"
#include "overloaded.hpp"

namespace assur {

// Adds the two halves, recursively: each addition copies all parts, so that adding one law after another would take
// quadratic time.
[[nodiscard]] inline Law sum_of(std::span<const Law> laws) {
  if (laws.empty()) return {};
  if (laws.size() == 1) return laws.front();
  const std::size_t half = laws.size() / 2;
  return sum_of(laws.first(half)) + sum_of(laws.subspan(half));
}

// The law times a factor; not for functions of the program. Throws Error (input) if a number overflows.
[[nodiscard]] inline Law times(double factor, const Law& law) {
  const auto scaled = [&](auto numbers) {
    for (auto& x : numbers) x *= factor;
    return numbers;
  };
  const Overloaded times_factor{
      [&](const Law::Polynomial& p) { return Law::polynomial(scaled(p.coefficients)); },
      [&](const Law::Harmonics& h) {
        std::vector<Harmonic> terms = h.terms;
        for (Harmonic& term : terms) term.amplitude *= factor;
        return Law::harmonics(std::move(terms), factor * h.offset);
      },
      [&](const Law::Spline& s) { return Law::table(s.time, scaled(s.value), s.periodic, s.monotone); },
      [](const Law::Function&) { return Law(); },
  };
  std::vector<Law> parts;
  for (const Law::Part& part : law.parts()) parts.push_back(std::visit(times_factor, part));
  return sum_of(parts);
}

// The value at time t. That of a constant has its origin.
[[nodiscard]] inline Number value_of(const Law& law, double t) {
  Number sum = 0;
  for (const Law::Part& part : law.parts()) {
    const auto* constant = std::get_if<Law::Polynomial>(&part);
    if (constant == nullptr || constant->coefficients.size() > 1) return law(t).value;
    if (!constant->coefficients.empty()) sum += constant->coefficients[0];
  }
  return sum;
}

}  // namespace assur
