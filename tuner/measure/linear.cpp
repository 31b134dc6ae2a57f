#include "measure/linear.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "backends/refined.hpp"
#include "decimal.hpp"

namespace assur::measure {
namespace {

constexpr int kSets = 4;                // sets of values, used in turn
constexpr std::size_t kMost = 4 << 20;  // doubles of all sets; there are at least two sets
constexpr double kMotion = 1e-3;        // relative difference of the values of two sets
constexpr double kWrong = 1e-6;         // backward errors above this are not due to rounding, not even in float

}  // namespace

class Linear::Factor final : public Workload {
 public:
  explicit Factor(Linear& of) : of_(of) {}
  void get_ready(int) override { (void)run(1); }
  bool run(int calls) override {
    bool ok = true;
    for (int i = 0; i < calls; ++i) {
      ok = of_.solver_->factorize(of_.values_[next_]).ok() && ok;
      if (++next_ == of_.values_.size()) next_ = 0;
    }
    return ok;
  }

 private:
  Linear& of_;
  std::size_t next_ = 0;
};

class Linear::Solve final : public Workload {
 public:
  explicit Solve(Linear& of) : of_(of) {}
  void get_ready(int) override { (void)run(1); }
  bool run(int calls) override {
    bool ok = true;
    for (int i = 0; i < calls; ++i) {
      std::copy(of_.right_.begin(), of_.right_.end(), of_.x_.begin());
      ok = of_.solver_->solve(of_.x_, 1).ok() && ok;
    }
    return ok;
  }

 private:
  Linear& of_;
};

Linear::Linear(const Matrices& matrices, const Strategy& strategy, const Backend& backend)
    : lanes_(strategy.solver.lanes),
      solver_(make_solver(backend, ThreadBudget{strategy.solver.threads},
                          strategy.solver.single ? Precision::binary32 : Precision::binary64, strategy.solver.refine)),
      factor_(std::make_unique<Factor>(*this)),
      solve_(std::make_unique<Solve>(*this)) {
  if (const Status s = solver_->analyze(matrices.pattern, lanes_); !s.ok()) {
    refused_ = "its analysis fails: " + std::string(name(s.code));
    return;
  }
  draw_values(matrices);
  verify(matrices);
}

Linear::~Linear() = default;

void Linear::draw_values(const Matrices& matrices) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> slightly(1 - kMotion, 1 + kMotion);
  const std::size_t w = static_cast<std::size_t>(lanes_), nonzeros = matrices.pattern.row.size();
  const int sets = kSets * nonzeros * w > kMost ? 2 : kSets;
  for (int set = 0; set < sets; ++set) {
    auto& values = values_.emplace_back(nonzeros * w);
    for (std::size_t lane = 0; lane < w; ++lane) {
      const std::vector<double>& from = matrices.values[lane % matrices.values.size()];
      for (std::size_t k = 0; k < nonzeros; ++k) values[k * w + lane] = from[k] * slightly(random);
    }
  }
  right_.resize(static_cast<std::size_t>(matrices.pattern.n) * w);
  x_.resize(right_.size());
}

void Linear::verify(const Matrices& matrices) {
  for (const std::vector<double>& values : values_) {
    if (!check(matrices, values)) return;
  }
}

// Checks one set of values. Products in long double: their rounding is far below the errors of the solver.
bool Linear::check(const Matrices& matrices, const std::vector<double>& values) {
  const Pattern& p = matrices.pattern;
  const std::size_t w = static_cast<std::size_t>(lanes_), n = static_cast<std::size_t>(p.n);
  const auto add_product = [&](const auto& x, auto& sum, auto& row_sums, std::size_t lane) {
    for (std::size_t c = 0; c < n; ++c) {
      for (auto k = static_cast<std::size_t>(p.column_start[c]); k < static_cast<std::size_t>(p.column_start[c + 1]);
           ++k) {
        const auto row = static_cast<std::size_t>(p.row[k]);
        sum[row] += static_cast<long double>(values[k * w + lane]) * x[c * w + lane];
        row_sums[row] += std::abs(values[k * w + lane]);
      }
    }
  };
  const auto largest = [&](const auto& v) {
    long double most = 0;
    for (const auto element : v) {
      const long double size = std::abs(static_cast<long double>(element));
      if (!(size <= most)) most = size;
    }
    return most;
  };

  std::mt19937_64 random(11);
  std::vector<double> reference(n * w);
  for (double& x : reference) {
    x = std::uniform_real_distribution<double>(0.5, 1)(random) * (random() % 2 == 0 ? 1 : -1);
  }
  for (std::size_t lane = 0; lane < w; ++lane) {
    std::vector<long double> b(n), unused(n);
    add_product(reference, b, unused, lane);
    for (std::size_t i = 0; i < n; ++i) right_[i * w + lane] = static_cast<double>(b[i]);
  }
  x_ = right_;
  Status status = solver_->factorize(values);
  if (status.ok()) status = solver_->solve(x_, 1);
  if (!status.ok()) {
    refused_ = "its status is " + std::string(name(status.code));
    return false;
  }
  for (std::size_t lane = 0; lane < w; ++lane) {
    std::vector<long double> residual(n), row_sums(n), x(n), off(n);
    for (std::size_t i = 0; i < n; ++i) {
      residual[i] = -static_cast<long double>(right_[i * w + lane]);
      x[i] = x_[i * w + lane];
      off[i] = x[i] - reference[i * w + lane];
    }
    const long double b = largest(residual);
    add_product(x_, residual, row_sums, lane);
    const auto backward = static_cast<double>(largest(residual) / (largest(row_sums) * largest(x) + b));
    const auto forward = static_cast<double>(largest(off) / largest(reference));
    if (!(backward <= backward_)) backward_ = backward;
    if (!(forward <= forward_)) forward_ = forward;
  }
  if (backward_ <= kWrong && std::isfinite(forward_)) return true;
  refused_ = "its backward error is " + general(backward_, 2);
  return false;
}

}  // namespace assur::measure
