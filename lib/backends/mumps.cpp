// Multifrontal LU by MUMPS, sequential version, on one thread at a time. Each lane is a matrix of its own with its own
// analysis, because MUMPS keeps analysis and factors together.
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "backends/backends.hpp"
#include "backends/lane_by_lane.hpp"
#include "backends/mumps_matrix.hpp"
#include "parallel/thread_state.hpp"

namespace assur::mumps {
namespace {

class MumpsSolver final : public LaneByLane {
  void analyze_lanes(const Pattern& pattern, int lanes) override {
    lanes_.clear();  // they refer to row_ and column_
    row_.clear();
    column_.clear();
    for (int j = 0; j < pattern.n; ++j) {
      for (auto k = pattern.column_start[static_cast<std::size_t>(j)];
           k < pattern.column_start[static_cast<std::size_t>(j) + 1]; ++k) {
        row_.push_back(pattern.row[static_cast<std::size_t>(k)] + 1);
        column_.push_back(j + 1);
      }
    }
    for (int lane = 0; lane < lanes; ++lane) {
      lanes_.push_back(std::make_unique<Matrix>(Symmetry::none));
      lanes_.back()->analyze(pattern.n, row_, column_);
    }
  }
  Code factorize_lane(std::span<const double> values, int lane) override { return matrix(lane).factorize(values); }
  void solve_lane(std::span<double> b_to_x, int rhs, Transpose transpose, int lane) override {
    matrix(lane).solve(b_to_x, rhs, transpose);
  }
  // MUMPS may take small pivots first, so the ratio of pivots says little about the condition.
  [[nodiscard]] Figures lane_figures(int lane) const override {
    Figures figures = matrix(lane).figures();
    figures.reciprocal_condition = std::min(figures.reciprocal_condition, matrix(lane).reciprocal_condition());
    return figures;
  }

  [[nodiscard]] Matrix& matrix(int lane) const { return *lanes_[static_cast<std::size_t>(lane)]; }

  std::vector<int> row_, column_;  // nnz: counted from 1, as in Fortran
  std::vector<std::unique_ptr<Matrix>> lanes_;
};

}  // namespace

std::string why_not(const Shape&, ThreadBudget budget) {
  if (budget.threads <= 1) return why_not_blas_memory();
  return "the sequential MUMPS runs on one thread";
}

std::unique_ptr<LinearSolver> make(ThreadBudget, Precision) { return std::make_unique<MumpsSolver>(); }

std::string version() { return MUMPS_VERSION; }

}  // namespace assur::mumps
