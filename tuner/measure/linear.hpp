// The kernels `factor` and `solve`: a linear solver in its steady state, as a mechanism in motion asks it.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "assur/backend.hpp"
#include "assur/strategy.hpp"
#include "measure/matrices.hpp"
#include "measure/workload.hpp"

namespace assur::measure {

class Linear {
 public:
  // The solver of a strategy (backend, W, precision, refinement, q) with its analysis and first factorisation done, and
  // its solutions held against known ones. Each lane has the matrix of another group, as far as they go.
  Linear(const Matrices& matrices, const Strategy& strategy, const Backend& backend);
  ~Linear();

  // Why it is not to be timed: its status, or an error that no user would accept; "": it may be.
  [[nodiscard]] const std::string& refused() const { return refused_; }
  // |A x - b| / (|A| |x| + |b|) and |x - x_ref| / |x_ref|, maximum norms, the worst lane of all sets of values.
  [[nodiscard]] double backward_error() const { return backward_; }
  [[nodiscard]] double forward_error() const { return forward_; }

  // One factorisation of all lanes, of the next set of values; one solution with one right-hand side of each lane.
  [[nodiscard]] Workload& factor() { return *factor_; }
  [[nodiscard]] Workload& solve() { return *solve_; }

 private:
  class Factor;
  class Solve;
  void draw_values(const Matrices& matrices);
  void verify(const Matrices& matrices);
  [[nodiscard]] bool check(const Matrices& matrices, const std::vector<double>& values);

  int lanes_;
  std::unique_ptr<LinearSolver> solver_;
  std::vector<std::vector<double>> values_;  // sets x (nnz x lanes)
  std::vector<double> right_, x_;            // n x lanes
  std::string refused_;
  double backward_ = 0, forward_ = 0;
  std::unique_ptr<Workload> factor_, solve_;
};

}  // namespace assur::measure
