#include "backends/refined.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "backends/backends.hpp"
#include "backends/residual.hpp"
#include "numbers.hpp"

namespace assur {
namespace {
constexpr int kMostRounds = 10;  // a choice: each round halves the error at least

// Goal of a solution: it is refined until its error is at most `target`, and refused if the error remains above
// `bound`.
struct Goal {
  enum class Measure : std::uint8_t { componentwise, normwise } measure;
  double target, bound;
  int most_rounds;
};

// Refinement in one precision ends at 2 gamma_{n+1} = (n + 1) eps (Higham, Accuracy and Stability of Numerical
// Algorithms, theorem 12.4). Rounding of x and of the residual always leaves 2 eps.
Goal componentwise(double n) { return {Goal::Measure::componentwise, 2 * kEps, (n + 1) * kEps, kMostRounds}; }

// A solution in double without growth has an error of at most n eps, and of about sqrt(n) eps if rounding errors are
// random (Higham & Mary, SIAM J. Sci. Comput. 41, 2019).
Goal as_in_double(double n) { return {Goal::Measure::normwise, std::sqrt(n) * kEps, n * kEps, kMostRounds}; }

Goal check_only(double n) { return {Goal::Measure::normwise, 10 * n * kEps, 10 * n * kEps, 0}; }

class Refined final : public LinearSolver {
 public:
  // in_double: the same backend in double if `inner` is in float; else null.
  Refined(std::unique_ptr<LinearSolver> inner, std::unique_ptr<LinearSolver> in_double, Goal (*goal)(double))
      : inner_(std::move(inner)), in_double_(std::move(in_double)), goal_of_(goal) {}

  Status analyze(const Pattern& pattern, int lanes) override;
  Status factorize(std::span<const double> values) override;
  Status solve(std::span<double> b_to_x, int rhs, Transpose transpose, int first_wanted) override;
  Figures figures(int lane) const override;
  Effort effort() const override;
  std::unique_ptr<LinearSolver> clone() const override;

 private:
  // The solver that has the factors of a lane.
  enum class By : std::uint8_t { nobody, inner, in_double };

  void allocate();
  void factorize_in_double(std::size_t lane);
  void solve_chunk(std::span<double> x, std::size_t count, Transpose transpose);
  void improve(By by, std::span<double> x, std::size_t count, Transpose transpose);
  void refine(By by, std::span<double> x, std::size_t count, Transpose transpose);
  void correct(By by, std::size_t count, Transpose transpose);
  void measure(std::span<const double> x, std::size_t count, Transpose transpose);
  double normwise_error(double residual, std::size_t column, Transpose transpose) const;
  const std::vector<double>& rows_of(Transpose transpose) const {
    return transpose == Transpose::no ? row_scale_ : column_scale_;
  }
  LinearSolver& solver(By by) { return by == By::inner ? *inner_ : *in_double_; }
  PackSystem system(Transpose transpose) const { return {pattern_, values_, static_cast<int>(lanes_), transpose}; }

  // visit(i, column) for each number of a chunk, in order.
  template <typename Visit>
  void for_each(std::size_t count, const Visit& visit) const {
    std::size_t i = 0;
    for (std::size_t first = 0; first < count * lanes_; first += lanes_) {
      for (std::size_t row = 0; row < n_; ++row) {
        for (std::size_t lane = 0; lane < lanes_; ++lane) visit(i++, first + lane);
      }
    }
  }

  // One right-hand side of a chunk: n x lanes.
  template <typename Span>
  auto side(Span&& chunk, std::size_t r) const {
    return std::span(chunk).subspan(r * n_ * lanes_, n_ * lanes_);
  }

  std::unique_ptr<LinearSolver> inner_, in_double_;
  Goal (*goal_of_)(double);
  Goal goal_{};
  Pattern pattern_;
  std::size_t n_ = 0, lanes_ = 0;
  bool has_double_factors_ = false;  // true: in_double_ has factors of the last values
  Effort effort_;

  std::vector<double> values_;                            // nnz x lanes, of the last factorisation
  std::vector<By> by_;                                    // lanes
  std::vector<Code> code_;                                // lanes
  std::vector<double> norm_of_a_, norm_of_a_transposed_;  // lanes
  std::vector<double> given_;                             // n x kRightSides x lanes: the right-hand sides b
  std::vector<double> residual_;                          // n x kRightSides x lanes: b - A x, then the correction
  std::vector<double> before_;                            // n x kRightSides x lanes: x before its last correction
  std::vector<double> weight_, column_, row_;             // n x lanes: for componentwise errors
  // n x lanes: R and C, which scale A to R A C for normwise errors, so that larger rows do not hide others, and their
  // inverses, which scale b' and x.
  std::vector<double> row_scale_, column_scale_, row_size_, column_size_;
  // A column is one right-hand side in one lane: kRightSides x lanes.
  std::vector<double> norm_of_b_, norm_of_x_, norm_of_residual_;
  std::vector<double> scale_;  // power of two that scales a residual solved in float
  std::vector<double> error_, new_error_;
  std::vector<char> open_;          // columns that are still being refined
  bool lenient_ = false;            // errors are relative to raised weights
  std::vector<double> lane_error_;  // lanes: largest error of this solve
};

Status Refined::analyze(const Pattern& pattern, int lanes) {
  const Status status = inner_->analyze(pattern, lanes);
  if (in_double_ && status.ok()) (void)in_double_->analyze(pattern, lanes);
  pattern_ = pattern;
  lanes_ = static_cast<std::size_t>(lanes);
  allocate();
  return status;
}

void Refined::allocate() {
  n_ = static_cast<std::size_t>(pattern_.n);
  goal_ = goal_of_(static_cast<double>(n_));
  effort_ = {};
  values_.assign(pattern_.row.size() * lanes_, 0.0);
  by_.assign(lanes_, By::nobody);
  code_.assign(lanes_, Code::singular);  // until factorize()
  norm_of_a_.assign(lanes_, 0.0);
  norm_of_a_transposed_.assign(lanes_, 0.0);
  for (auto* chunk : {&given_, &residual_, &before_}) chunk->assign(n_ * kRightSides * lanes_, 0.0);
  for (auto* side : {&weight_, &column_, &row_, &row_scale_, &column_scale_, &row_size_, &column_size_}) {
    side->assign(n_ * lanes_, 0.0);
  }
  for (auto* columns : {&norm_of_b_, &norm_of_x_, &norm_of_residual_, &scale_, &error_, &new_error_}) {
    columns->assign(kRightSides * lanes_, 0.0);
  }
  open_.assign(kRightSides * lanes_, 0);
  lane_error_.assign(lanes_, 0.0);
}

Status Refined::factorize(std::span<const double> values) {
  check_size("values", values.size(), values_.size());
  std::copy(values.begin(), values.end(), values_.begin());
  has_double_factors_ = false;
  if (goal_.measure == Goal::Measure::normwise) {
    equilibrate(system(Transpose::no), row_scale_, column_scale_);
    for (std::size_t i = 0; i < row_size_.size(); ++i) row_size_[i] = 1 / row_scale_[i];
    for (std::size_t i = 0; i < column_size_.size(); ++i) column_size_[i] = 1 / column_scale_[i];
    matrix_norms(system(Transpose::no), row_scale_, column_scale_, norm_of_a_, weight_);
    matrix_norms(system(Transpose::yes), column_scale_, row_scale_, norm_of_a_transposed_, weight_);
  }
  const bool all_good = inner_->factorize(values).ok();
  for (std::size_t lane = 0; lane < lanes_; ++lane) {
    by_[lane] = By::inner;
    code_[lane] = Code::ok;
    if (all_good || inner_->figures(static_cast<int>(lane)).ok) continue;
    by_[lane] = By::nobody;
    double poison = 0;  // 0 as long as every value is finite, else NaN
    for (std::size_t k = lane; k < values_.size(); k += lanes_) poison += values_[k] * 0;
    code_[lane] = poison == 0 ? Code::singular : Code::not_finite;
    if (in_double_ && poison == 0) factorize_in_double(lane);
  }
  return worst(code_);
}

// Factorises all lanes when the first one needs it: this is rare, and a pack costs little more than one lane.
void Refined::factorize_in_double(std::size_t lane) {
  if (!has_double_factors_) (void)in_double_->factorize(values_);
  has_double_factors_ = true;
  const bool good = in_double_->figures(static_cast<int>(lane)).ok;
  by_[lane] = good ? By::in_double : By::nobody;
  code_[lane] = good ? Code::ok : Code::singular;
  ++effort_.in_double;
}

Status Refined::solve(std::span<double> b_to_x, int rhs, Transpose transpose, int) {
  check_size("numbers on the right-hand side", b_to_x.size(), n_ * static_cast<std::size_t>(rhs) * lanes_);
  std::fill(lane_error_.begin(), lane_error_.end(), 0.0);
  for (int r = 0; r < rhs; r += kRightSides) {
    const auto count = static_cast<std::size_t>(std::min(kRightSides, rhs - r));
    solve_chunk(b_to_x.subspan(static_cast<std::size_t>(r) * n_ * lanes_, count * n_ * lanes_), count, transpose);
  }
  if (const Status status = worst(code_); !status.ok()) return status;
  const auto largest = std::max_element(lane_error_.begin(), lane_error_.end());
  if (*largest <= goal_.bound) return {};
  return {Code::not_converged, Place::lane(static_cast<std::int32_t>(largest - lane_error_.begin())), *largest};
}

void Refined::solve_chunk(std::span<double> x, std::size_t count, Transpose transpose) {
  std::copy(x.begin(), x.end(), given_.begin());
  improve(By::inner, x, count, transpose);
  for (std::size_t lane = 0; lane < lanes_; ++lane) {
    for (std::size_t column = lane; column < count * lanes_ && by_[lane] == By::inner; column += lanes_) {
      if (error_[column] <= goal_.bound) continue;
      if (in_double_) {
        factorize_in_double(lane);
      } else {
        lane_error_[lane] = std::max(lane_error_[lane], error_[column]);
      }
    }
  }
  improve(By::in_double, x, count, transpose);
  for (std::size_t column = 0; column < count * lanes_; ++column) {
    const std::size_t lane = column % lanes_;
    // With a normwise goal, a lane that fell back to double has an ordinary solution in double, which meets no goal.
    if (by_[lane] != By::in_double || goal_.measure == Goal::Measure::normwise) continue;
    lane_error_[lane] = std::max(lane_error_[lane], error_[column]);
  }
  for (std::size_t lane = 0; lane < lanes_; ++lane) {
    if (by_[lane] == By::nobody) fill_with_nan(x, static_cast<int>(lanes_), static_cast<int>(lane));
  }
}

// Solves and refines the lanes of `by`; error_ receives the error of each column.
void Refined::improve(By by, std::span<double> x, std::size_t count, Transpose transpose) {
  const std::size_t columns = count * lanes_;
  for (std::size_t column = 0; column < columns; ++column) open_[column] = by_[column % lanes_] == by;
  if (std::none_of(open_.begin(), open_.end(), [](char open) { return open; })) return;

  std::copy_n(given_.begin(), x.size(), residual_.begin());
  for (std::size_t r = 0; r < count; ++r) {
    norms(side(residual_, r), std::span(norm_of_residual_).subspan(r * lanes_, lanes_));
    if (goal_.measure == Goal::Measure::componentwise) continue;
    norms(side(residual_, r), rows_of(transpose), std::span(norm_of_b_).subspan(r * lanes_, lanes_));
  }
  correct(by, count, transpose);
  for_each(count, [&](std::size_t i, std::size_t column) {
    if (open_[column]) x[i] = residual_[i];
  });

  lenient_ = false;
  refine(by, x, count, transpose);
  if (goal_.measure == Goal::Measure::normwise) return;
  lenient_ = true;
  bool any = false;
  for (std::size_t column = 0; column < columns; ++column) {
    open_[column] = by_[column % lanes_] == by && !(error_[column] <= goal_.bound);
    any = any || open_[column];
  }
  if (any) refine(by, x, count, transpose);
}

// Refines the open columns until none is open.
void Refined::refine(By by, std::span<double> x, std::size_t count, Transpose transpose) {
  for (std::size_t column = 0; column < count * lanes_; ++column) {
    if (open_[column]) error_[column] = kInfinity;
  }
  for (int round = 0;; ++round) {
    measure(x, count, transpose);
    bool any = false;
    for (std::size_t column = 0; column < count * lanes_; ++column) {
      if (!open_[column]) continue;
      const double old_error = error_[column], new_error = new_error_[column];
      if (new_error < old_error) {
        error_[column] = new_error;
      } else if (round > 0) {
        const std::size_t first = (column / lanes_) * n_ * lanes_ + column % lanes_;
        for (std::size_t i = first; i < first + n_ * lanes_; i += lanes_) x[i] = before_[i];
      }
      open_[column] = new_error > goal_.target && new_error <= old_error / 2 && round < goal_.most_rounds;
      any = any || open_[column];
      effort_.refined += open_[column];
    }
    if (!any) return;
    std::copy(x.begin(), x.end(), before_.begin());
    correct(by, count, transpose);
    for_each(count, [&](std::size_t i, std::size_t column) {
      if (open_[column]) x[i] += residual_[i];
    });
  }
}

// residual_ = A^-1 residual_. Float has a narrow range, so right-hand sides are scaled to size 1.
void Refined::correct(By by, std::size_t count, Transpose transpose) {
  const bool narrow = by == By::inner && in_double_ != nullptr;
  if (narrow) {
    for (std::size_t column = 0; column < count * lanes_; ++column) {
      const double norm = norm_of_residual_[column];
      const int exponent = norm > 0 && std::isfinite(norm) ? std::clamp(std::ilogb(norm), -1000, 1000) : 0;
      scale_[column] = std::ldexp(1.0, exponent);
    }
    for_each(count, [&](std::size_t i, std::size_t column) { residual_[i] /= scale_[column]; });
  }
  (void)solver(by).solve(std::span(residual_).first(count * n_ * lanes_), static_cast<int>(count), transpose);
  if (narrow) for_each(count, [&](std::size_t i, std::size_t column) { residual_[i] *= scale_[column]; });
}

// residual_ = b - A x, and its backward error in new_error_.
void Refined::measure(std::span<const double> x, std::size_t count, Transpose transpose) {
  std::copy_n(given_.begin(), count * n_ * lanes_, residual_.begin());
  for (std::size_t r = 0; r < count; ++r) {
    const std::span<double> residual = side(residual_, r);
    const auto columns = [&](std::vector<double>& all) { return std::span(all).subspan(r * lanes_, lanes_); };
    if (goal_.measure == Goal::Measure::componentwise) {
      subtract_product(system(transpose), side(x, r), residual, weight_);
      if (lenient_) raise_vanishing_weights(system(transpose), side(x, r), weight_, column_, row_);
      componentwise_errors(residual, weight_, columns(new_error_));
      if (in_double_) norms(residual, columns(norm_of_residual_));
      continue;
    }
    subtract_product(system(transpose), side(x, r), residual);
    if (in_double_) norms(residual, columns(norm_of_residual_));
    norms(residual, rows_of(transpose), columns(new_error_));
    norms(side(x, r), transpose == Transpose::no ? column_size_ : row_size_, columns(norm_of_x_));
    for (std::size_t column = r * lanes_; column < (r + 1) * lanes_; ++column) {
      new_error_[column] = normwise_error(new_error_[column], column, transpose);
    }
  }
}

// residual: norm of the residual.
double Refined::normwise_error(double residual, std::size_t column, Transpose transpose) const {
  const double norm_of_a = (transpose == Transpose::no ? norm_of_a_ : norm_of_a_transposed_)[column % lanes_];
  return residual <= 0 ? 0 : residual / (norm_of_a * norm_of_x_[column] + norm_of_b_[column]);
}

Figures Refined::figures(int lane) const {
  switch (by_[static_cast<std::size_t>(lane)]) {
    case By::nobody:  // also if refinement from float failed
      return {};
    case By::inner:
      return inner_->figures(lane);
    case By::in_double:
      return in_double_->figures(lane);
  }
  return {};
}

Effort Refined::effort() const {
  Effort sum = effort_;
  for (const LinearSolver* solver : {inner_.get(), in_double_.get()}) {
    if (solver) sum += solver->effort();
  }
  return sum;
}

std::unique_ptr<LinearSolver> Refined::clone() const {
  auto inner = inner_->clone();
  auto in_double = in_double_ ? in_double_->clone() : nullptr;
  if (!inner || (in_double_ && !in_double)) return nullptr;
  auto copy = std::make_unique<Refined>(std::move(inner), std::move(in_double), goal_of_);
  copy->pattern_ = pattern_;
  copy->lanes_ = lanes_;
  copy->allocate();
  return copy;
}

}  // namespace

std::unique_ptr<LinearSolver> make_solver(const Backend& backend, ThreadBudget budget, Precision precision,
                                          bool refine) {
  const bool single = precision == Precision::binary32;
  if (single && !backend.single) {
    throw Error(Error::Kind::environment,
                "backend " + std::string(backend.id) + " cannot factorise in float: leave out +float");
  }
  auto inner = backend.make(budget, precision);
  if (!single && !refine) return inner;
  auto in_double = single ? backend.make(budget, Precision::binary64) : nullptr;
  return std::make_unique<Refined>(std::move(inner), std::move(in_double), refine ? componentwise : as_in_double);
}

std::unique_ptr<LinearSolver> checked(std::unique_ptr<LinearSolver> solver) {
  return std::make_unique<Refined>(std::move(solver), nullptr, check_only);
}

}  // namespace assur
