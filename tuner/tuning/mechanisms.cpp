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

}  // namespace assur::tuning
