// Compiled once for each SIMD target; make_evaluator() chooses the target.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "evaluation/evaluator.cpp"
#include <hwy/foreach_target.h>  // must precede the code compiled for each target

#include "evaluation/evaluator.hpp"
#include "evaluation/lane_vector-inl.hpp"
#include "evaluation/quadratic_equations-inl.hpp"

#include <limits>
#include <stdexcept>

#include "evaluation/callbacks.hpp"
#include "index.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {
namespace {

template <int W>
class EvaluatorOf final : public Evaluator {
  using L = Lanes<W>;

 public:
  EvaluatorOf(const System& system, const GroupClass& group_class)
      : n_(static_cast<std::int32_t>(group_class.equations.size())),
        class_(group_class),
        callbacks_(system, group_class, W),
        equations_(group_class) {}

  void set_inputs(const double* coefficients, const double* inputs) override {
    k_ = coefficients;
    equations_.set_inputs(k(), numbers(inputs));
  }

  void evaluate(const double* unknowns, double* phi, double* jacobian) override {
    set_unknowns(unknowns, equations_.values());
    equations_.evaluate(k(), into(phi));
    if (jacobian != nullptr) equations_.differentiate(k(), into(jacobian));
    if (callbacks_.empty()) return;
    callbacks_.residuals(k_, value(), phi);
    if (jacobian != nullptr) callbacks_.jacobian(k_, value(), jacobian);
  }

  void scale(double* scale) override {
    equations_.scale(k(), into(scale));
    if (!callbacks_.empty()) callbacks_.scale(k_, value(), scale);
  }

  void raise_scale(double* scale) override {
    equations_.least_scale(k(), [scale](std::size_t i, const L& least)
                                    HWY_ATTR { max_if_finite(L::load(scale + i * W), least).store(scale + i * W); });
    if (!callbacks_.empty()) callbacks_.raise_scale(k_, value(), scale);
  }

  void rounding(double* bound) override {
    equations_.rounding(k(), into(bound));
    if (!callbacks_.empty()) callbacks_.scale(k_, value(), bound);
  }

  void velocity_rhs(const double* input_rates, double* rhs) override {
    equations_.velocity_rhs(k(), numbers(input_rates), into(rhs));
    if (!callbacks_.empty()) callbacks_.rates(k_, value(), equations_.input_rates().data(), rhs);
  }

  void acceleration_rhs(const double* unknown_rates, const double* input_accelerations, double* rhs) override {
    set_unknowns(unknown_rates, equations_.rates());
    equations_.acceleration_rhs(k(), numbers(input_accelerations), into(rhs));
    if (callbacks_.empty()) return;
    callbacks_.rates(k_, value(), equations_.accelerations().data(), rhs);
    callbacks_.curvature(k_, value(), equations_.rates().data(), rhs);
  }

  void subtract_bend(const Change& a, const Change& b, double times, double* bent, double* out) override {
    equations_.set_change(k(), numbers(a.unknowns), numbers(a.inputs), equations_.rates());
    equations_.set_change(k(), numbers(b.unknowns), numbers(b.inputs), change_);
    equations_.twice_bend(k(), equations_.rates(), change_, [out, times](std::size_t i, const L& twice) HWY_ATTR {
      L of = L::load(out + i * W);
      of.subtract_product(L::set(times / 2), twice);
      of.store(out + i * W);
    });
    if (!callbacks_.empty()) subtract_bend_of_callbacks(a, b, times, bent, out);
  }

 private:
  static HWY_INLINE L at(const double* numbers, std::int32_t i) { return L::load(numbers + i * W); }
  // Numbers in memory as functions, see QuadraticEquations.
  static HWY_INLINE auto numbers(const double* from) {
    return [from](std::int32_t i) HWY_ATTR { return at(from, i); };
  }
  static HWY_INLINE auto into(double* to) {
    return [to](std::size_t i, const L& number) HWY_ATTR { number.store(to + i * W); };
  }
  HWY_INLINE void set_unknowns(const double* from, typename L::Array& registers) const {
    for (std::int32_t j = 0; j < class_.n; ++j) registers.set(idx(j), at(from, j));
  }
  HWY_INLINE auto k() const { return numbers(k_); }
  [[nodiscard]] const double* value() { return equations_.values().data(); }

  // By the curvatures along a + b and a - b. Scales a and b to size 1 in every lane, because their squares may
  // overflow. bent: one number for each equation
  void subtract_bend_of_callbacks(const Change& a, const Change& b, double times, double* bent, double* out) {
    const L factor = to_unit_size(a) * to_unit_size(b) * L::set(times) / L::set(4);
    for (const double side : {1.0, -1.0}) {
      const auto moved = [side](const double* from, const double* by) {
        return [=](std::int32_t i) HWY_ATTR { return at(from, i) + L::set(side) * at(by, i); };
      };
      equations_.set_change(k(), moved(a.unknowns, b.unknowns), moved(a.inputs, b.inputs), equations_.rates());
      for (std::int32_t i = 0; i < n_; ++i) L::set(0).store(bent + i * W);
      callbacks_.curvature(k_, value(), equations_.rates().data(), bent);
      for (std::int32_t i = 0; i < n_; ++i) {
        (at(out, i) + L::set(side) * at(bent, i) * factor).store(out + i * W);
      }
    }
  }

  // Divides the numbers of each lane by the largest of them, and returns the divisors. Ignores NaN.
  L to_unit_size(const Change& change) const {
    const auto each = [&](const auto& work) {
      for (std::int32_t i = 0; i < class_.n; ++i) work(change.unknowns + i * W);
      for (std::int32_t i = 0; i < class_.inputs; ++i) work(change.inputs + i * W);
    };
    L largest = L::set(0);
    each([&](const double* x) {
      const L size = abs(L::load(x));
      largest = if_positive(size - largest, size, largest);
    });
    const L inverse = L::set(1) / largest, most = L::set(std::numeric_limits<double>::max());
    const L factor = if_positive(largest, if_positive(most - inverse, inverse, most), L::set(0));
    each([&](double* x) { (L::load(x) * factor).store(x); });
    return largest;
  }

  std::int32_t n_;  // equations
  const GroupClass& class_;
  CallbackRows callbacks_;
  QuadraticEquations<L> equations_;
  typename L::Array change_{idx(class_.registers())};
  const double* k_ = nullptr;  // coefficients of the current pack
};

Evaluator* make(const System& system, const GroupClass& group_class, int lanes) {
  switch (lanes) {
    case 1:
      return new EvaluatorOf<1>(system, group_class);
    case 2:
      return new EvaluatorOf<2>(system, group_class);
    case 4:
      return new EvaluatorOf<4>(system, group_class);
    case 8:
      return new EvaluatorOf<8>(system, group_class);
    case 16:
      return new EvaluatorOf<16>(system, group_class);
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

std::unique_ptr<Evaluator> make_evaluator(const System& system, const GroupClass& group_class, int lanes) {
  std::unique_ptr<Evaluator> evaluator(HWY_DYNAMIC_DISPATCH(make)(system, group_class, lanes));
  if (!evaluator) throw std::invalid_argument("lanes must be 1, 2, 4, 8 or 16");
  return evaluator;
}

}  // namespace assur
#endif
