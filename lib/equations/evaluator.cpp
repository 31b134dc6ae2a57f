#include "equations/evaluator.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace assur {
namespace {

using Index = std::int32_t;

template <int W>
class EvaluatorOf final : public Evaluator {
 public:
  EvaluatorOf(const System& system, const Program& program)
      : system_(system),
        p_(program),
        value_(size(p_.registers)),
        base_(size(p_.registers)),
        input_rate_(size(p_.registers)),
        rate_(size(p_.registers)),
        acceleration_(size(p_.registers)),
        magnitude_(size(p_.registers)) {
    for (const Program::CallbackUse& use : p_.callbacks) {
      const Callback& c = *system_.callbacks[static_cast<std::size_t>(use.callback)].callback;
      const std::size_t m = use.arguments.size(), r = static_cast<std::size_t>(c.equations);
      scratch_.push_back(
          {std::vector<double>(m), std::vector<double>(m), std::vector<double>(r), std::vector<double>(r * m * W)});
    }
  }

  void set_inputs(const double* coefficients, const double* inputs) override {
    k_ = coefficients;
    std::copy_n(inputs, p_.inputs * W, value_.data() + p_.n * W);
    for (const Program::Form& f : p_.forms) {
      double* out = base_.data() + f.reg * W;
      for (int w = 0; w < W; ++w) out[w] = f.offset >= 0 ? k_[f.offset * W + w] : 0.0;
      add(out, f.inputs_begin, f.inputs_end, value_.data());
    }
  }

  void evaluate(const double* unknowns, double* phi, double* jacobian) override {
    std::copy_n(unknowns, p_.n * W, value_.data());
    for (const Program::Form& f : p_.forms) {
      double* out = value_.data() + f.reg * W;
      std::copy_n(base_.data() + f.reg * W, W, out);
      add(out, f.unknowns_begin, f.unknowns_end, value_.data());
    }
    for (const Program::Equation& e : p_.equations) {
      double sum[W];
      start(sum, e);
      for (Index i = e.products_begin; i < e.products_end; ++i) {
        const Program::Product& q = p_.products[static_cast<std::size_t>(i)];
        const double* k = k_ + q.coefficient * W;
        if (q.b >= 0) {
          const double *a = reg(value_, q.a), *b = reg(value_, q.b);
          for (int w = 0; w < W; ++w) sum[w] += k[w] * (a[w] * b[w]);
        } else if (q.a >= 0) {
          const double* a = reg(value_, q.a);
          for (int w = 0; w < W; ++w) sum[w] += k[w] * a[w];
        } else {
          for (int w = 0; w < W; ++w) sum[w] += k[w];
        }
      }
      std::copy_n(sum, W, phi + (&e - p_.equations.data()) * W);
    }
    if (!p_.callbacks.empty()) callback_residuals(phi);
    if (jacobian != nullptr) fill_jacobian(jacobian);
  }

  void scale(double* scale) override {
    for (Index i = 0; i < (p_.n + p_.inputs) * W; ++i)
      magnitude_[static_cast<std::size_t>(i)] = std::abs(value_[static_cast<std::size_t>(i)]);
    for (const Program::Form& f : p_.forms) {
      double* out = magnitude_.data() + f.reg * W;
      for (int w = 0; w < W; ++w) out[w] = f.offset >= 0 ? std::abs(k_[f.offset * W + w]) : 0.0;
      add_magnitude(out, f.inputs_begin, f.inputs_end);
      add_magnitude(out, f.unknowns_begin, f.unknowns_end);
    }
    for (const Program::Equation& e : p_.equations) {
      double* out = scale + (&e - p_.equations.data()) * W;
      for (int w = 0; w < W; ++w) {
        out[w] = (e.linear >= 0 ? magnitude_[static_cast<std::size_t>(e.linear * W + w)] : 0.0) +
                 (e.offset >= 0 ? std::abs(k_[e.offset * W + w]) : 0.0);
      }
      for (Index i = e.products_begin; i < e.products_end; ++i) {
        const Program::Product& q = p_.products[static_cast<std::size_t>(i)];
        for (int w = 0; w < W; ++w) {
          const double k = std::abs(k_[q.coefficient * W + w]);
          if (q.b >= 0) {
            const std::size_t a = static_cast<std::size_t>(q.a * W + w), b = static_cast<std::size_t>(q.b * W + w);
            out[w] += k * (magnitude_[a] * std::abs(value_[b]) + std::abs(value_[a]) * magnitude_[b]);
          } else {
            out[w] += q.a >= 0 ? k * magnitude_[static_cast<std::size_t>(q.a * W + w)] : k;
          }
        }
      }
    }
    if (!p_.callbacks.empty()) callback_scale(scale);
  }

  void velocity_rhs(const double* input_rates, double* rhs) override {
    set_input_derivatives(input_rates, input_rate_);
    input_terms(input_rate_, rhs);
    if (!p_.callbacks.empty()) callback_inputs(input_rate_, rhs);
  }

  void acceleration_rhs(const double* unknown_rates, const double* input_accelerations, double* rhs) override {
    std::copy_n(unknown_rates, p_.n * W, rate_.data());
    std::copy_n(input_rate_.data() + p_.n * W, p_.inputs * W, rate_.data() + p_.n * W);
    for (const Program::Form& f : p_.forms) {
      double* out = rate_.data() + f.reg * W;
      std::copy_n(input_rate_.data() + f.reg * W, W, out);
      add(out, f.unknowns_begin, f.unknowns_end, rate_.data());
    }
    set_input_derivatives(input_accelerations, acceleration_);
    input_terms(acceleration_, rhs);
    for (const Program::Equation& e : p_.equations) {
      double* out = rhs + (&e - p_.equations.data()) * W;
      for (Index i = e.products_begin; i < e.products_end; ++i) {
        const Program::Product& q = p_.products[static_cast<std::size_t>(i)];
        if (q.b < 0 || !((q.a_moves || q.a_unknown) && (q.b_moves || q.b_unknown))) continue;
        const double *k = k_ + q.coefficient * W, *a = reg(rate_, q.a), *b = reg(rate_, q.b);
        for (int w = 0; w < W; ++w) out[w] -= 2 * (k[w] * (a[w] * b[w]));
      }
    }
    if (!p_.callbacks.empty()) {
      callback_inputs(acceleration_, rhs);
      callback_curvature(rhs);
    }
  }

 private:
  using Registers = std::vector<double>;

  static std::size_t size(Index slots) { return static_cast<std::size_t>(slots) * W; }
  static const double* reg(const Registers& r, Index i) { return r.data() + i * W; }

  void add(double* out, Index begin, Index end, const double* x) const {
    for (Index i = begin; i < end; ++i) {
      const Program::Operand& o = p_.operands[static_cast<std::size_t>(i)];
      const double *k = k_ + o.coefficient * W, *v = x + o.reg * W;
      for (int w = 0; w < W; ++w) out[w] += k[w] * v[w];
    }
  }
  void add_magnitude(double* out, Index begin, Index end) const {
    for (Index i = begin; i < end; ++i) {
      const Program::Operand& o = p_.operands[static_cast<std::size_t>(i)];
      const double *k = k_ + o.coefficient * W, *v = magnitude_.data() + o.reg * W;
      for (int w = 0; w < W; ++w) out[w] += std::abs(k[w]) * v[w];
    }
  }

  void start(double (&sum)[W], const Program::Equation& e) const {
    if (e.linear >= 0) {
      std::copy_n(reg(value_, e.linear), W, sum);
    } else if (e.offset >= 0) {
      std::copy_n(k_ + e.offset * W, W, sum);
    } else {
      std::fill_n(sum, W, 0.0);
    }
  }

  void fill_jacobian(double* jacobian) {
    for (const Program::Entry& e : p_.entries) {
      double sum[W] = {};
      for (Index i = e.begin; i < e.end; ++i) {
        const Program::Operand& o = p_.entry_operands[static_cast<std::size_t>(i)];
        const double* k = k_ + o.coefficient * W;
        if (o.reg >= 0) {
          const double* v = reg(value_, o.reg);
          for (int w = 0; w < W; ++w) sum[w] += k[w] * v[w];
        } else {
          for (int w = 0; w < W; ++w) sum[w] += k[w];
        }
      }
      std::copy_n(sum, W, jacobian);
      jacobian += W;
    }
    if (!p_.callbacks.empty()) callback_jacobian(jacobian - p_.entries.size() * W);
  }

  // Derivatives of inputs and of what the forms take from them; those of the unknowns stay zero.
  void set_input_derivatives(const double* inputs, Registers& out) {
    std::copy_n(inputs, p_.inputs * W, out.data() + p_.n * W);
    for (const Program::Form& f : p_.forms) {
      if (f.moving_begin == f.moving_end) continue;
      double* r = out.data() + f.reg * W;
      std::fill_n(r, W, 0.0);
      add(r, f.moving_begin, f.moving_end, out.data());
    }
  }

  // rhs = -sum over what moves of dPhi/dh * derivative
  void input_terms(const Registers& d, double* rhs) const {
    for (const Program::Equation& e : p_.equations) {
      double* out = rhs + (&e - p_.equations.data()) * W;
      std::fill_n(out, W, 0.0);
      if (e.linear >= 0 && e.linear_moves) {
        const double* v = reg(d, e.linear);
        for (int w = 0; w < W; ++w) out[w] -= v[w];
      }
      for (Index i = e.products_begin; i < e.products_end; ++i) {
        const Program::Product& q = p_.products[static_cast<std::size_t>(i)];
        const double* k = k_ + q.coefficient * W;
        if (q.a_moves) {
          const double* a = reg(d, q.a);
          if (q.b < 0) {
            for (int w = 0; w < W; ++w) out[w] -= k[w] * a[w];
          } else {
            const double* b = reg(value_, q.b);
            for (int w = 0; w < W; ++w) out[w] -= k[w] * (a[w] * b[w]);
          }
        }
        if (q.b >= 0 && q.b_moves) {
          const double *a = reg(value_, q.a), *b = reg(d, q.b);
          for (int w = 0; w < W; ++w) out[w] -= k[w] * (a[w] * b[w]);
        }
      }
    }
  }

  // ---- callbacks: lane after lane, in SI units

  struct Scratch {
    std::vector<double> x, rate;   // arguments
    std::vector<double> phi;       // rows
    std::vector<double> jacobian;  // rows x arguments x lanes, as given at the last callback_jacobian()
  };

  const CallbackBlock& block(const Program::CallbackUse& use) const {
    return system_.callbacks[static_cast<std::size_t>(use.callback)];
  }

  void load(std::size_t c, const Registers& from, int lane, std::vector<double>& x) const {
    const Program::CallbackUse& use = p_.callbacks[c];
    for (std::size_t i = 0; i < use.arguments.size(); ++i) {
      const Index a = use.arguments[i];
      // A constant argument has no rate; value_ and rate_ are the only registers loaded.
      const double v = a >= 0             ? from[static_cast<std::size_t>(a * W + lane)]
                       : &from == &value_ ? k_[~a * W + lane]
                                          : 0.0;
      x[i] = v * block(use).unit[i];
    }
  }

  void callback_residuals(double* phi) {
    for (std::size_t c = 0; c < p_.callbacks.size(); ++c) {
      const Program::CallbackUse& use = p_.callbacks[c];
      for (int w = 0; w < W; ++w) {
        load(c, value_, w, scratch_[c].x);
        block(use).callback->residual(scratch_[c].x, scratch_[c].phi);
        for (const Program::CallbackRow& r : use.rows)
          phi[r.equation * W + w] = scratch_[c].phi[static_cast<std::size_t>(r.row)];
      }
    }
  }

  void callback_matrix() {
    for (std::size_t c = 0; c < p_.callbacks.size(); ++c) {
      const Program::CallbackUse& use = p_.callbacks[c];
      Scratch& s = scratch_[c];
      const std::size_t size = s.jacobian.size() / W;
      for (int w = 0; w < W; ++w) {
        load(c, value_, w, s.x);
        block(use).callback->jacobian(s.x, {s.jacobian.data() + static_cast<std::size_t>(w) * size, size});
      }
    }
  }
  double callback_derivative(std::size_t c, Index row, Index argument, int lane) const {
    const Scratch& s = scratch_[c];
    const std::size_t m = s.x.size(), size = s.jacobian.size() / W;
    return s.jacobian[static_cast<std::size_t>(lane) * size + static_cast<std::size_t>(row) * m +
                      static_cast<std::size_t>(argument)] *
           block(p_.callbacks[c]).unit[static_cast<std::size_t>(argument)];
  }

  void callback_jacobian(double* jacobian) {
    callback_matrix();
    for (const Program::CallbackEntry& e : p_.callback_entries) {
      for (int w = 0; w < W; ++w) {
        jacobian[e.nonzero * W + w] +=
            callback_derivative(static_cast<std::size_t>(e.callback), e.row, e.argument, w) * k_[e.coefficient * W + w];
      }
    }
  }

  template <class Use>
  void for_each_argument(Use&& use_it) const {
    for (std::size_t c = 0; c < p_.callbacks.size(); ++c) {
      const Program::CallbackUse& use = p_.callbacks[c];
      for (const Program::CallbackRow& r : use.rows) {
        for (std::size_t a = 0; a < use.arguments.size(); ++a) {
          if (use.arguments[a] < 0) continue;
          for (int w = 0; w < W; ++w) {
            use_it(static_cast<std::size_t>(r.equation * W + w), static_cast<std::size_t>(use.arguments[a] * W + w),
                   callback_derivative(c, r.row, static_cast<Index>(a), w));
          }
        }
      }
    }
  }

  void callback_inputs(const Registers& d, double* rhs) {
    callback_matrix();
    for_each_argument(
        [&](std::size_t row, std::size_t argument, double derivative) { rhs[row] -= derivative * d[argument]; });
  }

  void callback_scale(double* scale) {
    callback_matrix();
    for_each_argument([&](std::size_t row, std::size_t argument, double derivative) {
      scale[row] += std::abs(derivative * value_[argument]);
    });
  }

  void callback_curvature(double* rhs) {
    for (std::size_t c = 0; c < p_.callbacks.size(); ++c) {
      const Program::CallbackUse& use = p_.callbacks[c];
      for (int w = 0; w < W; ++w) {
        load(c, value_, w, scratch_[c].x);
        load(c, rate_, w, scratch_[c].rate);
        block(use).callback->curvature(scratch_[c].x, scratch_[c].rate, scratch_[c].phi);
        for (const Program::CallbackRow& r : use.rows)
          rhs[r.equation * W + w] -= scratch_[c].phi[static_cast<std::size_t>(r.row)];
      }
    }
  }

  const System& system_;
  const Program& p_;
  const double* k_ = nullptr;  // coefficients of the pack at hand
  Registers value_, base_, input_rate_, rate_, acceleration_, magnitude_;
  std::vector<Scratch> scratch_;
};

}  // namespace

std::unique_ptr<Evaluator> make_evaluator(const System& system, const Program& program, int lanes) {
  switch (lanes) {
    case 1:
      return std::make_unique<EvaluatorOf<1>>(system, program);
    case 2:
      return std::make_unique<EvaluatorOf<2>>(system, program);
    case 4:
      return std::make_unique<EvaluatorOf<4>>(system, program);
    case 8:
      return std::make_unique<EvaluatorOf<8>>(system, program);
    case 16:
      return std::make_unique<EvaluatorOf<16>>(system, program);
    default:
      throw std::invalid_argument("lanes must be 1, 2, 4, 8 or 16");
  }
}

}  // namespace assur
