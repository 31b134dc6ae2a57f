#include <numbers>
#include <string>

#include "samples/geometry.hpp"
#include "samples/samples.hpp"

namespace assur::samples {

// A scissor lift: in each stage two arms cross in a hinge, M = N. A cylinder moves the roller B0 along the ground, and
// the platform rises by stages * sqrt(arm^2 - B0.x^2). With four stages it is scenes/scissor.json.
Scene scissor(const Values& values) {
  const int stages = values.count("stages");
  const Number arm = values["arm"], closed = values["closed"], open = values["open"];
  for (const char* width : {"closed", "open"}) {
    if (values[width] >= arm) {
      throw Error(Error::Kind::input, "sample 'scissor': option '" + std::string(width) +
                                          "' should be smaller than 'arm', because the arms span this width");
    }
  }
  const Number rise = sqrt(arm * arm - closed * closed);
  const auto named = [](const char* name, int k) { return name + std::to_string(k); };
  SceneBuilder builder("scissor", 2);
  builder.fixed_point("A0", {0, 0, 0}).point("B0", {closed, 0, 0});
  builder.constrain("floor", FixedCoordinate{"B0.y", 0});
  for (int k = 1; k <= stages; ++k) {
    const std::string A = named("A", k), B = named("B", k), below_A = named("A", k - 1), below_B = named("B", k - 1);
    const std::string M = named("M", k), N = named("N", k);
    const Number height = k * rise, middle = arm / 2;
    builder.point(A, {0, height, 0}).point(B, {closed, height, 0});
    builder.add(Body{named("rising", k), "", {}, {below_A, B}, {{M, {middle, 0, 0}}}, {}});
    builder.add(Body{named("falling", k), "", {}, {below_B, A}, {{N, {middle, 0, 0}}}, {}});
    builder.constrain(named("rising_arm", k), Distance{below_A, B, arm});
    builder.constrain(named("falling_arm", k), Distance{below_B, A, arm});
    builder.constrain(named("hinge", k), Linear{{{M, 1}, {N, -1}}, {}});
  }
  const std::string top = named("A", stages);
  builder.add(Body{"platform", top, {}, {}, {{"edge", {2.1, 0, 0}}}, {}});
  builder.drive("cylinder", DrivenCoordinate{"B0.x", wave((closed - open) / 2, kTurn / values["time"],
                                                          std::numbers::pi / 2, (closed + open) / 2)});
  builder.measure("height", MeasuredCoordinate{top + ".y"});
  builder.output("height").output(named("B", stages));
  return builder.time(0, 10, 0.02).build();
}

}  // namespace assur::samples
