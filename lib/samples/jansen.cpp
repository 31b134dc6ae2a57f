#include <string>

#include "samples/geometry.hpp"
#include "samples/samples.hpp"

namespace assur::samples {
namespace {

Triple values_of(const Number& x, const Number& y) { return {x, y, 0}; }

}  // namespace

// Legs of Theo Jansen's walking machine on one crank shaft, in pairs: the left leg of a pair mirrors the right one. The
// cranks of the pairs are spread evenly over a turn. La to Lm are the lengths a to m that Jansen published as his "holy
// numbers" (strandbeest.com), one unit as one centimetre. With four legs it is scenes/jansen.json, where the points are
// explained.
Scene jansen(const Values& values) {
  const int pairs = values.count("legs") / 2;
  const auto length = [&](char letter) { return values[std::string("L") + letter]; };
  const Number a = length('a'), b = length('b'), c = length('c'), d = length('d'), e = length('e'), f = length('f'),
               g = length('g'), h = length('h'), i = length('i'), j = length('j'), k = length('k'), l = length('l'),
               m = length('m');
  // The upper triangle b d e and the lower one g h i, seen along b and g.
  const Number upper_x = (b * b + d * d - e * e) / (2 * b), upper_y = sqrt(d * d - upper_x * upper_x);
  const Number lower_x = (g * g + i * i - h * h) / (2 * g), lower_y = sqrt(i * i - lower_x * lower_x);

  SceneBuilder builder("jansen", 2);
  builder.fixed_point("O", {0, 0, 0})
      .fixed_point("PR", values_of(a, -l))
      .fixed_point("PL", values_of(-a, -l))
      .point("X", values_of(m, 0));
  builder.constrain("crank", Distance{"O", "X", m});
  builder.drive("motor", PointAngle{"O", "X", "", Law::polynomial({0, values["omega"]})});
  Body shaft{"shaft", "", {}, {"O", "X"}, {}, {}};
  for (int pair = 1; pair <= pairs; ++pair) {
    const std::string pin_name = "pin" + std::to_string(pair);
    const Triple pin = m * heading(kTurn * (pair - 1) / pairs);
    shaft.points.push_back({pin_name, pin});
    for (const char side : {'R', 'L'}) {
      const bool right = side == 'R';
      const std::string leg = side + std::to_string(pair), pivot_name = std::string("P") + side;
      const auto named = [&](const char* name) { return name + leg; };
      // The left leg mirrors the right leg, so that left and right of a line are exchanged.
      const auto joint = [&](const Triple& P, const Number& p, const Triple& Q, const Number& q) {
        return right ? meet(P, p, Q, q) : meet(Q, q, P, p);
      };
      const Triple pivot = values_of(right ? a : -a, -l), upper = values_of(upper_x, right ? -upper_y : upper_y);
      const Triple top = joint(pin, j, pivot, b), knee = joint(pivot, c, pin, k), u = unit(top - pivot);
      const Triple D = pivot + upper[0] * u + upper[1] * values_of(-u[1], u[0]);
      const Triple shin = joint(D, f, knee, g);
      const std::string T = named("T"), K = named("K"), S = named("S"), D_name = named("D");
      builder.point(T, top).point(K, knee).point(S, shin);
      builder.add(Body{named("upper"), "", {}, {pivot_name, T}, {{D_name, upper}}, {}});
      builder.add(
          Body{named("lower"), "", {}, {K, S}, {{named("foot"), values_of(lower_x, right ? -lower_y : lower_y)}}, {}});
      const auto rod = [&](const char* name, const std::string& P, const std::string& Q, const Number& length_of) {
        builder.constrain(named(name), Distance{P, Q, length_of});
      };
      rod("j", pin_name, T, j);
      rod("b", pivot_name, T, b);
      rod("k", pin_name, K, k);
      rod("c", pivot_name, K, c);
      rod("f", D_name, S, f);
      rod("g", K, S, g);
      builder.output(named("foot"));
    }
  }
  builder.add(std::move(shaft));
  return builder.time(0, 4, 0.01).build();
}

}  // namespace assur::samples
