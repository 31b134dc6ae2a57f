// Compiled once for each SIMD target.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "outputs/form_kernels.cpp"
#include <hwy/foreach_target.h>  // must precede the code compiled for each target

#include "outputs/form_kernels.hpp"

#include "evaluation/gather-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {
namespace {

void evaluate(std::span<const FormRow> rows, const FormTerm* terms, const double* const (&state)[3], double* out) {
  using L = Lanes<kFormLanes>;
  double sums[3][kFormLanes];
  for (const FormRow& row : rows) {
    L value = L::set(0), rate = L::set(0), acceleration = L::set(0);
    for (const FormTerm* t = terms + row.begin; t != terms + row.end; ++t) {
      const L factor = L::load(t->factor);  // products are rounded, as those of single forms
      value = value + factor * load_input<kFormLanes>(t->coordinate, state[0]);
      rate = rate + factor * load_input<kFormLanes>(t->coordinate, state[1]);
      acceleration = acceleration + factor * load_input<kFormLanes>(t->coordinate, state[2]);
    }
    value.store(sums[0]);
    rate.store(sums[1]);
    acceleration.store(sums[2]);
    const std::ptrdiff_t step = row.step;
    for (std::int32_t l = 0; l < row.count; ++l) {
      double* const to = out + row.column[l];
      to[0] = sums[0][l];
      to[step] = sums[1][l];
      to[2 * step] = sums[2][l];
    }
  }
}
EvaluateForms kernel() { return evaluate; }

}  // namespace
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace assur {

HWY_EXPORT(kernel);

EvaluateForms evaluate_forms() { return HWY_DYNAMIC_DISPATCH(kernel)(); }

}  // namespace assur
#endif
