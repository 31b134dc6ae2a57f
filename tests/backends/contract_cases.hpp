// The table of the contract test: matrices, and the status that each backend must return.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "assur/backend.hpp"
#include "backends/matrices.hpp"

namespace assur::test {

enum class Outcome {
  solved,      // ok, with a normwise backward error of at most 10 n eps
  grows,       // ok; growth may spoil the solution in double, but refinement brings it within 10 n eps
  singular,    // refused
  not_finite,  // refused
  either,      // singular, or solved
};

struct Case {
  std::string name;
  std::function<Matrix(Random&)> lane;  // makes one lane; the pattern is the same at every call
  Outcome outcome = Outcome::solved;
  std::map<std::string_view, Outcome> except = {};  // backends with another outcome
  double condition = 0;  // rough condition in the maximum norm; 0: below 1e10 after scaling of rows and columns
  double growth = 0;     // partial pivoting in the natural order has at least this growth

  [[nodiscard]] Outcome expected(std::string_view id) const {
    const auto found = except.find(id);
    return found == except.end() ? outcome : found->second;
  }
};
const std::vector<Case>& cases();

// Figures that a backend must report with `ok`.
struct Told {
  bool growth = true, condition = true, sign = true;
  bool partial_pivoting = false;  // in the natural order of the columns
};
Told told_by(std::string_view id);

}  // namespace assur::test
