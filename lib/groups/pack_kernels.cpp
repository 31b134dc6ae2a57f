// Compiled once for each SIMD target.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "groups/pack_kernels.cpp"
#include <hwy/foreach_target.h>  // must precede the code compiled for each target

#include "groups/pack_kernels.hpp"

#include "evaluation/gather-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {
namespace {

template <int W>
std::size_t combine_by(const double* const* sources, const double* weights, std::int32_t count, std::size_t from,
                       std::size_t size, double* out) {
  for (; from + W <= size; from += W) {
    Lanes<W> sum = Lanes<W>::set(0);
    for (std::int32_t j = 0; j < count; ++j) {
      sum.add_product(Lanes<W>::set(weights[j]), Lanes<W>::load(sources[j] + from));
    }
    sum.store(out + from);
  }
  return from;
}
void combine(const double* const* sources, const double* weights, std::int32_t count, std::size_t size, double* out) {
  const std::size_t from = combine_by<8>(sources, weights, count, 0, size, out);
  combine_by<1>(sources, weights, count, from, size, out);
}

template <int W>
struct Kernels {
  using L = Lanes<W>;

  static void gather(const InputRow* rows, const std::int32_t* addresses, std::int32_t count, const double* state,
                     double* out) {
    for (std::int32_t i = 0; i < count; ++i, addresses += W, out += W) {
      gather_input<W>(rows[i], addresses, state).store(out);
    }
  }

  static void gather_all(const InputRow* rows, const std::int32_t* addresses, std::int32_t count,
                         const double* const* states, double* const* outs, std::int32_t orders) {
    for (std::int32_t i = 0; i < count; ++i, addresses += W) {
      for (std::int32_t d = 0; d < orders; ++d) gather_input<W>(rows[i], addresses, states[d]).store(outs[d] + i * W);
    }
  }

  static void row_maxima(const double* numbers, std::int32_t rows, double* out) {
    for (std::int32_t i = 0; i < rows; ++i) out[i] = L::load(numbers + i * W).largest();
  }

  static bool between(const double* numbers, std::int32_t rows, const double* least, const double* most) {
    const L none = L::set(0), one = L::set(1);
    L outside = none;
    for (std::int32_t i = 0; i < rows; ++i) {
      const L x = L::load(numbers + i * W);
      const L below = if_at_most(L::load(least + i * W), x, outside, one);
      outside = if_at_most(x, L::load(most + i * W), below, one);
    }
    return all_at_most(outside, none);
  }

  static bool at_most(const double* numbers, const std::int32_t* addresses, std::int32_t rows, const double* most) {
    const L none = L::set(0), one = L::set(1);
    L outside = none;
    for (std::int32_t i = 0; i < rows; ++i) {
      outside = if_at_most(abs(L::load(numbers + addresses[i])), L::load(most + i * W), outside, one);
    }
    return all_at_most(outside, none);
  }

  static void invert_scale(double* scale, std::int32_t count) {
    const L one = L::set(1);
    for (std::int32_t i = 0; i < count; ++i, scale += W)
      (one / if_positive(L::load(scale), L::load(scale), one)).store(scale);
  }

  static void largest_ratios(const double* phi, const double* inverse_scale, std::int32_t count, double* out) {
    L largest = L::set(0), poison = L::set(0);
    for (std::int32_t i = 0; i < count; ++i) {
      const L ratio = L::load(phi + i * W) * L::load(inverse_scale + i * W);
      largest = max(largest, abs(ratio));
      poison.add_product(ratio, L::set(0));
    }
    (largest + poison).store(out);
  }

  static double correct(const std::int32_t* unknowns, std::int32_t count, const double* correction, double* x,
                        double* largest) {
    L norm = L::set(0), poison = L::set(0);
    for (std::int32_t i = 0; i < count; ++i) {
      const std::int32_t at = unknowns[i] * W;
      const L c = L::load(correction + at);
      (L::load(x + at) - c).store(x + at);
      norm = max(norm, abs(c));
      poison.add_product(c, L::set(0));
    }
    norm = norm + poison;
    norm.store(largest);
    return norm.largest();
  }

  static double residual(const std::int32_t* row_start, const RowEntry* entries, std::int32_t n, const double* jacobian,
                         const double* x, const double* b, double* residual, double* norm, bool measure) {
    if (measure) measure_rows(row_start, n, entries, jacobian, norm);
    L norm_r = L::set(0), norm_x = L::set(0), norm_b = L::set(0), poison = L::set(0);
    for (std::int32_t r = 0; r < n; ++r) {
      const L right = L::load(b + r * W);
      L rest = right;
      for (std::int32_t i = row_start[r]; i < row_start[r + 1]; ++i) {
        rest.subtract_product(L::load(jacobian + entries[i].nonzero * W), L::load(x + entries[i].column * W));
      }
      rest.store(residual + r * W);
      norm_r = max(norm_r, abs(rest));
      norm_x = max(norm_x, abs(L::load(x + r * W)));
      norm_b = max(norm_b, abs(right));
      poison.add_product(rest, L::set(0));
    }
    norm_b.add_product(L::load(norm), norm_x);
    return (norm_r / if_positive(norm_b, norm_b, L::set(1)) + poison).largest();
  }

  static void ball_use(const std::int32_t* coordinates, std::int32_t count, std::int32_t n, const double* unknowns,
                       const double* inputs, const double* anchor, const double* omega, double* used) {
    L moved = L::set(0), poison = L::set(0);
    for (std::int32_t i = 0; i < count; ++i) {
      const std::int32_t c = coordinates[i];
      const L by = L::load(c < n ? unknowns + c * W : inputs + (c - n) * W) - L::load(anchor + i * W);
      moved = max(moved, abs(by));
      poison.add_product(by, L::set(0));
    }
    // If nothing moved, nothing of the ball is used, however small the ball is.
    (if_positive(moved, moved * L::load(omega), moved) + poison).store(used);
  }

 private:
  static void measure_rows(const std::int32_t* row_start, std::int32_t n, const RowEntry* entries,
                           const double* jacobian, double* norm) {
    L largest = L::set(0);
    for (std::int32_t r = 0; r < n; ++r) {
      L sum = L::set(0);
      for (std::int32_t i = row_start[r]; i < row_start[r + 1]; ++i) {
        sum = sum + abs(L::load(jacobian + entries[i].nonzero * W));
      }
      largest = max(largest, sum);
    }
    largest.store(norm);
  }
};

template <int W>
constexpr PackKernels kTable = {combine,
                                Kernels<W>::gather,
                                Kernels<W>::gather_all,
                                Kernels<W>::row_maxima,
                                Kernels<W>::between,
                                Kernels<W>::at_most,
                                Kernels<W>::invert_scale,
                                Kernels<W>::largest_ratios,
                                Kernels<W>::correct,
                                Kernels<W>::residual,
                                Kernels<W>::ball_use};

const PackKernels* table(int lanes) {
  switch (lanes) {
    case 1:
      return &kTable<1>;
    case 2:
      return &kTable<2>;
    case 4:
      return &kTable<4>;
    case 8:
      return &kTable<8>;
    default:
      return &kTable<16>;
  }
}

}  // namespace
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace assur {

HWY_EXPORT(table);

const PackKernels& pack_kernels(int lanes) { return *HWY_DYNAMIC_DISPATCH(table)(lanes); }

}  // namespace assur
#endif
