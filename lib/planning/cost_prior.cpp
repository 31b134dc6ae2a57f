#include "planning/cost_prior.hpp"

#include <algorithm>
#include <cmath>

namespace assur {

double expected_seconds(const Shape& shape, const Strategy& strategy) {
  const double n = shape.n, nonzeros = shape.nnz, lanes = strategy.lanes;
  const double vectors = std::ceil(lanes / 8);
  const double equations = 0.1e-6 + 10e-9 * nonzeros * vectors;
  if (strategy.backend == "lanes") return equations + 50e-9 * n * vectors;
  const bool dense = strategy.backend == "eigen" || strategy.backend == "lapack" || strategy.backend == "team";
  const double factor = dense ? n * n * n / 6e9 + 20e-9 * n : 15e-9 * nonzeros + 40e-9 * n;
  const double solution = dense ? n * n / 2e9 + 10e-9 * n : 5e-9 * nonzeros + 20e-9 * n;
  return equations + lanes * (2 * factor + 3 * solution) / std::max(1, strategy.q);
}

}  // namespace assur
