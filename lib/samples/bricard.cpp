#include <array>
#include <cmath>
#include <string>

#include "samples/geometry.hpp"
#include "samples/samples.hpp"

namespace assur::samples {

// Bricard's mechanism on the edges of a cube (IFToMM benchmark A04): six unit rods, each at right angles to the hinge
// axes at its ends, which are at right angles to each other. Mobility 1 with one redundant equation in every posture.
// Rod 5 and its axes are fixed. The hinge at P0 is driven from the cube; it can turn from -30 to +210 degrees, and both
// ends are folds. theta, the angle from rod 5 to rod 0, is a quarter turn less, and phi, the angle from rod 0 to rod 1,
// follows from cos theta + cos phi + cos theta cos phi = 0 (J. E. Baker, Mechanism and Machine Theory 15, 1980).
Scene bricard(const Values& values) {
  const double middle = values["middle"], swing = values["swing"];
  if (std::abs(middle) > swing) {
    throw Error(
        Error::Kind::input,
        "sample 'bricard': option 'middle' should not be larger than 'swing', because the motion starts at the cube");
  }
  const std::array<Triple, 6> at = {{{0, 0, 0}, {1, 0, 0}, {1, -1, 0}, {1, -1, 1}, {0, -1, 1}, {0, 0, 1}}};
  const std::array<Triple, 6> axis = {{{0, 1, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}}};
  const auto named = [](const char* name, std::size_t i) { return name + std::to_string(i); };

  SceneBuilder builder("bricard", 3);
  for (std::size_t i = 0; i < 6; ++i) {
    const bool fixed = i == 5 || i == 0;
    builder.add(Point{named("P", i), at[i], fixed}).add(Vector{named("u", i), axis[i], fixed, true});
  }
  for (std::size_t i = 0; i < 5; ++i) {
    const Direction rod(named("P", i), named("P", i + 1));
    builder.constrain(named("rod", i), Distance{rod.first, rod.second, 1.0});
    if (i > 0) builder.constrain(named("near", i), Dot{rod, named("u", i), 0.0});  // the driver fixes it for rod 0
    builder.constrain(named("far", i), Dot{rod, named("u", i + 1), 0.0});
    builder.constrain(named("twist", i), Dot{named("u", i), named("u", i + 1), 0.0});
  }
  builder.drive("hinge",
                PointAngle{"P0", "P1", "u0", wave(swing, values["omega"], -std::asin(middle / swing), middle)});
  builder.measure("theta", AngleBetween{Direction{"P5", "P0"}, Direction{"P0", "P1"}, "u0"});
  builder.measure("phi", AngleBetween{Direction{"P0", "P1"}, Direction{"P1", "P2"}, "u1"});
  return builder.time(0, values.plain("steps") * values.plain("step"), values.plain("step")).build();
}

}  // namespace assur::samples
