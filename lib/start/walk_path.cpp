#include "start/walk_path.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "equations/dense_block.hpp"
#include "equations/own_values.hpp"
#include "equations/residual_scale.hpp"
#include "index.hpp"
#include "numbers.hpp"
#include "start/assembly.hpp"

namespace assur {
namespace {

constexpr double kAsWritten = 1e-9;  // rad or internal units: a driver has its value in the posture as written
constexpr double kHalfTurn = 1e-12;  // rad: a turn by -pi is one by pi
// Internal units. A drawing with rounded numbers is closed by Newton's method if no coordinate moves farther: its walk
// would be long next to a singular posture, and might meet it.
constexpr double kAlmostClosed = 1e-2;

bool close_nearby(const System& s, const std::vector<WalkedPart>& parts, std::vector<double>& q) {
  std::vector<Index> column(s.coordinates.size(), -1);
  std::vector<double> closed = q;
  for (const WalkedPart& p : parts) {
    const bool holds = p.equations.size() == p.unknowns.size()
                           ? assemble(s, p.equations, p.unknowns, closed, column).converged
                           : fit(s, p.equations, p.unknowns, closed, column) <= kConsistent;
    if (!holds) return false;
    for (const Index u : p.unknowns) {
      if (!(std::abs(closed[idx(u)] - q[idx(u)]) <= kAlmostClosed)) return false;
    }
  }
  q = std::move(closed);
  return true;
}

}  // namespace

WalkPath way_to_laws(const System& s, std::span<const double> q, double time) {
  WalkPath way;
  for (const DriverInput& in : s.inputs) {
    const std::vector<double> wanted = wanted_values(s, in, q);
    std::vector<double> from(in.written.begin(), in.written.end());
    for (std::size_t k = 0; k < from.size(); ++k) {
      if (std::isnan(from[k])) from[k] = wanted[k];
    }
    std::vector<double> change = difference(s, in, wanted, from);
    for (std::size_t k = 0; k < change.size(); ++k) {
      if (!is_angle(s, in, k)) continue;
      if (change[k] <= -std::numbers::pi + kHalfTurn) change[k] += kTurn;
      if (s.scene->drivers()[idx(in.driver)].sets_difference) change[k] = in.laws[k](time).value - from[k];
    }
    way.from.push_back(std::move(from));
    way.change.push_back(std::move(change));
  }
  return way;
}

bool is_moving(const System& s, const WalkPath& way) {
  bool moves = false;
  for (std::size_t i = 0; i < way.change.size(); ++i) {
    const DriverInput& in = s.inputs[i];
    for (std::size_t k = 0; k < way.change[i].size(); ++k) {
      const double change = std::abs(way.change[i][k]);
      if (!std::isfinite(change)) return false;  // reported elsewhere
      moves = moves || change > kAsWritten * (is_angle(s, in, k) ? 1 : s.unit(in.dimension));
    }
  }
  return moves;
}

WalkPath closing_way(const System& s, const std::vector<WalkedPart>& parts, const std::vector<double>& q) {
  WalkPath way;
  std::vector<Index> column(s.coordinates.size(), -1);
  for (const WalkedPart& p : parts) {
    const DenseBlock block(s, p.equations, p.unknowns, column);
    if (block.relative_residual(q) <= kSatisfied) continue;
    way.open.resize(s.equations.size(), 0);
    const Eigen::VectorXd phi = block.residuals(q);
    for (Eigen::Index i = 0; i < phi.size(); ++i) way.open[idx(p.equations[static_cast<std::size_t>(i)])] = phi[i];
  }
  for (const DriverInput& in : s.inputs) {
    way.from.push_back(wanted_values(s, in, q));
    way.change.emplace_back(way.from.back().size(), 0.0);
  }
  return way;
}

bool close(const System& s, const std::vector<WalkedPart>& parts, std::vector<double>& q) {
  const WalkPath way = closing_way(s, parts, q);
  if (way.open.empty() || close_nearby(s, parts, q)) return true;
  std::vector<double> closed = q;
  if (walk(s, parts, way, closed).end != Walked::End::arrived) return false;
  q = std::move(closed);
  return true;
}

}  // namespace assur
