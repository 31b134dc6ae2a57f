#include "check/condition.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "decompositions.hpp"
#include "equations/system.hpp"
#include "plan/preparation.hpp"
#include "simulation/simulator_access.hpp"

namespace assur {}

namespace assur::check {
namespace {

constexpr std::int64_t kMostUnknowns = 400;  // for dense matrices
constexpr std::int64_t kWork = 4'000'000;    // unknowns cubed x postures

// The Jacobian of all groups of a structure, with scales of its equations and unknowns.
class Jacobian {
 public:
  explicit Jacobian(const GroupedSystem& structure) : system_(*structure.system) {
    column_.assign(system_.coordinates.size(), -1);
    for (const SolvedGroup& g : structure.groups) {
      for (const std::int32_t u : g.unknowns) column_[static_cast<std::size_t>(u)] = n_++;
      equations_.insert(equations_.end(), g.equations.begin(), g.equations.end());
    }
  }

  [[nodiscard]] Eigen::Index size() const { return n_; }

  [[nodiscard]] double condition(std::span<const double> q) const {
    Eigen::MatrixXd j = Eigen::MatrixXd::Zero(n_, n_);
    Eigen::VectorXd scale(n_);
    for (Eigen::Index i = 0; i < n_; ++i) {
      const Index equation = equations_[static_cast<std::size_t>(i)];
      gradient<double>(system_, equation, q, [&](Index c, double value) {
        if (const Eigen::Index to = column_[static_cast<std::size_t>(c)]; to >= 0) j(i, to) += value;
      });
      scale[i] = residual_scale(system_, equation, q);
    }
    double largest = 0;
    for (const double x : q.subspan(1)) largest = std::max(largest, std::abs(x));
    return std::max(1.0, (j.partialPivLu().inverse().cwiseAbs() * scale).maxCoeff() / largest);
  }

 private:
  const System& system_;
  std::vector<Eigen::Index> column_;  // coordinates
  std::vector<Index> equations_;
  Eigen::Index n_ = 0;
};

}  // namespace

std::optional<double> worst_condition(const Prepared& prepared, const std::function<bool()>& stop) {
  const Jacobian jacobian(*preparation(prepared).structure);
  const std::int64_t n = jacobian.size();
  if (n == 0 || n > kMostUnknowns) return std::nullopt;
  Simulator simulator(prepared);
  double worst = jacobian.condition(SimulatorAccess::posture(simulator));
  const std::int64_t every = std::max<std::int64_t>(1, n * n * n * prepared.time().steps() / kWork);
  (void)simulator.run([&](std::int64_t done, std::int64_t of) {
    if (done % every == 0 || done == of)
      worst = std::max(worst, jacobian.condition(SimulatorAccess::posture(simulator)));
    return stop();
  });
  // The last posture may be the nearest to a singularity that ended the motion.
  worst = std::max(worst, jacobian.condition(SimulatorAccess::posture(simulator)));
  return std::isfinite(worst) ? std::optional(worst) : std::nullopt;
}

}  // namespace assur::check
