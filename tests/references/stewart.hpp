// Closed-form inverse kinematics of the Stewart platform, in quad with two derivatives.
#pragma once

#include <string>

#include "references/posture.hpp"

namespace assur::references {

// The platform of sample("stewart...") with names that end in `suffix`, at time t: O, u, v, w and B, e, r, c, d of
// every leg. Dimensions, axes and laws are the doubles of the scene.
inline Posture<QuadJet> stewart(const Scene& scene, double t, const std::string& suffix = "") {
  Posture<QuadJet> posture;
  const auto law_at = [t](const Law& law) { return evaluate<Quad>(law, Quad(t)); };

  for (const Driver& driver : scene.drivers()) {
    if (driver.name != "pose" + suffix) continue;
    const auto& pose = std::get<Pose>(driver.kind);
    for (std::size_t i = 0; i < 3; ++i) posture["O" + suffix][i] = law_at(pose.translation[i]);
    const QuadJet psi = law_at(pose.rotation[0]), theta = law_at(pose.rotation[1]), phi = law_at(pose.rotation[2]);
    // Applies R = Rz(psi) Ry(theta) Rx(phi).
    const auto turn = [&](QuadJet x, QuadJet y, QuadJet z) -> Vec<QuadJet> {
      const QuadJet y1 = cos(phi) * y - sin(phi) * z, z1 = sin(phi) * y + cos(phi) * z;
      const QuadJet x2 = cos(theta) * x + sin(theta) * z1, z2 = cos(theta) * z1 - sin(theta) * x;
      return {cos(psi) * x2 - sin(psi) * y1, sin(psi) * x2 + cos(psi) * y1, z2};
    };
    const QuadJet zero{}, one{1};
    posture["u" + suffix] = turn(one, zero, zero);
    posture["v" + suffix] = turn(zero, one, zero);
    posture["w" + suffix] = turn(zero, zero, one);
  }

  Posture<QuadJet> all = at_guess<QuadJet>(scene);
  for (const auto& [name, at] : posture) all[name] = at;
  add_members(scene, all);

  for (int leg = 1; all.contains("A" + std::to_string(leg) + suffix); ++leg) {
    const std::string k = std::to_string(leg) + suffix;
    double handle = 0, rod = 0;
    for (const Constraint& c : scene.constraints()) {
      if (c.name == "handle_length" + k) handle = -c.as<Linear>()->terms.at(2).second;
      if (c.name == "rod_length" + k) rod = -c.as<Linear>()->terms.at(2).second;
    }
    // Works in the plane through A perpendicular to a: x points towards P, y = a x x. The law of cosines holds in the
    // triangle A, B, P seen along a.
    const Vec<QuadJet> AP = all.at("P" + k) - all.at("A" + k), a = unit(all.at("a" + k));
    const QuadJet height = dot(AP, a);
    const Vec<QuadJet> x = unit(AP - height * a), y = cross(a, x);
    const QuadJet reach = dot(AP, x);
    const QuadJet rod_seen = Quad(rod) * Quad(rod) - height * height;  // square of the length of the rod seen along a
    const QuadJet cosine = (reach * reach + Quad(handle) * Quad(handle) - rod_seen) / (2 * Quad(handle) * reach);
    const Vec<QuadJet> e = cosine * x + sqrt(1 - cosine * cosine) * y;
    const Vec<QuadJet> B = all.at("A" + k) + QuadJet{handle} * e;
    const Vec<QuadJet> r = unit(all.at("P" + k) - B), c = unit(cross(r, all.at("t" + k)));
    posture["B" + k] = B;
    posture["e" + k] = e;
    posture["r" + k] = QuadJet{Quad(1) / Quad(rod)} * (all.at("P" + k) - B);
    posture["c" + k] = c;
    posture["d" + k] = cross(r, c);
  }
  return posture;
}

// Angle of handle k about its axis, like the measure handleK of the scene.
inline QuadJet stewart_handle(const Scene& scene, const Posture<QuadJet>& posture, const std::string& k) {
  const Posture<QuadJet> fixed = at_guess<QuadJet>(scene);
  const Vec<QuadJet>&a = fixed.at("a" + k), &zero = fixed.at("inward" + k), &e = posture.at("e" + k);
  return atan2(dot(a, cross(zero, e)), dot(zero, e));
}

}  // namespace assur::references
