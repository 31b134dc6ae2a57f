#include "samples/geometry.hpp"
#include "samples/samples.hpp"

namespace assur::samples {

// Andrews' squeezer, the seven-body mechanism of the IVP test set (Mazzia & Magherini, problem Andrews), as kinematics:
// the crank O-F turns through beta; dyads E(F, B; d, ss), then G(E, A; e, zt) and H(E, A; zf, u).
Scene andrews(const Values& values) {
  const double xa = -0.06934, ya = -0.00227, xb = -0.03635, yb = 0.03273;
  const double rr = 0.007, d = 0.028, ss = 0.035, e = 0.02, zt = 0.04, zf = 0.02, u = 0.04;

  // The guess belongs to the true xb. With the misprinted +0.03635 the mechanism cannot be assembled.
  const Triple A = {xa, ya, 0}, F = {rr, 0, 0};
  const Triple E = meet(F, d, {xb, yb, 0}, ss);
  const Triple G = meet(A, zt, E, e);
  const Triple H = meet(E, zf, A, u);

  return SceneBuilder("andrews", 2)
      .fixed_point("O", {0, 0, 0})
      .fixed_point("A", A)
      .fixed_point("B", {values["xb"], yb, 0})
      .fixed_vector("down", {0, -1, 0})
      .point("F", F)
      .point("E", E)
      .point("G", G)
      .point("H", H)
      .constrain("OF", Distance{"O", "F", rr})
      .constrain("EF", Distance{"E", "F", d})
      .constrain("EB", Distance{"E", "B", ss})
      .constrain("GE", Distance{"G", "E", e})
      .constrain("GA", Distance{"G", "A", zt})
      .constrain("HE", Distance{"H", "E", zf})
      .constrain("HA", Distance{"H", "A", u})
      .drive("motor", PointAngle{"O", "F", "", Law::polynomial({0, values["omega"]})})
      // The angles of the test set. It measures Phi and Omega from directions a quarter turn off.
      .measure("beta", AbsoluteAngle{"O", "F"})
      .measure("theta", AngleBetween{Direction{"O", "F"}, Direction{"E", "F"}, ""})
      .measure("gamma", AngleBetween{"down", Direction{"B", "E"}, ""})
      .measure("delta", AbsoluteAngle{"A", "G"})
      .measure("epsilon", AngleBetween{"down", Direction{"A", "H"}, ""})
      .time(0, 72 * (kTurn / 72 / values.plain("omega")), kTurn / 72 / values.plain("omega"))
      .build();
}

}  // namespace assur::samples
