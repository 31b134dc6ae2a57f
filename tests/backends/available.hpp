// Backends to test, and right-hand sides for them.
#pragma once

#include <vector>

#include "assur/backend.hpp"
#include "backends/matrices.hpp"
#include "backends/symmetric_mumps.hpp"

namespace assur::test {

inline std::vector<const Backend*> available() {
  std::vector<const Backend*> rows;
  for (const Backend& backend : backends()) {
    if (backend.why_not(Shape{}, ThreadBudget{}).empty()) rows.push_back(&backend);
  }
  if (symmetric_mumps()) rows.push_back(symmetric_mumps());
  return rows;
}

inline std::vector<double> right_sides(int n, int rhs, int lanes, Random& random) {
  std::vector<double> b(static_cast<std::size_t>(n * rhs * lanes));
  for (double& element : b) element = nonzero(random);
  return b;
}

}  // namespace assur::test
