// Compiled once for each SIMD target; the one that serves is chosen when an evaluator is made.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "equations/evaluator.cpp"
#include <hwy/foreach_target.h>  // before what is compiled once for each target

#include "equations/evaluator.hpp"
#include "equations/program_run-inl.hpp"

#include <stdexcept>

#include "equations/callbacks.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {
namespace {

template <int W>
class EvaluatorOf final : public Evaluator {
  using L = Lanes<W>;

 public:
  EvaluatorOf(const System& system, const Program& program)
      : p_(program), run_(program), callbacks_(system, program, W) {}

  void set_inputs(const double* coefficients, const double* inputs) override {
    k_ = coefficients;
    run_.set_coefficients(coefficients);
    copy(inputs, p_.inputs, run_.values() + p_.n * W);
    run_.forms_of_inputs();
  }

  void evaluate(const double* unknowns, double* phi, double* jacobian) override {
    copy(unknowns, p_.n, run_.values());
    run_.forms_of_unknowns();
    double* out = phi;
    for (const Program::Equation& e : p_.equations) put(run_.residual(e), out);
    out = jacobian;
    if (jacobian != nullptr) {
      for (const Program::Range& r : p_.entries) put(run_.entry(r), out);
    }
    if (callbacks_.empty()) return;
    callbacks_.residuals(k_, run_.values(), phi);
    if (jacobian != nullptr) callbacks_.jacobian(k_, run_.values(), jacobian);
  }

  void scale(double* scale) override {
    run_.forms_of_magnitudes();
    double* out = scale;
    for (const Program::Equation& e : p_.equations) put(run_.scale(e), out);
    if (!callbacks_.empty()) callbacks_.scale(k_, run_.values(), scale);
  }

  void velocity_rhs(const double* input_rates, double* rhs) override {
    copy(input_rates, p_.inputs, run_.input_rates() + p_.n * W);
    run_.forms_of_input_rates();
    double* out = rhs;
    for (const Program::Equation& e : p_.equations) put(run_.velocity_rhs(e), out);
    if (!callbacks_.empty()) callbacks_.rates(k_, run_.values(), run_.input_rates(), rhs);
  }

  void acceleration_rhs(const double* unknown_rates, const double* input_accelerations, double* rhs) override {
    copy(unknown_rates, p_.n, run_.rates());
    copy(run_.input_rates() + p_.n * W, p_.inputs, run_.rates() + p_.n * W);
    run_.forms_of_rates();
    copy(input_accelerations, p_.inputs, run_.input_accelerations() + p_.n * W);
    run_.forms_of_input_accelerations();
    double* out = rhs;
    for (const Program::Equation& e : p_.equations) put(run_.acceleration_rhs(e), out);
    if (callbacks_.empty()) return;
    callbacks_.rates(k_, run_.values(), run_.input_accelerations(), rhs);
    callbacks_.curvature(k_, run_.values(), run_.rates(), rhs);
  }

 private:
  static void copy(const double* from, std::int32_t count, double* to) {
    for (std::int32_t i = 0; i < count; ++i) L::load(from + i * W).store(to + i * W);
  }
  static HWY_INLINE void put(const L& value, double*& to) {
    value.store(to);
    to += W;
  }

  const Program& p_;
  ProgramRun<W> run_;
  CallbackRows callbacks_;
  const double* k_ = nullptr;  // coefficients of the pack at hand
};

Evaluator* make(const System& system, const Program& program, int lanes) {
  switch (lanes) {
    case 1:
      return new EvaluatorOf<1>(system, program);
    case 2:
      return new EvaluatorOf<2>(system, program);
    case 4:
      return new EvaluatorOf<4>(system, program);
    case 8:
      return new EvaluatorOf<8>(system, program);
    case 16:
      return new EvaluatorOf<16>(system, program);
    default:
      return nullptr;
  }
}

}  // namespace
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace assur {

HWY_EXPORT(make);

std::unique_ptr<Evaluator> make_evaluator(const System& system, const Program& program, int lanes) {
  std::unique_ptr<Evaluator> evaluator(HWY_DYNAMIC_DISPATCH(make)(system, program, lanes));
  if (!evaluator) throw std::invalid_argument("lanes must be 1, 2, 4, 8 or 16");
  return evaluator;
}

}  // namespace assur
#endif
