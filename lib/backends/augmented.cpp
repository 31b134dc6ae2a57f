#include "backends/augmented.hpp"

#include <algorithm>
#include <cstddef>

#include "backends/backends.hpp"
#include "backends/lane_by_lane.hpp"

namespace assur {
namespace {

class AugmentedSolver final : public LaneByLane {
 public:
  explicit AugmentedSolver(std::unique_ptr<SymmetricSolver> (*make)()) : make_(make) {}

 private:
  void analyze_lanes(const Pattern& pattern, int lanes) override;
  Code factorize_lane(std::span<const double> values, int lane) override;
  void solve_lane(std::span<double> b_to_x, int rhs, Transpose transpose, int lane) override;
  [[nodiscard]] Figures lane_figures(int) const override { return {true, 0, 0, 0}; }

  std::unique_ptr<SymmetricSolver> (*make_)();
  std::size_t n_ = 0;
  std::vector<int> row_, column_;  // nnz: of K, from 1 on
  std::vector<double> both_;       // 2n x kRightSides
  std::vector<std::unique_ptr<SymmetricSolver>> lanes_;
};

void AugmentedSolver::analyze_lanes(const Pattern& pattern, int lanes) {
  lanes_.clear();  // they refer to row_ and column_
  n_ = static_cast<std::size_t>(pattern.n);
  row_.clear();
  column_.clear();
  for (int j = 0; j < pattern.n; ++j) {
    for (auto k = pattern.column_start[static_cast<std::size_t>(j)];
         k < pattern.column_start[static_cast<std::size_t>(j) + 1]; ++k) {
      row_.push_back(pattern.row[static_cast<std::size_t>(k)] + 1);
      column_.push_back(pattern.n + j + 1);
    }
  }
  both_.resize(2 * n_ * kRightSides);
  for (int lane = 0; lane < lanes; ++lane) lanes_.emplace_back(make_())->analyze(2 * pattern.n, row_, column_);
}

Code AugmentedSolver::factorize_lane(std::span<const double> values, int lane) {
  return lanes_[static_cast<std::size_t>(lane)]->factorize(values);
}

void AugmentedSolver::solve_lane(std::span<double> b_to_x, int rhs, Transpose transpose, int lane) {
  const std::size_t given = transpose == Transpose::no ? 0 : n_, wanted = n_ - given;
  const auto columns = static_cast<std::size_t>(rhs);
  for (std::size_t r = 0; r < columns; r += kRightSides) {
    const std::size_t count = std::min<std::size_t>(kRightSides, columns - r);
    double* const b = b_to_x.data() + r * n_;
    const std::span<double> both = std::span(both_).first(2 * n_ * count);
    std::fill(both.begin(), both.end(), 0.0);
    for (std::size_t c = 0; c < count; ++c) std::copy_n(b + c * n_, n_, both.data() + 2 * c * n_ + given);
    lanes_[static_cast<std::size_t>(lane)]->solve(both, static_cast<int>(count));
    for (std::size_t c = 0; c < count; ++c) std::copy_n(both.data() + 2 * c * n_ + wanted, n_, b + c * n_);
  }
}

}  // namespace

std::unique_ptr<LinearSolver> make_augmented(std::unique_ptr<SymmetricSolver> (*make_symmetric)()) {
  return std::make_unique<AugmentedSolver>(make_symmetric);
}

}  // namespace assur
