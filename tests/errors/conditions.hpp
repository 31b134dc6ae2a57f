// Bounds on the difference of two runs of one mechanism, from the conditions of its postures.
#pragma once

#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "equations/system.hpp"
#include "simulation/run.hpp"

namespace assur {}

namespace assur::test {

// Bounds the errors of the coordinates of a posture. If the residual of every equation is at most r s_i, with the scale
// s_i = sum |dPhi_i/dq_j| |q_j| + |constant|, no coordinate has an error above r |J^-1| s.
struct Condition {
  double all = 1;  // max |J^-1| s / largest coordinate
  double own = 1;  // max |J^-1| s / characteristic length, which is smaller than the coordinates far from the origin
};
Condition both_of(const GroupedSystem& structure, std::span<const double> q);
inline double condition(const GroupedSystem& structure, std::span<const double> q) { return both_of(structure, q).all; }

// Conditions of all rows that a run reaches. Only each `every`-th row is examined; the rows between two examined rows
// get the larger of their conditions.
std::vector<double> conditions(const Scene& scene, std::span<const double> times, std::size_t every = 1);

std::vector<Condition> both_conditions(const Scene& scene, std::span<const double> times);

std::vector<double> grid_of(const Scene& scene);

// 0 for positions and values of measures, 1 for rates, 2 for accelerations.
int derivative_of(const std::string& column);

// The largest value, rate and acceleration of all columns of a run; the value is at least 1 rad or 1 m.
struct Sizes {
  double of[3] = {1, 0, 0};
};
Sizes sizes(const Trajectory& t);

// Both runs satisfy their equations to a residual r. The condition of the posture amplifies it once for positions,
// twice for rates and three times for accelerations.
void expect_same_row(std::span<const double> a, const Trajectory& b, std::size_t k, const Sizes& size, double condition,
                     double residual);

// The criterion of convergence, 8 eps, or the reported residuals if they are larger.
inline double residual_of(const Report& a, const Report& b) {
  return std::max({8 * kEps, a.error.position, b.error.position, a.error.velocity, b.error.velocity,
                   a.error.acceleration, b.error.acceleration});
}

}  // namespace assur::test
