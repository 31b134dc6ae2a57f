// Gears of a class (GroupClass::Gear) with their derivatives, in the text of QuadraticEquations. Included once for each
// target, inside its HWY_NAMESPACE (see Highway, "foreach_target.h").
#if defined(ASSUR_GEAR_ROWS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef ASSUR_GEAR_ROWS_INL
#undef ASSUR_GEAR_ROWS_INL
#else
#define ASSUR_GEAR_ROWS_INL
#endif

#include "evaluation/angles-inl.hpp"

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>

#include "equations/residual_scale.hpp"
#include "evaluation/coefficients.hpp"
#include "index.hpp"
#include "joints/gear.hpp"
#include "numbers.hpp"

HWY_BEFORE_NAMESPACE();
namespace assur::HWY_NAMESPACE {

// L, k(i): see QuadraticEquations. Registers hold coordinates, or their rates or changes.
template <class L>
class GearRows {
  using Registers = typename L::Array;

 public:
  explicit GearRows(const GroupClass& group_class) : class_(group_class) {}

  // To be called first at each posture. The other functions are for one of the gears.
  template <class Coefficient>
  HWY_INLINE void evaluate(const Coefficient& k, const Registers& values) {
    for (const GroupClass::Gear& gear : class_.gears) evaluate(gear, k, values);
  }

  // Phi. NaN if the wheels are far out of mesh, see joints/gear.hpp.
  [[nodiscard]] HWY_INLINE L residual(std::int32_t gear) const { return residual_[idx(gear)]; }

  // dPhi / d(argument)
  [[nodiscard]] HWY_INLINE L derivative(std::int32_t gear, std::int32_t argument) const {
    return cosine_[idx(gear)] * slope_[idx(class_.gears[idx(gear)].first + argument)];
  }

  // The size of the terms: |factor| (1 + |angle|) of each angle, for its directions and itself, and |factor
  // displacement|.
  [[nodiscard]] HWY_INLINE L scale(std::int32_t gear) const { return scale_[idx(gear)]; }
  // A bound of the rounding error, in units of epsilon / 2: four operations lead to a direction, three to the angle.
  [[nodiscard]] HWY_INLINE L rounding(std::int32_t gear) const { return L::set(4) * scale_[idx(gear)]; }
  // See residual_scale().
  [[nodiscard]] HWY_INLINE L least_scale(std::int32_t gear) const {
    L total = L::set(0);
    for_each_argument(gear, [&](std::int32_t a, std::int32_t)
                                HWY_ATTR { total.add_product(L::set(kLeastFactor), abs(derivative(gear, a))); });
    return total;
  }
  // dPhi for these changes.
  [[nodiscard]] HWY_INLINE L change(std::int32_t gear, const Registers& by) const {
    return cosine_[idx(gear)] * total_change(gear, by);
  }
  // Phi''[a, b]
  template <class Coefficient>
  [[nodiscard]] HWY_INLINE L bend(std::int32_t gear, const Coefficient& k, const Registers& values, const Registers& a,
                                  const Registers& b) const {
    const GroupClass::Gear& of = class_.gears[idx(gear)];
    L total = L::set(0);
    std::size_t first = 0, angle = idx(of.first_angle);
    for (const GroupClass::Gear::Side& side : of.sides) {
      if (side.arguments > 1) {
        const Directions at = directions(of, first, side, k, values);
        const L bent = bend(polar_[3 * angle], polar_[3 * angle + 1], polar_[3 * angle + 2], at,
                            changes(of, first, side, a), changes(of, first, side, b));
        total.add_product(L::set(side.factor), bent);
        ++angle;
      }
      first += idx(side.arguments);
    }
    L bent = cosine_[idx(gear)] * total;
    bent.subtract_product(sine_[idx(gear)], total_change(gear, a) * total_change(gear, b));
    return bent;
  }

 private:
  // Of an angle: it turns `from` into `to` about `axis`, which is z in the plane.
  struct Directions {
    L from[3], to[3], axis[3];
    bool in_space;
  };

  template <class Use>
  HWY_INLINE void for_each_argument(std::int32_t gear, const Use& use) const {
    const std::vector<std::int32_t>& arguments = class_.gears[idx(gear)].arguments;
    for (std::size_t a = 0; a < arguments.size(); ++a) {
      if (arguments[a] >= 0) use(static_cast<std::int32_t>(a), arguments[a]);
    }
  }
  [[nodiscard]] HWY_INLINE L total_change(std::int32_t gear, const Registers& by) const {
    L total = L::set(0);
    for_each_argument(gear, [&](std::int32_t a, std::int32_t reg) HWY_ATTR {
      total.add_product(slope_[idx(class_.gears[idx(gear)].first + a)], by[idx(reg)]);
    });
    return total;
  }

  // number(argument)
  template <class Number>
  static HWY_INLINE Directions directions(std::size_t first, std::int32_t arguments, const Number& number) {
    Directions out;
    const std::size_t d = arguments == 4 ? 2 : 3;
    out.in_space = d == 3;
    for (std::size_t i = 0; i < d; ++i) {
      out.from[i] = number(first + i);
      out.to[i] = number(first + d + i);
      if (out.in_space) out.axis[i] = number(first + 2 * d + i);
    }
    return out;
  }
  template <class Coefficient>
  static HWY_INLINE L argument(const GroupClass::Gear& of, std::size_t a, const Coefficient& k,
                               const Registers& values) {
    const std::int32_t at = of.arguments[a];
    return L::set(of.unit[a]) * (at >= 0 ? values[idx(at)] : k(~at));
  }
  template <class Coefficient>
  static HWY_INLINE Directions directions(const GroupClass::Gear& of, std::size_t first,
                                          const GroupClass::Gear::Side& side, const Coefficient& k,
                                          const Registers& values) {
    return directions(first, side.arguments, [&](std::size_t a) HWY_ATTR { return argument(of, a, k, values); });
  }
  static HWY_INLINE Directions changes(const GroupClass::Gear& of, std::size_t first,
                                       const GroupClass::Gear::Side& side, const Registers& by) {
    return directions(first, side.arguments, [&](std::size_t a) HWY_ATTR {
      const std::int32_t at = of.arguments[a];
      return at >= 0 ? L::set(of.unit[a]) * by[idx(at)] : L::set(0);
    });
  }

  // Component i of a x b.
  static HWY_INLINE L across(const L (&a)[3], const L (&b)[3], int i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    return a[j] * b[k] - a[k] * b[j];
  }
  // axis (from x to), for directions of different ones.
  static HWY_INLINE L volume(const Directions& axis, const Directions& from, const Directions& to) {
    if (!axis.in_space) return across(from.from, to.to, 2);
    L sum = L::set(0);
    for (int i = 0; i < 3; ++i) sum = sum + axis.axis[i] * across(from.from, to.to, i);
    return sum;
  }
  static HWY_INLINE L along(const Directions& from, const Directions& to) {
    L sum = from.from[0] * to.to[0] + from.from[1] * to.to[1];
    if (from.in_space) sum = sum + from.from[2] * to.to[2];
    return sum;
  }

  template <class Coefficient>
  HWY_INLINE void evaluate(const GroupClass::Gear& of, const Coefficient& k, const Registers& values) {
    L total = L::set(0), scale = total;
    std::size_t first = 0, angle = idx(of.first_angle);
    const std::size_t gear = static_cast<std::size_t>(&of - class_.gears.data());
    const auto put = [&](std::size_t a, const L& slope)
                         HWY_ATTR { slope_.set(idx(of.first) + a, L::set(of.unit[a]) * slope); };
    for (const GroupClass::Gear::Side& side : of.sides) {
      const L factor = L::set(side.factor);
      if (side.arguments == 1) {
        const L x = argument(of, first, k, values);
        total.add_product(factor, x);
        scale = scale + abs(factor * x);
        put(first, factor);
      } else {
        // d(angle) = (c ds - s dc) / (s^2 + c^2) for its sine s and cosine c, which have the same factor.
        const Directions at = directions(of, first, side, k, values);
        const L s = volume(at, at, at), c = along(at, at), inverse = L::set(1) / (s * s + c * c);
        polar_.set(3 * angle, s);
        polar_.set(3 * angle + 1, c);
        polar_.set(3 * angle + 2, inverse);
        ++angle;
        const L of_angle = angle_of(s, c);
        total.add_product(factor, of_angle);
        scale = scale + abs(factor) * (L::set(1) + abs(of_angle));
        const L of_s = factor * (c * inverse), of_c = factor * (s * inverse);
        const int d = at.in_space ? 3 : 2;
        for (int i = 0; i < d; ++i) {
          // volume = from (to x axis) = to (axis x from) = axis (from x to)
          L by_from, by_to;
          if (at.in_space) {
            by_from = across(at.to, at.axis, i);
            by_to = across(at.axis, at.from, i);
            put(first + idx(2 * d + i), of_s * across(at.from, at.to, i));
          } else {
            by_from = i == 0 ? at.to[1] : L::set(-1) * at.to[0];
            by_to = i == 0 ? L::set(-1) * at.from[1] : at.from[0];
          }
          put(first + idx(i), of_s * by_from - of_c * at.to[i]);
          put(first + idx(d + i), of_s * by_to - of_c * at.from[i]);
        }
      }
      first += idx(side.arguments);
    }
    scale_.set(gear, scale);
    if (!of.is_periodic) {
      residual_.set(gear, total);
      cosine_.set(gear, L::set(1));
      sine_.set(gear, L::set(0));
      return;
    }
    const SinCos<L> phase = sin_cos_of(total);
    const L least = L::set(kLeastCosineInMesh), none = L::set(kNan);
    L cosine = if_at_most(least, phase.cosine, phase.cosine, none);
    cosine = if_at_most(abs(total), L::set(kLargestPhase), cosine, none);
    residual_.set(gear, phase.sine + (cosine - cosine));
    cosine_.set(gear, cosine);
    sine_.set(gear, phase.sine);
  }

  // The second derivative of an angle along two changes of its directions.
  static HWY_INLINE L bend(const L& s, const L& c, const L& inverse, const Directions& at, const Directions& a,
                           const Directions& b) {
    const auto first = [&](const Directions& by, L& ds, L& dc) HWY_ATTR {
      ds = volume(at, by, at) + volume(at, at, by);
      if (at.in_space) ds = ds + volume(by, at, at);
      dc = along(by, at) + along(at, by);
    };
    L sa, ca, sb, cb;
    first(a, sa, ca);
    first(b, sb, cb);
    L both_s = volume(at, a, b) + volume(at, b, a);
    if (at.in_space) {
      both_s = both_s + (volume(a, b, at) + volume(b, a, at));
      both_s = both_s + (volume(a, at, b) + volume(b, at, a));
    }
    const L both_c = along(a, b) + along(b, a);
    const L of_a = (c * sa - s * ca) * inverse;
    const L square = L::set(2) * (c * cb + s * sb);
    return ((cb * sa - sb * ca) + (c * both_s - s * both_c) - of_a * square) * inverse;
  }

  const GroupClass& class_;
  Registers slope_{idx(class_.gear_arguments)};   // d(total) / d(argument), of all gears
  Registers polar_{3 * idx(class_.gear_angles)};  // of the angles of all gears: s, c, 1 / (s^2 + c^2), see evaluate()
  Registers residual_{class_.gears.size()}, scale_{class_.gears.size()}, cosine_{class_.gears.size()},
      sine_{class_.gears.size()};
};

// NOLINTNEXTLINE(google-readability-namespace-comments)
}  // namespace assur::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // include guard for each target
