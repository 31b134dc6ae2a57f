#include "evaluation/callbacks.hpp"

#include <algorithm>
#include <cmath>

#include "equations/residual_scale.hpp"
#include "index.hpp"

namespace assur {

CallbackRows::CallbackRows(const System& system, const GroupClass& group_class, int lanes)
    : system_(system), class_(group_class), lanes_(lanes) {
  for (const GroupClass::CallbackUse& use : group_class.callbacks) {
    const std::size_t m = use.arguments.size(), r = idx(block(use).callback->equations);
    least_.resize(group_class.equations.size() * idx(lanes));
    scratch_.push_back({std::vector<double>(m), std::vector<double>(m), std::vector<double>(r),
                        std::vector<double>(r * m * idx(lanes))});
  }
}

const CallbackBlock& CallbackRows::block(const GroupClass::CallbackUse& use) const {
  return system_.callbacks[idx(use.callback)];
}

// constants: values of constant arguments; null: they are 0, as for rates.
void CallbackRows::load(const GroupClass::CallbackUse& use, const double* constants, const double* from, int lane,
                        std::vector<double>& x) const {
  for (std::size_t i = 0; i < use.arguments.size(); ++i) {
    const std::int32_t a = use.arguments[i];
    const double v = a >= 0 ? from[a * lanes_ + lane] : constants != nullptr ? constants[~a * lanes_ + lane] : 0.0;
    x[i] = v * block(use).unit[i];
  }
}

void CallbackRows::residuals(const double* coefficients, const double* value, double* phi) {
  knows_matrix_ = false;
  for (std::size_t c = 0; c < scratch_.size(); ++c) {
    const GroupClass::CallbackUse& use = class_.callbacks[c];
    for (int w = 0; w < lanes_; ++w) {
      load(use, coefficients, value, w, scratch_[c].x);
      block(use).callback->residual(scratch_[c].x, scratch_[c].phi);
      for (const GroupClass::CallbackUse::EquationOfRow& r : use.rows)
        phi[r.equation * lanes_ + w] = scratch_[c].phi[idx(r.row)];
    }
  }
}

void CallbackRows::matrix(const double* coefficients, const double* value) {
  if (knows_matrix_) return;
  for (std::size_t c = 0; c < scratch_.size(); ++c) {
    const GroupClass::CallbackUse& use = class_.callbacks[c];
    Scratch& s = scratch_[c];
    const std::size_t size = s.jacobian.size() / idx(lanes_);
    for (int w = 0; w < lanes_; ++w) {
      load(use, coefficients, value, w, s.x);
      block(use).callback->jacobian(s.x, {s.jacobian.data() + idx(w) * size, size});
    }
  }
  knows_matrix_ = true;
}

double CallbackRows::derivative(std::size_t c, std::int32_t row, std::int32_t argument, int lane) const {
  const Scratch& s = scratch_[c];
  const std::size_t m = s.x.size(), size = s.jacobian.size() / idx(lanes_);
  return s.jacobian[idx(lane) * size + idx(row) * m + idx(argument)] * block(class_.callbacks[c]).unit[idx(argument)];
}

void CallbackRows::jacobian(const double* coefficients, const double* value, double* jacobian) {
  matrix(coefficients, value);
  for (const GroupClass::CallbackEntry& e : class_.callback_entries) {
    for (int w = 0; w < lanes_; ++w) {
      jacobian[e.nonzero * lanes_ + w] +=
          derivative(idx(e.callback), e.row, e.argument, w) * coefficients[e.coefficient * lanes_ + w];
    }
  }
}

template <class Use>
void CallbackRows::for_each_argument(Use&& use_it) const {
  for (std::size_t c = 0; c < scratch_.size(); ++c) {
    const GroupClass::CallbackUse& use = class_.callbacks[c];
    for (const GroupClass::CallbackUse::EquationOfRow& r : use.rows) {
      for (std::size_t a = 0; a < use.arguments.size(); ++a) {
        if (use.arguments[a] < 0) continue;
        for (int w = 0; w < lanes_; ++w) {
          use_it(r.equation * lanes_ + w, use.arguments[a] * lanes_ + w,
                 derivative(c, r.row, static_cast<std::int32_t>(a), w));
        }
      }
    }
  }
}

void CallbackRows::scale(const double* coefficients, const double* value, double* scale) {
  matrix(coefficients, value);
  for_each_argument([&](std::int32_t row, std::int32_t argument, double derivative) {
    scale[row] += std::abs(derivative * value[argument]);
  });
}

void CallbackRows::raise_scale(const double* coefficients, const double* value, double* scale) {
  matrix(coefficients, value);
  least_.assign(class_.equations.size() * idx(lanes_), 0.0);
  for_each_argument([&](std::int32_t row, std::int32_t, double derivative) {
    least_[idx(row)] += kLeastFactor * std::abs(derivative);
  });
  for (std::size_t i = 0; i < least_.size(); ++i) {
    if (std::isfinite(least_[i])) scale[i] = std::max(scale[i], least_[i]);
  }
}

void CallbackRows::rates(const double* coefficients, const double* value, const double* rate, double* rhs) {
  matrix(coefficients, value);
  for_each_argument(
      [&](std::int32_t row, std::int32_t argument, double derivative) { rhs[row] -= derivative * rate[argument]; });
}

void CallbackRows::curvature(const double* coefficients, const double* value, const double* rate, double* rhs) {
  for (std::size_t c = 0; c < scratch_.size(); ++c) {
    const GroupClass::CallbackUse& use = class_.callbacks[c];
    Scratch& s = scratch_[c];
    for (int w = 0; w < lanes_; ++w) {
      load(use, coefficients, value, w, s.x);
      load(use, nullptr, rate, w, s.rate);
      block(use).callback->curvature(s.x, s.rate, s.phi);
      for (const GroupClass::CallbackUse::EquationOfRow& r : use.rows)
        rhs[r.equation * lanes_ + w] -= s.phi[idx(r.row)];
    }
  }
}

}  // namespace assur
