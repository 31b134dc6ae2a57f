#include "side_by_side/recipe.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "index.hpp"
#include "numbers.hpp"
#include "scene/outputs.hpp"
#include "signals/drive_program.hpp"

namespace assur {
namespace {

// Calls use(number, unit) for each number of a system, but those of laws; numbers are about as large as the unit.
// Guesses of driven coordinates follow from laws.
template <class OfSystem, class Use>
void each_number(OfSystem& s, const Use& use) {
  for (auto& constant : s.constants) use(constant, 1.0);
  for (std::size_t c = 0; c < s.guess.size(); ++c) {
    if (s.coordinates[c].role == Role::unknown) use(s.guess[c], 1.0);
  }
  for (auto& in : s.inputs) {
    use(in.zero, s.unit(in.dimension));
    for (std::size_t k = 0; k < in.written.size(); ++k) {
      use(in.written[k], is_angle(s, in, static_cast<int>(k)) ? 1.0 : s.unit(in.dimension));
    }
  }
  for (auto& bound : s.bounds) use(bound.value, s.unit(s.measures[idx(bound.measure)].dimension));
  for (auto& measure : s.measures) {
    use(measure.constant, s.unit(measure.dimension));
    for (auto& term : measure.terms) use(term.factor, 1.0);
  }
}

// Calls use(number) for each number of the parts of a law.
template <class Parts, class Use>
void each_number_of_law(Parts& parts, const Use& use) {
  for (auto& part : parts) {
    if (auto* polynomial = std::get_if<Law::Polynomial>(&part)) {
      for (auto& c : polynomial->coefficients) use(c);
    } else if (auto* harmonics = std::get_if<Law::Harmonics>(&part)) {
      use(harmonics->offset);
      for (auto& term : harmonics->terms) use(term.amplitude), use(term.frequency), use(term.phase);
    } else if (auto* spline = std::get_if<Law::Spline>(&part)) {
      for (auto* list : {&spline->time, &spline->value, &spline->second}) {
        for (auto& x : *list) use(x);
      }
    }
  }
}

// A number with the size of numbers of its kind.
struct Sized {
  double number, unit;
};

std::vector<Sized> all_numbers(const System& s) {
  std::vector<Sized> all;
  each_number(s, [&](double x, double unit) { all.push_back({x, unit}); });
  for (const DriverInput& in : s.inputs) {
    for (std::size_t k = 0; k < in.laws.size(); ++k) {
      const double unit = is_angle(s, in, static_cast<int>(k)) ? 1 : s.unit(in.dimension);
      each_number_of_law(in.laws[k].parts(), [&](double x) { all.push_back({x, unit}); });
    }
  }
  return all;
}

// Numbers that are only rounding are not on a tape.
bool same_but_for_rounding(const Sized& a, const Sized& b) {
  if (std::isnan(a.number) || std::isnan(b.number)) return std::isnan(a.number) && std::isnan(b.number);
  return std::abs(a.number - b.number) <= 32 * kEps * std::max({a.unit, std::abs(a.number), std::abs(b.number)});
}

}  // namespace

Recipe::Recipe(const Tape& tape, const System& system, std::string& why_not) {
  std::vector<std::uint8_t> depends(system.constants.size(), 0);
  std::size_t number = 0;
  each_number(system, [&](double x, double) {
    if (const Tape::Node node = tape.find(x); node != Tape::kNone) {
      numbers_.push_back(number);
      nodes_.push_back(node);
      if (number < depends.size()) depends[number] = 1;
    }
    ++number;
  });
  for (std::size_t i = 0; i < system.inputs.size(); ++i) {
    const DriverInput& in = system.inputs[i];
    has_written_ = has_written_ || std::any_of(in.written.begin(), in.written.end(),
                                               [&](double x) { return tape.find(x) != Tape::kNone; });
    for (std::size_t k = 0; k < in.laws.size(); ++k) {
      OfLaw law{i, k, {}};
      const std::vector<Law::Part>& parts = in.laws[k].parts();
      std::size_t at = 0;
      each_number_of_law(parts, [&](double x) {
        if (const Tape::Node node = tape.find(x); node != Tape::kNone) {
          law.numbers.push_back(at);
          nodes_.push_back(node);
        }
        ++at;
      });
      if (law.numbers.empty()) continue;
      laws_.push_back(std::move(law));
      for (const Law::Part& part : parts) {
        if (!std::holds_alternative<Law::Spline>(part)) continue;
        why_not = "the law of driver " + system.drivers[idx(in.driver)] + " has a table and depends on the values";
      }
    }
  }

  const auto form_depends = [&](Index form) {
    const auto terms = system.form(form);
    return std::any_of(terms.begin(), terms.end(), [&](const Term& t) { return depends[idx(t.constant)] != 0; });
  };
  for (const Output& output : wanted_outputs(system)) {
    has_outputs_ = has_outputs_ || output.sum != nullptr;
    for (const OutputPart& part : output.parts()) {
      has_outputs_ = has_outputs_ || std::any_of(part.forms.begin(), part.forms.end(), form_depends);
    }
  }
  has_assignments_ = std::any_of(system.assignments.begin(), system.assignments.end(),
                                 [&](const Assignment& a) { return form_depends(a.form); });
}

Recipe::Target::Target(const Recipe& recipe, System& system) {
  std::vector<double*> all;
  each_number(system, [&](double& x, double) { all.push_back(&x); });
  for (const std::size_t i : recipe.numbers_) numbers_.push_back(all[i]);
  for (const Recipe::OfLaw& of : recipe.laws_) {
    Law& law = system.inputs[of.input].laws[of.law];
    laws_.push_back({&law, law.parts(), {}});
    all.clear();
    each_number_of_law(laws_.back().parts, [&](double& x) { all.push_back(&x); });
    for (const std::size_t i : of.numbers) laws_.back().numbers.push_back(all[i]);
  }
}

void Recipe::Target::set(const Replay& replay, std::size_t lane, std::size_t first) {
  std::size_t i = first;
  for (double* const number : numbers_) *number = replay.wanted(i++)[lane];
  for (OfLaw& of : laws_) {
    for (double* const number : of.numbers) *number = replay.wanted(i++)[lane];
    *of.law = Law(of.parts);
  }
}

bool Recipe::same_numbers(const System& a, const System& b) {
  const std::vector<Sized> of_a = all_numbers(a), of_b = all_numbers(b);
  return a.length_exponent == b.length_exponent &&
         std::equal(of_a.begin(), of_a.end(), of_b.begin(), of_b.end(), same_but_for_rounding);
}

}  // namespace assur
