#include <array>
#include <string>

#include "samples/geometry.hpp"
#include "samples/gough_postures.hpp"
#include "samples/samples.hpp"

namespace assur::samples {
namespace {

struct Leg {
  Triple A, B;    // on the base, and on the platform (local)
  double length;  // m
};
constexpr std::array<Leg, 6> kLegs = {{{{0, 0, 0}, {0, 0, 0}, 1},
                                       {{1.107915, 0, 0}, {0.542805, 0, 0}, 0.645275},
                                       {{0.549094, 0.756063, 0}, {0.956919, -0.528915, 0}, 1.086284},
                                       {{0.735077, -0.223935, 0.525991}, {0.665885, -0.353482, 1.402538}, 1.503439},
                                       {{0.514188, -0.526063, -0.368418}, {0.478359, 1.158742, 0.107672}, 1.281933},
                                       {{0.590473, 0.094733, -0.205018}, {-0.137087, -0.235121, 0.353913}, 0.771071}}};

}  // namespace

// Forward kinematics of Dietmaier's platform (see gough_postures.hpp): six actuators are fixed, the pose is unknown.
Scene gough(const Values& values) {
  const auto& guess = kGoughPostures[static_cast<std::size_t>(values.count("posture") - 1)];
  const Triple n = {guess[0], guess[1], guess[2]};
  const Triple u = unit({guess[3], guess[4], guess[5]}), v = unit({guess[6], guess[7], guess[8]});

  SceneBuilder builder("gough", 3);
  builder.point("B1", kLegs[0].A + n).vector("u", u).vector("v", v).vector("w", cross(u, v));
  Body platform{"platform", "B1", {"u", "v", "w"}, {}, {}, {}};
  for (std::size_t i = 0; i < kLegs.size(); ++i) {
    const std::string k = std::to_string(i + 1);
    builder.fixed_point("A" + k, kLegs[i].A);
    if (i > 0) platform.points.push_back({"B" + k, kLegs[i].B});
    builder.drive("leg" + k, DrivenDistance{"A" + k, "B" + k, Law::constant(kLegs[i].length)});
  }
  return builder.add(std::move(platform)).time(0, 0, 1).build();
}

}  // namespace assur::samples
