// One lane for which the common pivots fail, factorised in double with its own pivots.
#pragma once

#include <memory>
#include <span>

#include "assur/backend.hpp"
#include "backends/lanes_factors.hpp"

namespace assur::lanes {

class LaneAlone {
 public:
  // The memory must outlive it.
  LaneAlone(std::shared_ptr<const Pattern> pattern, PivotMemory& memory);

  // Returns ok or singular. values: nnz, finite. Keeps the pivots of the last call while they are good; else chooses
  // new ones.
  [[nodiscard]] Code factorize(std::span<const double> values);
  // Drops the pivots.
  void forget() {
    factors_.forget();
    good_ = false;
  }
  void solve(double* b_to_x, int rhs, Transpose transpose, int first_wanted) {
    factors_.solve(b_to_x, rhs, transpose, first_wanted);
  }
  [[nodiscard]] Figures figures() const { return factors_.figures(0); }

 private:
  std::shared_ptr<const Pattern> pattern_;
  PivotMemory& memory_;
  Limits limits_;
  Factors factors_;
  bool good_ = false;  // the pivots were good at the last factorisation
};

}  // namespace assur::lanes
