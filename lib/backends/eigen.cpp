// Dense LU, one lane after the other.
#include <algorithm>
#include <cmath>
#include <new>
#include <string>
#include <vector>

#include "backends/backends.hpp"
#include "backends/dense_lu.hpp"

namespace assur::eigen {
namespace {

constexpr Index kRightSides = 4;               // solved at once
constexpr std::int32_t kMostUnknowns = 16384;  // 2 GiB for each lane

class DenseSolver final : public LinearSolver {
 public:
  Status analyze(const Pattern& pattern, int lanes) override;
  Status factorize(std::span<const double> values) override;
  Status solve(std::span<double> b_to_x, int rhs, Transpose transpose, int first_wanted) override;
  Figures figures(int lane) const override;

 private:
  Block matrix(int lane) { return {factors_.data() + lane * n_ * n_, n_, n_, n_}; }
  Code factorize_lane(std::span<const double> values, int lane);
  void solve_lane(double* b_to_x, Index columns, Transpose transpose, Index first_wanted, int lane);

  Index n_ = 0;
  int lanes_ = 0;
  std::vector<Index> place_;     // nnz: where a nonzero stands in a dense matrix
  std::vector<double> values_;   // nnz, of one lane
  std::vector<double> factors_;  // lanes x n x n, column-major: L below the diagonal, U on and above it
  std::vector<Index> pivot_;     // lanes x n
  std::vector<Index> order_;     // lanes x n: row of the matrix that became row i of the factors
  std::vector<double> right_;    // n x kRightSides
  std::vector<double> largest_;  // lanes: max |A|
  std::vector<Code> code_;       // lanes
};

Status DenseSolver::analyze(const Pattern& pattern, int lanes) {
  check_analysis(pattern, lanes);
  n_ = pattern.n;
  lanes_ = lanes;
  const auto n = static_cast<std::size_t>(n_), w = static_cast<std::size_t>(lanes);
  try {
    place_.clear();
    for (std::size_t j = 0; j < n; ++j) {
      for (auto k = pattern.column_start[j]; k < pattern.column_start[j + 1]; ++k) {
        place_.push_back(pattern.row[static_cast<std::size_t>(k)] + static_cast<Index>(j) * n_);
      }
    }
    values_.resize(place_.size());
    factors_.resize(w * n * n);
    pivot_.resize(w * n);
    order_.resize(w * n);
    right_.resize(n * kRightSides);
    largest_.assign(w, 0.0);
    code_.assign(w, Code::singular);  // until factorised
  } catch (const std::bad_alloc&) {
    throw Error(Error::Kind::environment, "no memory for " + std::to_string(lanes) + " dense factors of " +
                                              std::to_string(n) + " unknowns; use a sparse backend");
  }
  return {};
}

Status DenseSolver::factorize(std::span<const double> values) {
  check_size("values", values.size(), place_.size() * static_cast<std::size_t>(lanes_));
  for (int lane = 0; lane < lanes_; ++lane) code_[static_cast<std::size_t>(lane)] = factorize_lane(values, lane);
  return worst(code_);
}

Code DenseSolver::factorize_lane(std::span<const double> values, int lane) {
  const Block a = matrix(lane);
  double& largest = largest_[static_cast<std::size_t>(lane)];
  largest = take_lane(values, lanes_, lane, values_);
  if (!std::isfinite(largest)) return Code::not_finite;
  std::fill_n(a.data, n_ * n_, 0.0);
  for (std::size_t k = 0; k < place_.size(); ++k) a.data[place_[k]] = values_[k];

  Index* pivot = pivot_.data() + lane * n_;
  if (!eliminate(a, pivot)) return Code::singular;
  Index* order = order_.data() + lane * n_;
  for (Index i = 0; i < n_; ++i) order[i] = i;
  for (Index k = 0; k < n_; ++k) std::swap(order[k], order[pivot[k]]);
  return Code::ok;
}

Status DenseSolver::solve(std::span<double> b_to_x, int rhs, Transpose transpose, int first_wanted) {
  const auto w = static_cast<std::size_t>(lanes_);
  check_size("numbers on the right-hand side", b_to_x.size(),
             static_cast<std::size_t>(n_) * static_cast<std::size_t>(rhs) * w);
  for (int lane = 0; lane < lanes_; ++lane) {
    if (code_[static_cast<std::size_t>(lane)] != Code::ok) {
      fill_with_nan(b_to_x, lanes_, lane);
      continue;
    }
    for (Index r = 0; r < rhs; r += kRightSides) {
      solve_lane(b_to_x.data() + r * n_ * lanes_, std::min(kRightSides, rhs - r), transpose, first_wanted, lane);
    }
  }
  return worst(code_);
}

void DenseSolver::solve_lane(double* b_to_x, Index columns, Transpose transpose, Index first_wanted, int lane) {
  const Block lu = matrix(lane), x{right_.data(), n_, columns, n_};
  const Index* order = order_.data() + lane * n_;
  const auto given = [&](Index i, Index r) -> double& { return b_to_x[(r * n_ + i) * lanes_ + lane]; };
  if (transpose == Transpose::no) {  // P A = L U
    for (Index r = 0; r < columns; ++r) {
      for (Index i = 0; i < n_; ++i) x(i, r) = given(order[i], r);
    }
    solve_lower(lu, x);
    solve_upper(lu, x, first_wanted);
    for (Index r = 0; r < columns; ++r) {
      for (Index i = first_wanted; i < n_; ++i) given(i, r) = x(i, r);
    }
  } else {  // A' = U' L' P
    for (Index r = 0; r < columns; ++r) {
      for (Index i = 0; i < n_; ++i) x(i, r) = given(i, r);
    }
    solve_upper_transposed(lu, x);
    solve_lower_transposed(lu, x);
    for (Index r = 0; r < columns; ++r) {
      for (Index i = 0; i < n_; ++i) given(order[i], r) = x(i, r);
    }
  }
}

Figures DenseSolver::figures(int lane) const {
  if (code_[static_cast<std::size_t>(lane)] != Code::ok) return {};
  if (n_ == 0) return {true, 1, 1, 1};
  const double* factors = factors_.data() + lane * n_ * n_;
  const auto u = [&](Index i, Index j) { return factors[i + j * n_]; };
  double largest = 0, smallest_pivot = std::abs(u(0, 0)), largest_pivot = 0;
  int sign = 1;
  for (Index j = 0; j < n_; ++j) {
    for (Index i = 0; i <= j; ++i) largest = std::max(largest, std::abs(u(i, j)));
    smallest_pivot = std::min(smallest_pivot, std::abs(u(j, j)));
    largest_pivot = std::max(largest_pivot, std::abs(u(j, j)));
    if (u(j, j) < 0) sign = -sign;
    if (pivot_[static_cast<std::size_t>(lane * n_ + j)] != j) sign = -sign;
  }
  return {true, largest / largest_[static_cast<std::size_t>(lane)], smallest_pivot / largest_pivot, sign};
}

}  // namespace

std::string why_not(const Shape& shape, ThreadBudget) {
  if (shape.n <= kMostUnknowns) return "";
  return "dense factors of " + std::to_string(shape.n) + " unknowns are too large; the limit is " +
         std::to_string(kMostUnknowns);
}

std::unique_ptr<LinearSolver> make(ThreadBudget, Precision) { return std::make_unique<DenseSolver>(); }

std::string version() {
  return std::to_string(EIGEN_WORLD_VERSION) + "." + std::to_string(EIGEN_MAJOR_VERSION) + "." +
         std::to_string(EIGEN_MINOR_VERSION);
}

}  // namespace assur::eigen
