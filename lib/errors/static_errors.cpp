#include "errors/static_errors.hpp"

#include <algorithm>
#include <cmath>

#include "decompositions.hpp"
#include "equations/dense_block.hpp"
#include "equations/residual_scale.hpp"
#include "index.hpp"
#include "numbers.hpp"
#include "outputs/random_sign.hpp"

namespace assur {
namespace {

// A sum and a bound of its rounding error, in units of epsilon / 2. Adding the first term, and products with a number
// of size 1, as of the coordinates of fixed points, cause no rounding.
struct RoundedSum {
  double value = 0, error = 0;

  void add(double coefficient, double term, double term_error) {
    const double product = coefficient * term;
    const bool first = value == 0;
    value += product;
    error += std::abs(coefficient) * term_error;
    if (!first) error += std::abs(value);
    if (std::abs(coefficient) != 1 && std::abs(term) != 1) error += std::abs(product);
  }
};

// Like Evaluator::rounding().
double rounding(const System& s, Index equation, const std::vector<double>& q) {
  const Equation& e = s.equations[idx(equation)];
  if (e.callback >= 0) return 2 * size_of_terms(s, equation, q);
  const auto form = [&](Index f) {
    RoundedSum sum;
    for (const Term& t : s.form(f)) sum.add(s.constants[idx(t.constant)], q[idx(t.coordinate)], 0);
    return sum;
  };
  RoundedSum sum;
  if (e.linear >= 0) sum = form(e.linear);
  for (const Product& p : s.products_of(e)) {
    const RoundedSum a = form(p.a), b = form(p.b);
    const double size = std::abs(a.value * b.value);
    sum.add(s.constants[idx(p.constant)], a.value * b.value,
            a.error * std::abs(b.value) + std::abs(a.value) * b.error + size);
  }
  return sum.error;
}

}  // namespace

StaticErrors::StaticErrors(const System& system, const GroupedSystem& structure)
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

std::vector<double> StaticErrors::draw(const System& system, const std::vector<double>& q,
                                       std::span<const double> known, std::size_t probes, std::uint64_t seed) const {
  const std::size_t n = coordinates_.size();
  std::vector<double> errors(n * (probes + 1), kInfinity);
  if (n == 0) return errors;
  std::vector<std::int32_t> column(system.coordinates.size(), -1);
  const DenseBlock block(system, equations_, coordinates_, column);
  Eigen::SparseMatrix<double> jacobian = block.sparse_jacobian(q);
  jacobian.makeCompressed();
  Eigen::SparseLU<Eigen::SparseMatrix<double>> lu(jacobian);
  if (lu.info() != Eigen::Success) return errors;
  Eigen::VectorXd e = -block.residuals(q);
  for (std::size_t k = 0; k <= probes; ++k) {
    RandomSign sign(seed + k);
    for (std::size_t i = 0; i < n && k > 0; ++i) {
      double& error = e[static_cast<Eigen::Index>(i)];
      error = sign() * kEps * rounding(system, equations_[i], q);
      const double* const moved = known.data() + (k - 1) * q.size();
      gradient<double>(system, equations_[i], q, [&](std::int32_t c, double g) { error -= g * moved[c]; });
    }
    const Eigen::VectorXd error = lu.solve(e);
    std::copy_n(error.data(), n, errors.data() + k * n);
    for (std::size_t i = 0; i < n && k > 0; ++i)
      errors[k * n + i] += sign() * kEps / 2 * std::abs(q[idx(coordinates_[i])]);
  }
  return errors;
}

}  // namespace assur
