#include "measure/linear.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "backends/refined.hpp"
#include "decimal.hpp"
#include "index.hpp"

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

// Checks one set of values. Products in long double: their rounding is far below the errors of the solver. All arrays
// have the lanes side by side.
bool Linear::check(const Matrices& matrices, const std::vector<double>& values) {
  const Pattern& p = matrices.pattern;
  const std::size_t w = static_cast<std::size_t>(lanes_), size = idx(p.n) * w;
  const auto for_entries = [&](const auto& work) {
    for (std::size_t c = 0; c < idx(p.n); ++c) {
      for (auto k = idx(p.column_start[c]); k < idx(p.column_start[c + 1]); ++k) work(k * w, idx(p.row[k]) * w, c * w);
    }
  };
  const auto add_product = [&](const std::vector<double>& x, std::vector<long double>& sum) {
    for_entries([&](std::size_t value, std::size_t row, std::size_t column) {
      for (std::size_t lane = 0; lane < w; ++lane) {
        sum[row + lane] += static_cast<long double>(values[value + lane]) * x[column + lane];
      }
    });
  };

  std::mt19937_64 random(11);
  std::vector<double> reference(size);
  for (double& x : reference) {
    x = std::uniform_real_distribution<double>(0.5, 1)(random) * (random() % 2 == 0 ? 1 : -1);
  }
  std::vector<long double> products(size);
  add_product(reference, products);
  std::copy(products.begin(), products.end(), right_.begin());
  x_ = right_;
  Status status = solver_->factorize(values);
  if (status.ok()) status = solver_->solve(x_, 1);
  if (!status.ok()) {
    refused_ = "its status is " + std::string(name(status.code));
    return false;
  }
  std::vector<double> row_sums(size), off(size);
  std::vector<long double> residual(size);
  for (std::size_t i = 0; i < size; ++i) {
    residual[i] = -static_cast<long double>(right_[i]);
    off[i] = x_[i] - reference[i];
  }
  add_product(x_, residual);
  for_entries([&](std::size_t value, std::size_t row, std::size_t) {
    for (std::size_t lane = 0; lane < w; ++lane) row_sums[row + lane] += std::abs(values[value + lane]);
  });
  for (std::size_t lane = 0; lane < w; ++lane) {
    const auto largest = [&](const auto& v) {
      double most = 0;
      for (std::size_t i = lane; i < size; i += w) {
        const auto here = static_cast<double>(std::abs(v[i]));
        if (!(here <= most)) most = here;
      }
      return most;
    };
    const double backward = largest(residual) / (largest(row_sums) * largest(x_) + largest(right_));
    const double forward = largest(off) / largest(reference);
    if (!(backward <= backward_)) backward_ = backward;
    if (!(forward <= forward_)) forward_ = forward;
  }
  if (backward_ <= kWrong && std::isfinite(forward_)) return true;
  refused_ = "its backward error is " + general(backward_, 2);
  return false;
}

}  // namespace assur::measure
