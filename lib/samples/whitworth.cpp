#include <cmath>

#include "samples/geometry.hpp"
#include "samples/samples.hpp"

namespace assur::samples {

// Whitworth's quick return, tilted in space: the plane of the motion is turned by Rz(0.3) Ry(0.4) Rx(0.5). In that
// plane the crank of length 0.1 turns about the origin O, and its end B slides along the slotted link through Q =
// (pivot, 0). The link points in the direction atan2(0.1 sin, 0.1 cos - pivot), and B is |B - Q| away from Q. The
// closer the pivot is to 0.1, the closer B comes to Q, where the link's direction is undetermined. If the hinge is
// stated (link . axis = 0), the link has one redundant equation.
Scene whitworth(const Values& values) {
  const double crank = 0.1;
  const Number pivot = values["pivot"];
  const Axes tilted = euler_zyx(0.3, 0.4, 0.5);
  const double side = pivot > crank ? -1 : 1;  // side of Q on which B starts

  SceneBuilder builder("whitworth", 3);
  builder.fixed_point("O", {0, 0, 0})
      .fixed_point("Q", pivot * tilted.u)
      .fixed_vector("x", tilted.u)
      .fixed_vector("axis", tilted.w)
      .point("B", crank * tilted.u)
      .vector("link", side * tilted.u)
      .constrain("slide", OnLine{"B", "Q", "link"});
  if (values.word("hinge") == "stated") builder.constrain("hinge", Dot{"link", "axis", 0.0});
  return builder.constrain("crank", Distance{"O", "B", crank})
      .drive("motor", PointAngle{"O", "B", "axis", Law::polynomial({0, values["omega"]})})
      .measure("link_angle", AngleBetween{"x", "link", "axis"})
      .measure("displacement", MeasuredCoordinate{"slide.lambda"})
      .time(0, values.plain("steps") * values.plain("step"), values.plain("step"))
      .build();
}

}  // namespace assur::samples
