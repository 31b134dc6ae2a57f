// W doubles side by side, one for each lane of a pack, in the vectors of the target that is being compiled. Included
// once for each target, inside its HWY_NAMESPACE (see Highway, "foreach_target.h"). Text that uses only functions which
// Value has as well (program/step_graph.hpp) can write the program of a step instead.
#if defined(ASSUR_LANE_VECTOR_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef ASSUR_LANE_VECTOR_INL
#undef ASSUR_LANE_VECTOR_INL
#else
#define ASSUR_LANE_VECTOR_INL
#endif

#include "fused-inl.hpp"

#include <cstddef>
#include <cstdint>

#include "evaluation/lane_array.hpp"
#include "numbers.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

template <int W>
struct Lanes {
  using D = hn::CappedTag<double, W>;
  using V = hn::Vec<D>;
  static constexpr int kEach = static_cast<int>(hn::MaxLanes(D()));  // lanes of one vector
  static constexpr int kVectors = W / kEach;
  V v[kVectors];

  static HWY_INLINE Lanes load(const double* from) {
    Lanes out;
    for (int i = 0; i < kVectors; ++i) out.v[i] = hn::LoadU(D(), from + i * kEach);
    return out;
  }
  static HWY_INLINE Lanes set(double x) {
    Lanes out;
    for (int i = 0; i < kVectors; ++i) out.v[i] = hn::Set(D(), x);
    return out;
  }
  HWY_INLINE void store(double* to) const {
    for (int i = 0; i < kVectors; ++i) hn::StoreU(v[i], D(), to + i * kEach);
  }

  // HWY_ATTR, because GCC compiles friends at the end of the file, where the target is the baseline again. If it does
  // not inline such a function, caller and function disagree on where vectors are passed.
  friend HWY_INLINE HWY_ATTR Lanes operator+(Lanes a, const Lanes& b) {
    for (int i = 0; i < kVectors; ++i) a.v[i] = hn::Add(a.v[i], b.v[i]);
    return a;
  }
  friend HWY_INLINE HWY_ATTR Lanes operator-(Lanes a, const Lanes& b) {
    for (int i = 0; i < kVectors; ++i) a.v[i] = hn::Sub(a.v[i], b.v[i]);
    return a;
  }
  friend HWY_INLINE HWY_ATTR Lanes operator*(Lanes a, const Lanes& b) {
    for (int i = 0; i < kVectors; ++i) a.v[i] = hn::Mul(a.v[i], b.v[i]);
    return a;
  }
  friend HWY_INLINE HWY_ATTR Lanes operator/(Lanes a, const Lanes& b) {
    for (int i = 0; i < kVectors; ++i) a.v[i] = hn::Div(a.v[i], b.v[i]);
    return a;
  }
  // sum + a * b and sum - a * b, rounded once
  HWY_INLINE void add_product(const Lanes& a, const Lanes& b) {
    for (int i = 0; i < kVectors; ++i) v[i] = fused(D(), a.v[i], b.v[i], v[i]);
  }
  HWY_INLINE void subtract_product(const Lanes& a, const Lanes& b) {
    for (int i = 0; i < kVectors; ++i) v[i] = fused_negated(D(), a.v[i], b.v[i], v[i]);
  }
  friend HWY_INLINE HWY_ATTR Lanes abs(Lanes a) {
    for (int i = 0; i < kVectors; ++i) a.v[i] = hn::Abs(a.v[i]);
    return a;
  }
  friend HWY_INLINE HWY_ATTR Lanes sqrt(Lanes a) {
    for (int i = 0; i < kVectors; ++i) a.v[i] = hn::Sqrt(a.v[i]);
    return a;
  }
  // |a| with the sign of b
  friend HWY_INLINE HWY_ATTR Lanes copy_sign(Lanes a, const Lanes& b) {
    for (int i = 0; i < kVectors; ++i) a.v[i] = hn::CopySign(a.v[i], b.v[i]);
    return a;
  }
  // To the nearest integer, halves to even.
  friend HWY_INLINE HWY_ATTR Lanes round(Lanes a) {
    for (int i = 0; i < kVectors; ++i) a.v[i] = hn::Round(a.v[i]);
    return a;
  }
  // b if it is larger than a, else a; a if b is NaN.
  friend HWY_INLINE HWY_ATTR Lanes max_if_finite(Lanes a, const Lanes& b) {
    for (int i = 0; i < kVectors; ++i) {
      const auto larger = hn::And(hn::Gt(b.v[i], a.v[i]), hn::IsFinite(b.v[i]));
      a.v[i] = hn::IfThenElse(larger, b.v[i], a.v[i]);
    }
    return a;
  }
  // Elementwise; the result for NaN differs between targets.
  friend HWY_INLINE HWY_ATTR Lanes max(Lanes a, const Lanes& b) {
    for (int i = 0; i < kVectors; ++i) a.v[i] = hn::Max(a.v[i], b.v[i]);
    return a;
  }
  // test > 0 ? yes : no
  friend HWY_INLINE HWY_ATTR Lanes if_positive(const Lanes& test, Lanes yes, const Lanes& no) {
    for (int i = 0; i < kVectors; ++i) {
      yes.v[i] = hn::IfThenElse(hn::Gt(test.v[i], hn::Zero(D())), yes.v[i], no.v[i]);
    }
    return yes;
  }
  // a <= b ? yes : no; no for NaN
  friend HWY_INLINE HWY_ATTR Lanes if_at_most(const Lanes& a, const Lanes& b, Lanes yes, const Lanes& no) {
    for (int i = 0; i < kVectors; ++i) yes.v[i] = hn::IfThenElse(hn::Le(a.v[i], b.v[i]), yes.v[i], no.v[i]);
    return yes;
  }
  struct Mask {
    hn::Mask<D> m[kVectors];

    friend HWY_INLINE HWY_ATTR Mask operator&(Mask a, const Mask& b) {
      for (int i = 0; i < kVectors; ++i) a.m[i] = hn::And(a.m[i], b.m[i]);
      return a;
    }
    // True in every lane.
    HWY_INLINE bool all() const {
      hn::Mask<D> both = m[0];
      for (int i = 1; i < kVectors; ++i) both = hn::And(both, m[i]);
      return hn::AllTrue(D(), both);
    }
    // Bit i is lane i.
    HWY_INLINE unsigned bits() const {
      static_assert(W <= 16 && kEach <= 8);
      unsigned out = 0;
      for (int i = 0; i < kVectors; ++i) {
        std::uint8_t bytes[8];
        hn::StoreMaskBits(D(), m[i], bytes);
        out |= (bytes[0] & ((1U << kEach) - 1)) << (i * kEach);
      }
      return out;
    }
  };
  // Both are false for NaN.
  friend HWY_INLINE HWY_ATTR Mask less(const Lanes& a, const Lanes& b) {
    Mask out;
    for (int i = 0; i < kVectors; ++i) out.m[i] = hn::Lt(a.v[i], b.v[i]);
    return out;
  }
  friend HWY_INLINE HWY_ATTR Mask less_equal(const Lanes& a, const Lanes& b) {
    Mask out;
    for (int i = 0; i < kVectors; ++i) out.m[i] = hn::Le(a.v[i], b.v[i]);
    return out;
  }
  friend HWY_INLINE HWY_ATTR bool all_at_most(const Lanes& a, const Lanes& b) { return less_equal(a, b).all(); }
  // Numbers in memory, one of each lane; first 0.
  template <std::size_t n>
  class Fixed {
   public:
    HWY_INLINE Lanes operator[](std::size_t i) const { return load(numbers_ + i * W); }
    HWY_INLINE void set(std::size_t i, const Lanes& v) { v.store(numbers_ + i * W); }

   private:
    alignas(kLineBytes) double numbers_[n * W] = {};
  };
  class Array {
   public:
    explicit Array(std::size_t size) : numbers_(size * W) {}
    HWY_INLINE Lanes operator[](std::size_t i) const { return load(numbers_.data() + i * W); }
    HWY_INLINE void set(std::size_t i, const Lanes& v) { v.store(numbers_.data() + i * W); }
    [[nodiscard]] const double* data() const { return numbers_.data(); }

   private:
    LaneArray numbers_;
  };
  // The largest lane; NaN if there is one.
  HWY_INLINE double largest() const {
    V top = v[0];
    auto missing = hn::IsNaN(v[0]);
    for (int i = 1; i < kVectors; ++i) {
      top = hn::Max(top, v[i]);
      missing = hn::Or(missing, hn::IsNaN(v[i]));
    }
    if (HWY_UNLIKELY(!hn::AllFalse(D(), missing))) return kNan;
    return hn::GetLane(hn::MaxOfLanes(D(), top));
  }
};

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard for each target
