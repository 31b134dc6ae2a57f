#include <array>
#include <string>

#include "samples/geometry.hpp"
#include "samples/samples.hpp"
#include "scene/jet.hpp"

namespace assur::samples {
namespace {

double azimuth(int k) {
  const int third = k / 2;
  return kTurn / 3 * third + (k % 2 == 0 ? -0.3 : 0.3);
}

// Pose of the terminal: it moves up and down, and turns about its own axes.
struct Poses {
  std::array<Law, 3> translation, rotation;

  explicit Poses(const Number& omega)
      : translation{wave(0.1, omega, 0), wave(0.1, omega, 1), wave(0.1, omega, 2, 1)},
        rotation{wave(0.1, omega, 0.5), wave(0.1, omega, 1.5), wave(0.1, omega, 2.5)} {}
};

// Length of the leg from A to the point P of the terminal, with its derivatives.
Motion leg_length(const Poses& poses, const Triple& A, const Triple& P, double t) {
  const Motion psi = poses.rotation[0](t), theta = poses.rotation[1](t), phi = poses.rotation[2](t);
  const Motion cp = cos(psi), sp = sin(psi), ct = cos(theta), st = sin(theta), cf = cos(phi), sf = sin(phi);
  const Motion dx = poses.translation[0](t) + cp * ct * P[0] + (cp * st * sf - sp * cf) * P[1] - A[0];
  const Motion dy = poses.translation[1](t) + sp * ct * P[0] + (sp * st * sf + cp * cf) * P[1] - A[1];
  const Motion dz = poses.translation[2](t) - st * P[0] + ct * sf * P[1] - A[2];
  return sqrt(dx * dx + dy * dy + dz * dz);
}

}  // namespace

// Base of radius 1 and platform of radius 0.5, both with joints at 120 k -+ 0.3 rad. The hexagons are similar, so the
// lengths of the six legs determine the pose in no posture (rank 5 at most). Driven by its pose the platform moves;
// driven by its legs, with the lengths of that motion, it is undetermined.
Scene hexapod(const Values& values) {
  const bool by_legs = values.word("drive") == "legs";
  const Poses poses(values["omega"]);
  const auto at_start = [](const std::array<Law, 3>& laws) {
    return Triple{laws[0](0).value, laws[1](0).value, laws[2](0).value};
  };
  const Triple angles = at_start(poses.rotation);
  const Axes axes = euler_zyx(angles[0], angles[1], angles[2]);

  SceneBuilder builder("hexapod", 3);
  builder.point("O", at_start(poses.translation)).vector("u", axes.u).vector("v", axes.v).vector("w", axes.w);
  Body terminal{"terminal", "O", {"u", "v", "w"}, {}, {}, {}};
  for (int k = 0; k < 6; ++k) {
    const std::string number = std::to_string(k + 1), A = "A" + number, P = "P" + number;
    const Triple base = heading(azimuth(k)), local = 0.5 * base;
    builder.fixed_point(A, base);
    terminal.points.push_back({P, local});
    if (by_legs) {
      const auto length = [poses, base, local](double t) { return leg_length(poses, base, local, t); };
      builder.drive("leg" + number, DrivenDistance{A, P, Law::function(length)});
    } else {
      builder.measure("leg" + number, MeasuredDistance{A, P});
    }
  }
  builder.add(std::move(terminal));
  if (!by_legs) {
    builder.drive("pose", Pose{"terminal",
                               {poses.translation.begin(), poses.translation.end()},
                               {poses.rotation.begin(), poses.rotation.end()}});
  }
  return builder.time(0, values.plain("steps") * values.plain("step"), values.plain("step")).build();
}

}  // namespace assur::samples
