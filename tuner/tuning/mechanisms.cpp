#include "tuning/mechanisms.hpp"

#include <cmath>
#include <string>

namespace assur::tuning {

Scene dyads(int count) {
  // The crank of length 1 turns about the origin and starts at 0.5 rad. Couplers of length 2 and rockers of 1.5 or more
  // can be assembled with ground points at a distance of about 2.5.
  constexpr double kStart = 0.5, kCoupler = 2;
  const Triple end = {std::cos(kStart), std::sin(kStart), 0};
  SceneBuilder builder("dyads", 2);
  builder.fixed_point("A", {0, 0, 0}).point("B", end).constrain("crank", Distance{"A", "B", 1.0});
  builder.drive("motor", PointAngle{"A", "B", "", Law::polynomial({kStart, 1})});
  for (int i = 0; i < count; ++i) {
    const std::string number = std::to_string(i);
    const double share = static_cast<double>(i) / count, ground = 2.4 + 0.2 * share, rocker = 1.5 + 0.2 * share;
    const double dx = ground - end[0], dy = -end[1], square = dx * dx + dy * dy;
    const double along = (square + kCoupler * kCoupler - rocker * rocker) / (2 * square);
    const double across = std::sqrt(kCoupler * kCoupler / square - along * along);
    builder.fixed_point("D" + number, {ground, 0, 0});
    builder.point("C" + number, {end[0] + along * dx - across * dy, end[1] + along * dy + across * dx, 0});
    builder.constrain("coupler" + number, Distance{"B", "C" + number, kCoupler});
    builder.constrain("rocker" + number, Distance{"D" + number, "C" + number, rocker});
  }
  return builder.time(0, 0.5, 0.005).build();
}

Scene tripods(int count) {
  // Two legs keep each point on a circle of radius 3 about an axis below it. The rods of length 2 move all points to
  // and fro as the crank, of length 1, passes the middle of its swing.
  constexpr double kStart = 1.3, kRod = 2, kHeight = 3, kAside = 2;
  const Triple end = {std::cos(kStart), std::sin(kStart), 0};
  SceneBuilder builder("tripods", 3);
  builder.fixed_point("A", {0, 0, 0}).fixed_vector("axis", {0, 0, 1}).point("B", end);
  builder.drive("motor", PointAngle{"A", "B", "axis", Law::polynomial({kStart, 1})});
  std::string before = "B";
  for (int i = 0; i < count; ++i) {
    const std::string number = std::to_string(i), point = "C" + number;
    const double x = end[0] + (i + 1) * kRod, y = end[1];
    builder.point(point, {x, y, 0}).constrain("rod" + number, Distance{before, point, kRod});
    for (const double side : {-kAside, kAside}) {
      const std::string leg = number + (side < 0 ? "L" : "R");
      builder.fixed_point("D" + leg, {x, y + side, -kHeight}).constrain("leg" + leg, Distance{"D" + leg, point, {}});
    }
    before = point;
  }
  return builder.time(0, 0.5, 0.005).build();
}

}  // namespace assur::tuning
