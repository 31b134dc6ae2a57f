// Linkages and their motions, for tests of fleets.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "assur/assur.hpp"
#include "numbers.hpp"
#include "sweep/random_linkage.hpp"

namespace assur::test {

using Joint = LinkageJoint;

inline TimeGrid one_turn(int steps) { return {0, 1, 1.0 / steps}; }

inline std::vector<double> times_of(const TimeGrid& grid) {
  std::vector<double> times;
  for (std::int64_t k = 0; k <= grid.steps(); ++k) times.push_back(grid.time(k));
  return times;
}

inline Linkage random_one(std::size_t k) {
  Linkage linkage;
  sweep::random_linkage(7, k, {5, 20}, linkage);
  return linkage;
}
inline void random_into(std::size_t k, Linkage& to) { sweep::random_linkage(7, k, {5, 20}, to); }

// A motion that outlives the sink.
struct Kept {
  LinkageMotion motion;
  std::vector<PlanePoint> path;
};

inline std::vector<Kept> run(const Fleet& fleet, const std::vector<double>& times, const FleetOptions& options = {}) {
  std::vector<Kept> out(fleet.members());
  const auto keep = [&](std::size_t i, const LinkageMotion& motion) {
    out[i] = {motion, {motion.path.begin(), motion.path.end()}};
  };
  (void)fleet.stream(keep, times, options);
  return out;
}
inline Kept run(const Linkage& linkage, const std::vector<double>& times) { return run(Fleet({linkage}), times)[0]; }

// Grounds at 0 and (distance, 0); the path is that of the dyad.
inline Linkage four_bar(double crank, double coupler, double rocker, double distance, double angle = 0) {
  return {{Joint::ground(0, 0), Joint::crank(0, crank, angle, kTurn), Joint::ground(distance, 0),
           Joint::dyad(1, 2, coupler, rocker, true)}};
}

// A crank-rocker whose coupler carries a link on three rods: a triad between the crank, the coupler's joint and the
// ground. What varies are lengths and places.
inline Linkage with_triad(std::size_t k) {
  std::mt19937_64 engine(k);
  const auto near = [&](double value, double by) {
    return value + by * (2 * static_cast<double>(engine() >> 11) * 0x1p-53 - 1);
  };
  Linkage linkage = four_bar(1, near(3, 0.2), near(2.5, 0.2), near(3, 0.2), near(0, 3));
  linkage.joints.push_back(Joint::ground(near(0, 1), near(5, 1)));
  const double crank_x = std::cos(linkage.joints[1].value[1]), crank_y = std::sin(linkage.joints[1].value[1]);
  const std::array<PlanePoint, 3> at = {PlanePoint{near(crank_x - 1, 0.5), near(crank_y + 2.5, 0.5)},
                                        {near(3.5, 0.5), near(4, 0.5)},
                                        {near(1, 0.5), near(4, 0.5)}};
  linkage.joints.push_back(Joint::triad(1, near(2.8, 0.4), at[0][0], at[0][1]));
  linkage.joints.push_back(Joint::triad(3, near(2, 0.4), at[1][0], at[1][1]));
  linkage.joints.push_back(Joint::triad(4, near(2, 0.4), at[2][0], at[2][1]));
  return linkage;
}

inline double largest(const std::vector<PlanePoint>& path) {
  double size = 0;
  for (const PlanePoint& p : path) size = std::max({size, std::abs(p[0]), std::abs(p[1])});
  return size;
}

}  // namespace assur::test
