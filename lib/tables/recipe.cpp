#include "tables/recipe.hpp"

#include <algorithm>
#include <type_traits>
#include <utility>
#include <variant>

#include "equations/outputs.hpp"
#include "index.hpp"

namespace assur {
namespace {

// Calls use(number) for each number of a system, but those of laws: with its origin, or with a place that receives its
// value. Guesses of driven coordinates follow from laws.
template <class OfSystem, class Use>
void each_number(OfSystem& s, const Use& use) {
  constexpr bool kOrigins = std::is_const_v<OfSystem>;
  for (std::size_t c = 0; c < s.constants.size(); ++c) {
    if constexpr (kOrigins) {
      use(s.constant(static_cast<Index>(c)));
    } else {
      use(s.constants[c]);
    }
  }
  for (std::size_t c = 0; c < s.guess.size(); ++c) {
    if (s.coordinates[c].role != Role::unknown) continue;
    if constexpr (kOrigins) {
      use(s.guess_of(static_cast<Index>(c)));
    } else {
      use(s.guess[c]);
    }
  }
  for (auto& in : s.inputs) {
    use(in.zero);
    for (auto& value : in.written) use(value);
  }
  for (auto& bound : s.bounds) use(bound.value);
  for (auto& measure : s.measures) {
    use(measure.constant);
    for (auto& term : measure.terms) use(term.factor);
  }
}

// Calls use(number) for each number of the parts of a law; tables have none that follow from parameters.
template <class Parts, class Use>
void each_number_of_law(Parts& parts, const Use& use) {
  const auto use_part = [&](auto& part) {
    using Part = std::remove_cvref_t<decltype(part)>;
    if constexpr (std::is_same_v<Part, Law::Polynomial>) {
      for (auto& c : part.coefficients) use(c);
    } else if constexpr (std::is_same_v<Part, Law::Harmonics>) {
      use(part.offset);
      for (auto& term : part.terms) use(term.amplitude), use(term.frequency), use(term.phase);
    } else {
      static_assert(std::variant_size_v<Law::Part> == 4);  // tables and functions have no such numbers
    }
  };
  for (auto& part : parts) std::visit(use_part, part);
}

}  // namespace

Recipe::Recipe(const Tape& tape, const System& system) {
  std::vector<std::uint8_t> depends(system.constants.size(), 0);
  std::size_t number = 0;
  each_number(system, [&](const Number& x) {
    if (tape.has(x)) {
      numbers_.push_back(number);
      wanted_.push_back(x);
      if (number < depends.size()) depends[number] = 1;
    }
    ++number;
  });
  for (std::size_t i = 0; i < system.inputs.size(); ++i) {
    const DriverInput& in = system.inputs[i];
    has_written_ =
        has_written_ || std::any_of(in.written.begin(), in.written.end(), [&](const Number& x) { return tape.has(x); });
    for (std::size_t k = 0; k < in.laws.size(); ++k) {
      OfLaw law{i, k, {}};
      const std::vector<Law::Part>& parts = in.laws[k].parts();
      std::size_t at = 0;
      each_number_of_law(parts, [&](const Number& x) {
        if (tape.has(x)) {
          law.numbers.push_back(at);
          wanted_.push_back(x);
        }
        ++at;
      });
      if (!law.numbers.empty()) laws_.push_back(std::move(law));
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
  std::vector<double*> doubles;
  std::vector<Number*> numbers;
  const auto keep = [&](auto& x) {
    if constexpr (std::is_same_v<decltype(x), double&>) {
      doubles.push_back(&x);
    } else {
      numbers.push_back(&x);
    }
  };
  each_number(system, keep);
  for (const std::size_t i : recipe.numbers_) {
    if (i < doubles.size()) {
      doubles_.push_back(doubles[i]);
    } else {
      numbers_.push_back(numbers[i - doubles.size()]);
    }
  }
  for (const Recipe::OfLaw& of : recipe.laws_) {
    Law& law = system.inputs[of.input].laws[of.law];
    laws_.push_back({&law, law.parts(), {}});
    std::vector<Number*> of_law;
    each_number_of_law(laws_.back().parts, [&](Number& x) { of_law.push_back(&x); });
    for (const std::size_t i : of.numbers) laws_.back().numbers.push_back(of_law[i]);
  }
}

void Recipe::Target::set(const Replay& replay, std::size_t lane, std::size_t first) {
  std::size_t i = first;
  for (double* const number : doubles_) *number = replay.wanted(i++)[lane];
  for (Number* const number : numbers_) *number = replay.wanted(i++)[lane];
  for (OfLaw& of : laws_) {
    for (Number* const number : of.numbers) *number = replay.wanted(i++)[lane];
    *of.law = Law(of.parts);
  }
}

}  // namespace assur
