// The kernels `factor` and `solve`: a linear solver in its steady state, used as by a mechanism in motion.
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
  // Makes the solver of a strategy (backend, W, precision, refinement, Q), analyses and factorises once, and compares
  // its solutions with known ones. Each lane has the matrix of another group, if there are enough.
  Linear(const Matrices& matrices, const Strategy& strategy, const Backend& backend);
  ~Linear();

  // The reason why it must not be timed: its status, or too large an error; "": it may be timed.
  [[nodiscard]] const std::string& refused() const { return refused_; }
  // Largest |A x - b| / (|A| |x| + |b|) and |x - x_ref| / |x_ref| of all lanes and sets of values, maximum norms.
  [[nodiscard]] double backward_error() const { return backward_; }
  [[nodiscard]] double forward_error() const { return forward_; }

  // A call of factor() factorises all lanes with the next set of values; a call of solve() solves one right-hand side
  // in each lane.
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
