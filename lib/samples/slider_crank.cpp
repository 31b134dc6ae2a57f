#include "samples/geometry.hpp"
#include "samples/samples.hpp"

namespace assur::samples {

// Crank about O, rod from B to C, C on the rail through Q = (0, offset) along x; one turn per second. slide.lambda is
// the displacement of C along the rail. If the rod is shorter than the crank, the motion ends at a fold. With equal
// lengths and no offset, two branches cross where C reaches O.
Scene slider_crank(const Values& values) {
  const Number crank = values["crank_length"], rod = values["rod_length"], offset = values["offset"];
  const Number reach = crank + sqrt(rod * rod - offset * offset);
  return SceneBuilder("slider_crank", 2)
      .fixed_point("O", {0, 0, 0})
      .fixed_point("Q", {0, offset, 0})
      .fixed_vector("rail", {1, 0, 0})
      .point("B", {crank, 0, 0})
      .point("C", {reach, offset, 0})
      .constrain("crank", Distance{"O", "B", crank})
      .constrain("rod", Distance{"B", "C", rod})
      .constrain("slide", OnLine{"C", "Q", "rail"})
      .drive("motor", PointAngle{"O", "B", "", Law::polynomial({0, kTurn})})
      .measure("displacement", MeasuredCoordinate{"slide.lambda"})
      .measure("rod_angle", AbsoluteAngle{"B", "C"})
      .time(0, values.plain("steps") * values.plain("step"), values.plain("step"))
      .build();
}

}  // namespace assur::samples
