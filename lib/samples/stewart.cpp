#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "samples/geometry.hpp"
#include "samples/samples.hpp"

namespace assur::samples {
namespace {

constexpr double kHandle = 0.2, kRod = 0.55;  // m

// Constant vectors: axis a of the handle through A on the ground; P and the cardan axis t on the terminal.
struct LegShape {
  Triple A, a, inward;  // inward: horizontal, perpendicular to a; zero of the handle's angle
  Triple P, t;          // local
};

LegShape leg_shape(double azimuth, double terminal_azimuth) {
  const double quarter = std::numbers::pi / 2, axis_azimuth = azimuth + quarter + 0.2, elevation = 0.1;
  return {0.5 * heading(azimuth), std::cos(elevation) * heading(axis_azimuth) + Triple{0, 0, std::sin(elevation)},
          heading(axis_azimuth + quarter), 0.3 * heading(terminal_azimuth), heading(terminal_azimuth + quarter)};
}

// Six legs form pairs, as in the paper. Any other number is spread evenly, with the terminal's joints straight above
// those of the base.
std::vector<LegShape> leg_shapes(int legs) {
  std::vector<LegShape> shapes;
  for (int k = 0; k < legs; ++k) {
    const int third = k / 2;
    const double pair = kTurn / 3 * third, side = k % 2 == 0 ? -1 : 1, even = kTurn * k / legs;
    shapes.push_back(legs == 6 ? leg_shape(pair + 0.35 * side, pair + 0.7 * side) : leg_shape(even, even));
  }
  return shapes;
}

struct LegPosture {
  Triple B, e, r, c, d;
};

// B is on the handle's circle about a through A, at the rod's length from P, on the side of a x AP.
LegPosture leg_posture(const LegShape& shape, const Triple& P, const Triple& t) {
  const Triple AP = P - shape.A;
  const double height = dot(AP, shape.a);
  const Triple across = AP - height * shape.a;
  const double reach = norm(across);
  const double cosine = (reach * reach + height * height + kHandle * kHandle - kRod * kRod) / (2 * kHandle * reach);
  const Triple x = (1 / reach) * across;
  const Triple e = cosine * x + std::sqrt(1 - cosine * cosine) * cross(shape.a, x);
  const Triple B = shape.A + kHandle * e;
  const Triple r = unit(P - B), c = unit(cross(r, t));
  return {B, e, r, c, cross(r, c)};
}

// Leg k, unknowns B, e (along the handle), r (along the rod), c and d (across the rod): 15 equations.
void add_leg(SceneBuilder& builder, const LegShape& shape, const LegPosture& at, const std::string& k) {
  const auto named = [&k](const char* name) { return name + k; };
  const std::string A = named("A"), B = named("B"), P = named("P"), a = named("a"), t = named("t");
  const std::string e = named("e"), r = named("r"), c = named("c"), d = named("d"), inward = named("inward");
  builder.fixed_point(A, shape.A)
      .fixed_vector(a, shape.a)
      .fixed_vector(inward, shape.inward)
      .point(B, at.B)
      .vector(e, at.e)
      .vector(r, at.r)
      .vector(c, at.c)
      .vector(d, at.d)
      .constrain(named("handle_length"), Linear{{{B, 1}, {A, -1}, {e, -kHandle}}})
      .constrain(named("hinge"), Dot{e, a, 0})
      .constrain(named("rod_length"), Linear{{{P, 1}, {B, -1}, {r, -kRod}}})
      .constrain(named("c_across_rod"), Dot{c, r, 0})
      .constrain(named("cardan"), Dot{c, t, 0})
      .constrain(named("d_across_rod"), Dot{d, r, 0})
      .constrain(named("d_across_c"), Dot{d, c, 0})
      .measure(named("handle"), AngleBetween{inward, e, a})
      .add(DeclaredGroup{named("SG_HS"), {B, e, r, c, d}});
}

// Adds one platform, whose names end in `suffix` and whose motion leads by `phase`.
void add_platform(SceneBuilder& builder, const std::vector<LegShape>& legs, const Number& omega, double phase,
                  const std::string& suffix) {
  const auto named = [&suffix](const char* name) { return name + suffix; };
  Pose pose{named("terminal"),
            {wave(0.05, omega, phase), wave(0.05, omega, phase + 1), wave(0.05, omega, phase + 2, 0.55)},
            {wave(0.15, omega, phase + 0.5), wave(0.15, omega, phase + 1.5), wave(0.15, omega, phase + 2.5)}};
  const auto at_start = [](const Law& law) { return law(0).value; };
  const Triple O = {at_start(pose.translation[0]), at_start(pose.translation[1]), at_start(pose.translation[2])};
  const Axes axes = euler_zyx(at_start(pose.rotation[0]), at_start(pose.rotation[1]), at_start(pose.rotation[2]));
  const auto in_ground = [&axes](const Triple& x) { return x[0] * axes.u + x[1] * axes.v + x[2] * axes.w; };

  const std::string origin = named("O"), u = named("u"), v = named("v"), w = named("w");
  Body terminal{named("terminal"), origin, {u, v, w}, {}, {}, {}};
  builder.point(origin, O).vector(u, axes.u).vector(v, axes.v).vector(w, axes.w);
  builder.add(DeclaredGroup{named("SG_T"), {origin, u, v, w}}).drive(named("pose"), std::move(pose));
  for (std::size_t i = 0; i < legs.size(); ++i) {
    const std::string k = std::to_string(i + 1) + suffix;
    terminal.points.push_back({"P" + k, legs[i].P});
    terminal.vectors.push_back({"t" + k, legs[i].t});
    add_leg(builder, legs[i], leg_posture(legs[i], O + in_ground(legs[i].P), in_ground(legs[i].t)), k);
  }
  builder.add(std::move(terminal));
}

}  // namespace

// The paper's Stewart platform: the terminal's pose is given, and the handles follow. A single platform has plain
// names; the names of several platforms end in _1, _2, ..., and their motions differ by equal parts of a turn.
Scene stewart(const Values& values) {
  const int platforms = values.count("platforms");
  const std::vector<LegShape> legs = leg_shapes(values.count("legs"));
  SceneBuilder builder("stewart", 3);
  for (int i = 0; i < platforms; ++i) {
    add_platform(builder, legs, values["omega"], kTurn * i / platforms,
                 platforms == 1 ? "" : "_" + std::to_string(i + 1));
  }
  return builder.time(0, values.plain("steps") * values.plain("step"), values.plain("step")).build();
}

}  // namespace assur::samples
