#include "errors/conditions.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "decompositions.hpp"
#include "plan/preparation.hpp"
#include "simulation/simulator_access.hpp"

namespace assur::test {

Condition both_of(const GroupedSystem& structure, std::span<const double> q) {
  const System& system = *structure.system;
  std::vector<Eigen::Index> column(system.coordinates.size(), -1);
  std::vector<Index> equations;
  Eigen::Index n = 0;
  for (const SolvedGroup& g : structure.groups) {
    for (const std::int32_t u : g.unknowns) column[static_cast<std::size_t>(u)] = n++;
    equations.insert(equations.end(), g.equations.begin(), g.equations.end());
  }
  if (n == 0) return {};
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd scale(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Index equation = equations[static_cast<std::size_t>(i)];
    gradient<double>(system, equation, q, [&](Index c, double v) {
      if (column[static_cast<std::size_t>(c)] >= 0) jacobian(i, column[static_cast<std::size_t>(c)]) += v;
    });
    scale[i] = residual_scale(system, equation, q);
  }
  const Eigen::VectorXd open = jacobian.partialPivLu().inverse().cwiseAbs() * scale;
  double largest = 0;
  for (const double x : q.subspan(1)) largest = std::max(largest, std::abs(x));
  const double all = std::max(1.0, open.maxCoeff() / largest);
  return {all, std::max(all, open.maxCoeff())};  // one internal unit is the characteristic length
}

std::vector<double> conditions(const Scene& scene, std::span<const double> times, std::size_t every) {
  Simulator s = simulator(scene, "groups/eigen");
  std::vector<double> out;
  for (std::size_t k = 0; k < times.size(); ++k) {
    if (!s.step(times[k]).arrived()) break;
    if (k % every != 0 && k + 1 != times.size()) {
      out.push_back(0);
      continue;
    }
    out.push_back(condition(*preparation(s.prepared()).structure, SimulatorAccess::posture(s)));
    for (std::size_t j = k; j-- > 0 && out[j] == 0;) out[j] = std::max(out[k], out[k - (k - 1) % every - 1]);
  }
  return out;
}

std::vector<Condition> both_conditions(const Scene& scene, std::span<const double> times) {
  Simulator s = simulator(scene, "groups/eigen");
  std::vector<Condition> out;
  for (const double t : times) {
    if (!s.step(t).arrived()) break;
    out.push_back(both_of(*preparation(s.prepared()).structure, SimulatorAccess::posture(s)));
  }
  return out;
}

std::vector<double> grid_of(const Scene& scene) {
  std::vector<double> times;
  for (std::int64_t k = 0; k <= scene.time().steps(); ++k) times.push_back(scene.time().time(k));
  return times;
}

int derivative_of(const std::string& column) {
  const std::string last = column.substr(column.rfind('.') + 1);
  if (last == "rate" || (last.size() == 2 && last[0] == 'v')) return 1;
  if (last == "acceleration" || (last.size() == 2 && last[0] == 'a')) return 2;
  return 0;
}

Sizes sizes(const Trajectory& t) {
  Sizes s;
  for (std::size_t c = 0; c < t.columns().size(); ++c) {
    const int d = derivative_of(t.columns()[c]);
    for (std::size_t k = 0; k < t.rows(); ++k) s.of[d] = std::max(s.of[d], std::abs(t(k, c)));
  }
  return s;
}

void expect_same_row(std::span<const double> a, const Trajectory& b, std::size_t k, const Sizes& size, double condition,
                     double residual) {
  double bound[3] = {2 * residual * condition * size.of[0]};
  for (int d = 1; d < 3; ++d)
    bound[d] = 2 * residual * std::pow(condition, d + 1) * std::max(size.of[d], size.of[d - 1]);
  for (std::size_t c = 0; c < b.columns().size(); ++c) {
    const int d = derivative_of(b.columns()[c]);
    const double off = std::abs(a[c] - b(k, c));
    if (off <= bound[d]) continue;
    ADD_FAILURE() << b.columns()[c] << " in row " << k << ", t = " << b.times()[k] << ": " << a[c] << " and " << b(k, c)
                  << " are " << off << " apart, bound " << bound[d];
    return;
  }
}

}  // namespace assur::test
