#include "backends/dense_solver.hpp"

#include <algorithm>
#include <cmath>
#include <new>
#include <type_traits>
#include <vector>

#include "backends/backends.hpp"

namespace assur {
namespace {

constexpr std::int32_t kMostDenseUnknowns = 16384;  // 2 GiB for each lane, in double

// Exponent of the largest of n numbers, limited so that two to its power and the inverse are normal numbers; 0 if all
// are zero or one is not finite.
int exponent_of(const double* b, DenseIndex n, DenseIndex step) {
  double largest = 0;
  for (DenseIndex i = 0; i < n; ++i) largest = std::max(largest, std::abs(b[i * step]));
  return largest > 0 && std::isfinite(largest) ? std::clamp(std::ilogb(largest), -1000, 1000) : 0;
}

}  // namespace

std::vector<DenseIndex> dense_places(const Pattern& pattern, DenseIndex stride) {
  std::vector<DenseIndex> place;
  place.reserve(pattern.row.size());
  for (std::size_t j = 0; j < static_cast<std::size_t>(pattern.n); ++j) {
    for (auto k = pattern.column_start[j]; k < pattern.column_start[j + 1]; ++k) {
      place.push_back(pattern.row[static_cast<std::size_t>(k)] + static_cast<DenseIndex>(j) * stride);
    }
  }
  return place;
}

template <class T>
double spread(const double* values, DenseIndex lanes, std::span<const DenseIndex> place, T* a) {
  T largest = 0, poison = 0;  // poison: 0 as long as every value is finite, else NaN
  for (const DenseIndex at : place) {
    const T value = static_cast<T>(*values);
    a[at] = value;
    largest = std::max(largest, std::abs(value));
    poison += value * 0;
    values += lanes;
  }
  return largest + poison;
}

template <class T>
int take_right_side(const double* b, DenseIndex step, DenseIndex n, T* x) {
  if constexpr (std::is_same_v<T, double>) {
    for (DenseIndex i = 0; i < n; ++i) x[i] = b[i * step];
    return 0;
  } else {
    const int exponent = exponent_of(b, n, step);
    const double scale = std::ldexp(1.0, -exponent);
    for (DenseIndex i = 0; i < n; ++i) x[i] = static_cast<T>(b[i * step] * scale);
    return exponent;
  }
}

template <class T>
void give_solution(const T* x, DenseIndex n, int exponent, DenseIndex first, double* b, DenseIndex step) {
  if constexpr (std::is_same_v<T, double>) {
    for (DenseIndex i = first; i < n; ++i) b[i * step] = x[i];
  } else {
    const double scale = std::ldexp(1.0, exponent);
    for (DenseIndex i = first; i < n; ++i) b[i * step] = x[i] * scale;
  }
}

template <class T>
Figures dense_figures(const Block<T>& lu, const std::int32_t* pivot, double largest_of_matrix) {
  const auto u = [&](DenseIndex i, DenseIndex j) { return static_cast<double>(lu(i, j)); };
  double largest = 0, smallest_pivot = std::abs(u(0, 0)), largest_pivot = 0;
  int sign = 1;
  for (DenseIndex j = 0; j < lu.columns; ++j) {
    for (DenseIndex i = 0; i <= j; ++i) largest = std::max(largest, std::abs(u(i, j)));
    smallest_pivot = std::min(smallest_pivot, std::abs(u(j, j)));
    largest_pivot = std::max(largest_pivot, std::abs(u(j, j)));
    if (u(j, j) < 0) sign = -sign;
    if (pivot[j] != j + 1) sign = -sign;
  }
  return {true, largest / largest_of_matrix, smallest_pivot / largest_pivot, sign};
}

template double spread(const double*, DenseIndex, std::span<const DenseIndex>, double*);
template double spread(const double*, DenseIndex, std::span<const DenseIndex>, float*);
template int take_right_side(const double*, DenseIndex, DenseIndex, double*);
template int take_right_side(const double*, DenseIndex, DenseIndex, float*);
template void give_solution(const double*, DenseIndex, int, DenseIndex, double*, DenseIndex);
template void give_solution(const float*, DenseIndex, int, DenseIndex, double*, DenseIndex);
template Figures dense_figures(const Block<double>&, const std::int32_t*, double);
template Figures dense_figures(const Block<float>&, const std::int32_t*, double);

namespace {

template <class T>
class DenseSolver final : public LinearSolver {
 public:
  explicit DenseSolver(std::unique_ptr<DenseLu<T>> lu) : lu_(std::move(lu)) {}
  Status analyze(const Pattern& pattern, int lanes) override;
  Status factorize(std::span<const double> values) override;
  Status solve(std::span<double> b_to_x, int rhs, Transpose transpose, int first_wanted) override;
  Figures figures(int lane) const override;

 private:
  Block<T> matrix(int lane) { return {factors_.data() + lane * n_ * n_, n_, n_, n_}; }
  std::int32_t* pivot(int lane) { return pivot_.data() + lane * n_; }
  Code factorize_lane(const double* values, int lane);
  void solve_lane(double* b_to_x, DenseIndex columns, Transpose transpose, DenseIndex first_wanted, int lane);

  std::unique_ptr<DenseLu<T>> lu_;
  DenseIndex n_ = 0;
  int lanes_ = 0;
  std::vector<DenseIndex> place_;    // nnz: place of each nonzero in a dense matrix
  std::vector<T> factors_;           // lanes x n x n, column-major: L below the diagonal, U on and above it
  std::vector<std::int32_t> pivot_;  // lanes x n
  std::vector<T> right_;             // n x kRightSides
  std::vector<double> largest_;      // lanes: max |A|
  std::vector<Code> code_;           // lanes
};

template <class T>
Status DenseSolver<T>::analyze(const Pattern& pattern, int lanes) {
  check_analysis(pattern, lanes);
  n_ = pattern.n;
  lanes_ = lanes;
  const auto n = static_cast<std::size_t>(n_), w = static_cast<std::size_t>(lanes);
  try {
    place_ = dense_places(pattern, n_);
    factors_.resize(w * n * n);
    pivot_.resize(w * n);
    right_.resize(n * kRightSides);
    largest_.assign(w, 0.0);
    code_.assign(w, Code::singular);  // until factorize()
    lu_->prepare(n_);
  } catch (const std::bad_alloc&) {
    throw Error(Error::Kind::environment, "no memory for " + std::to_string(lanes) + " dense factors of " +
                                              std::to_string(n) + " unknowns; use a sparse backend");
  }
  return {};
}

template <class T>
Status DenseSolver<T>::factorize(std::span<const double> values) {
  check_size("values", values.size(), place_.size() * static_cast<std::size_t>(lanes_));
  for (int lane = 0; lane < lanes_; ++lane) {
    // Without entries there is no first one of a lane.
    code_[static_cast<std::size_t>(lane)] = factorize_lane(values.empty() ? nullptr : values.data() + lane, lane);
  }
  return worst(code_);
}

template <class T>
Code DenseSolver<T>::factorize_lane(const double* values, int lane) {
  const Block<T> a = matrix(lane);
  double& largest = largest_[static_cast<std::size_t>(lane)];
  std::fill_n(a.data, n_ * n_, T{0});
  largest = spread(values, lanes_, place_, a.data);
  if (!std::isfinite(largest)) return Code::not_finite;
  if (n_ == 0) return Code::ok;
  if (!lu_->factorize(a, pivot(lane))) return Code::singular;
  // An overflow during the elimination reaches the diagonal.
  T poison = 0;
  for (DenseIndex j = 0; j < n_; ++j) poison += a(j, j) * 0;
  return poison == 0 ? Code::ok : Code::singular;
}

template <class T>
Status DenseSolver<T>::solve(std::span<double> b_to_x, int rhs, Transpose transpose, int first_wanted) {
  const auto w = static_cast<std::size_t>(lanes_);
  check_size("numbers on the right-hand side", b_to_x.size(),
             static_cast<std::size_t>(n_) * static_cast<std::size_t>(rhs) * w);
  for (int lane = 0; lane < lanes_; ++lane) {
    if (code_[static_cast<std::size_t>(lane)] != Code::ok) {
      fill_with_nan(b_to_x, lanes_, lane);
      continue;
    }
    if (n_ == 0) continue;
    for (DenseIndex r = 0; r < rhs; r += kRightSides) {
      solve_lane(b_to_x.data() + r * n_ * lanes_ + lane, std::min<DenseIndex>(kRightSides, rhs - r), transpose,
                 first_wanted, lane);
    }
  }
  return worst(code_);
}

template <class T>
void DenseSolver<T>::solve_lane(double* b_to_x, DenseIndex columns, Transpose transpose, DenseIndex first_wanted,
                                int lane) {
  const Block<T> x{right_.data(), n_, columns, n_};
  int exponent[kRightSides];
  for (DenseIndex r = 0; r < columns; ++r) {
    exponent[r] = take_right_side(b_to_x + r * n_ * lanes_, lanes_, n_, x.column(r));
  }
  if (transpose == Transpose::yes) first_wanted = 0;
  lu_->solve(matrix(lane), pivot(lane), x, transpose, first_wanted);
  for (DenseIndex r = 0; r < columns; ++r) {
    give_solution(x.column(r), n_, exponent[r], first_wanted, b_to_x + r * n_ * lanes_, lanes_);
  }
}

template <class T>
Figures DenseSolver<T>::figures(int lane) const {
  if (code_[static_cast<std::size_t>(lane)] != Code::ok) return {};
  if (n_ == 0) return {true, 1, 1, 1};
  const Block<T> lu{const_cast<T*>(factors_.data()) + lane * n_ * n_, n_, n_, n_};
  return dense_figures(lu, pivot_.data() + lane * n_, largest_[static_cast<std::size_t>(lane)]);
}

}  // namespace

template <class T>
std::unique_ptr<LinearSolver> make_dense_solver(std::unique_ptr<DenseLu<T>> lu) {
  return std::make_unique<DenseSolver<T>>(std::move(lu));
}
template std::unique_ptr<LinearSolver> make_dense_solver<double>(std::unique_ptr<DenseLu<double>>);
template std::unique_ptr<LinearSolver> make_dense_solver<float>(std::unique_ptr<DenseLu<float>>);

std::string why_not_dense(const Shape& shape) {
  if (shape.n <= kMostDenseUnknowns) return "";
  return "dense factors of " + std::to_string(shape.n) + " unknowns are too large; the limit is " +
         std::to_string(kMostDenseUnknowns);
}

}  // namespace assur
