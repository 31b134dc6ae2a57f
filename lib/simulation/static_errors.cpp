#include "simulation/static_errors.hpp"

#include <Eigen/SparseLU>
#include <algorithm>
#include <limits>

#include "scene/residual_scale.hpp"
#include "simulation/random_sign.hpp"
#include "simulation/tolerances.hpp"
#include "structure/dense_block.hpp"

namespace assur {
namespace {

std::size_t idx(std::int32_t i) { return static_cast<std::size_t>(i); }

}  // namespace

StaticErrors::StaticErrors(const System& system, const Structure& structure)
    : coordinates_(structure.static_coordinates) {
  std::vector<std::uint8_t> stands(system.coordinates.size(), 0), watched(system.equations.size(), 0);
  for (const std::int32_t c : coordinates_) stands[idx(c)] = 1;
  for (const std::int32_t e : structure.checks) watched[idx(e)] = 1;
  std::vector<std::int32_t> mentioned;
  for (std::size_t e = 0; e < system.equations.size() && !coordinates_.empty(); ++e) {
    if (watched[e] != 0) continue;
    system.mentioned(static_cast<std::int32_t>(e), mentioned);
    const auto solved = [&](std::int32_t c) { return system.coordinates[idx(c)].role == Role::unknown; };
    const bool moves = std::any_of(mentioned.begin(), mentioned.end(),
                                   [&](std::int32_t c) { return solved(c) && stands[idx(c)] == 0; });
    if (!moves && std::any_of(mentioned.begin(), mentioned.end(), solved)) {
      equations_.push_back(static_cast<std::int32_t>(e));
    }
  }
  if (equations_.size() != coordinates_.size()) coordinates_.clear();
}

std::vector<double> StaticErrors::draw(const System& system, const std::vector<double>& q, std::size_t probes,
                                       std::uint64_t seed) const {
  const std::size_t n = coordinates_.size();
  std::vector<double> errors(n * probes, std::numeric_limits<double>::infinity());
  if (n == 0) return errors;
  std::vector<std::int32_t> column(system.coordinates.size(), -1);
  const DenseBlock block(system, equations_, coordinates_, column);
  Eigen::SparseMatrix<double> jacobian = block.sparse_jacobian(q);
  jacobian.makeCompressed();
  Eigen::SparseLU<Eigen::SparseMatrix<double>> lu(jacobian);
  if (lu.info() != Eigen::Success) return errors;
  const Eigen::VectorXd left = block.residuals(q);
  for (std::size_t k = 0; k < probes; ++k) {
    RandomSign sign(seed + k);
    Eigen::VectorXd e = -left;
    for (std::size_t i = 0; i < n; ++i) {
      e[static_cast<Eigen::Index>(i)] += sign() * kSumRounding * size_of_terms(system, equations_[i], q);
    }
    const Eigen::VectorXd error = lu.solve(e);
    std::copy_n(error.data(), n, errors.data() + k * n);
  }
  return errors;
}

}  // namespace assur
