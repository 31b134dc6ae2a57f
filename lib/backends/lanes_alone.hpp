// One lane that the pivots of its class do not serve, factorised in double with pivots of its own.
#pragma once

#include <memory>
#include <span>

#include "assur/backend.hpp"
#include "backends/lanes_factors.hpp"

namespace assur::lanes {

class LaneAlone {
 public:
  explicit LaneAlone(std::shared_ptr<const Pattern> pattern);

  // values: nnz, finite. Keeps to the pivots of the last time while they are good, else chooses new ones, which takes
  // memory. ok or singular.
  [[nodiscard]] Code factorize(std::span<const double> values);
  void solve(double* b_to_x, int rhs, Transpose transpose, int first_wanted) {
    factors_.solve(b_to_x, rhs, transpose, first_wanted);
  }
  [[nodiscard]] Figures figures() const { return factors_.figures(0); }

 private:
  std::shared_ptr<const Pattern> pattern_;
  Limits limits_;
  Factors factors_;
  bool good_ = false;  // the pivots, at the last factorisation
};

}  // namespace assur::lanes
