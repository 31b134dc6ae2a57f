#include "errors/law_rounding.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

#include "numbers.hpp"
#include "scene/law_evaluate.hpp"

namespace assur {
namespace {

// Bounds of a number's size, and of its error in units of epsilon / 2.
struct Bounded {
  double size = 0, error = 0;

  // The error of a sum is at most the smaller addend.
  friend Bounded operator+(const Bounded& a, const Bounded& b) {
    const double size = a.size + b.size, least = std::min(a.size, b.size) / (kEps / 2);
    return {size, a.error + b.error + std::min(size, least)};
  }
  // Times an exact number; products with 1 and 2 are exact.
  friend Bounded operator*(const Bounded& a, double factor) {
    const double size = a.size * factor;
    return {size, a.error * factor + (a.size == 1 || factor == 1 || factor == 2 ? 0 : size)};
  }
};
using BoundedJet = Jet<Bounded>;

struct BoundsOf {
  double t;
  bool now;

  // law_detail::horner()
  BoundedJet operator()(const Law::Polynomial& p) const {
    Bounded value, rate, half;
    for (std::size_t i = p.coefficients.size(); i-- > 0;) {
      half = half * std::abs(t) + rate;
      rate = rate * std::abs(t) + value;
      value = value * std::abs(t) + Bounded{std::abs(p.coefficients[i])};
    }
    return {value, rate, half * 2};
  }

  // The angle is 2 pi times at most half a cycle, plus the phase; roundings of the cycle and of its product with 2 pi
  // are rarely all of one sign. Products and the sine round as well.
  BoundedJet operator()(const Law::Harmonics& h) const {
    BoundedJet sum{{std::abs(h.offset)}, {}, {}};
    for (const Harmonic& term : h.terms) {
      constexpr double kOfCycle = 3;  // roundings of at most half a cycle, pi
      const double a = std::abs(term.amplitude), w = kTurn * std::abs(term.frequency);
      const double angle = w != 0 && t != 0 ? kOfCycle + std::abs(term.phase) : 0;
      sum += BoundedJet{{a, a * (angle + 2)}, {a * w, a * w * (angle + 3)}, {a * w * w, a * w * w * (angle + 4)}};
    }
    return sum;
  }

  // A time within a period is rounded, and so are the shares of both ends of its interval.
  BoundedJet operator()(const Law::Spline& s) const {
    const double first = s.time.front(), last = s.time.back();
    const double at = std::clamp(s.periodic ? law_detail::wrap(s, t) : t, first, last);
    const double lost = s.periodic && at != t ? std::max(std::abs(first), std::abs(last)) : 0;
    const std::size_t k = law_detail::interval(s, at);
    const double h = s.time[k + 1] - s.time[k], change = std::abs(s.value[k + 1] - s.value[k]);
    const auto [left, right] = s.bends(k);
    const double bend = std::abs(left) + std::abs(right);
    const double size = std::max(std::abs(s.value[k]), std::abs(s.value[k + 1])), slope = change / h + h / 2 * bend;
    return {{size, 3 * size + h * h * bend + lost * slope},
            {slope, 4 * slope + lost * bend},
            {bend, (4 + lost / h) * bend}};
  }

  BoundedJet operator()(const Law::Function& f) const {
    if (!now) return {};
    const Motion m = f.motion(t);
    return {{std::abs(m.value)}, {std::abs(m.rate)}, {std::abs(m.acceleration)}};
  }
};

}  // namespace

Jet<double> rounding(const Law& law, double t, bool now) {
  BoundedJet sum;
  const bool adds = law.parts().size() > 1;
  for (const Law::Part& part : law.parts()) sum += std::visit(BoundsOf{t, now && adds}, part);
  return {sum.value.error, sum.rate.error, sum.acceleration.error};
}

}  // namespace assur
