#include "verification/reference_motion.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>

#include "equations/drive.hpp"
#include "equations/lowering.hpp"
#include "equations/outputs.hpp"
#include "graph/demand.hpp"
#include "index.hpp"
#include "plan/preparation.hpp"
#include "scene/law_evaluate.hpp"
#include "structure/grouped_system.hpp"

namespace assur {
namespace {

// After a contracting correction this small, the error is below a millionth of the rounding of doubles.
constexpr double kQuadConverged = 1e-22;
constexpr double kConvergedCallback = 1e-10;  // callbacks compute doubles, so smaller residuals are rounding
constexpr double kQuadHandover = 1e-9;        // correction at which Newton in double hands over to quad,
constexpr double kStagnated = 1e-6;           // or at which rounding may end it in a badly conditioned block
constexpr double kQuadContraction = 1.0 / 8;  // ratio of simplified Newton corrections: Kantorovich number <= 1/4
constexpr int kMostCorrections = 24;          // of Newton's method; at kQuadContraction they gain 21 digits
constexpr int kQuadHalvings = 20;             // of a step, as in motions (Continuation::kStepHalvings)

double infinity_norm(const Eigen::VectorXd& x) { return x.allFinite() ? x.lpNorm<Eigen::Infinity>() : HUGE_VAL; }

}  // namespace

void ReferenceLu::compute(const DenseBlock& block, const std::vector<double>& q) {
  is_dense_ = block.rows() <= kLargestDenseLu;
  if (is_dense_) {
    dense_.compute(block.jacobian(q));
  } else {
    sparse_.compute(block.sparse_jacobian(q));
  }
}

Eigen::VectorXd ReferenceLu::solve(const Eigen::VectorXd& b) const {
  if (is_dense_) return dense_.solve(b);
  if (sparse_.info() != Eigen::Success) return Eigen::VectorXd::Constant(b.size(), std::nan(""));
  return sparse_.solve(b);
}

int ReferenceLu::determinant_sign() const {
  if (!is_dense_) {
    if (sparse_.info() != Eigen::Success) return 0;
    return const_cast<ReferenceLu*>(this)->sparse_.signDeterminant() < 0 ? -1 : 1;
  }
  int sign = dense_.permutationP().determinant() < 0 ? -1 : 1;
  for (const double u : dense_.matrixLU().diagonal()) sign *= u > 0 ? 1 : u < 0 ? -1 : 0;
  return sign;
}

ReferenceMotion::ReferenceMotion(const Prepared& of)
    : system_(lower(preparation(of).scene, of.controlled(), of.structure().formulation() != Formulation::irreducible)) {
  const Preparation& prepared = preparation(of);
  const std::size_t n = system_.coordinates.size();
  column_.assign(n, -1);
  rounded_.assign(n, 0.0);
  constants_.assign(system_.constants.begin(), system_.constants.end());
  for (auto& f : form_) f.resize(idx(system_.forms()));
  find_blocks(*prepared.structure);

  state_.q[0].assign(prepared.structure->start.begin(), prepared.structure->start.end());
  state_.q[1].assign(n, Quad(0));
  state_.q[2].assign(n, Quad(0));
  state_.determinant_sign.assign(blocks_.size(), 0);
  const double start = prepared.time.start;
  drive(start);
  for (const Block& block : blocks_) {
    if (!solve(block, false)) refuse(start);
  }
}

// The equations that the structure solves, without those that it only watches.
void ReferenceMotion::find_blocks(const GroupedSystem& structure) {
  std::vector<std::uint8_t> moves(system_.coordinates.size(), 0);
  std::vector<Index> equations, unknowns, mentioned;
  for (std::size_t c = 0; c < system_.coordinates.size(); ++c) {
    if (system_.coordinates[c].role == Role::unknown) unknowns.push_back(static_cast<Index>(c));
    moves[c] = system_.coordinates[c].role == Role::driven && system_.coordinates[c].moving ? 1 : 0;
  }
  std::vector<std::uint8_t> watched(system_.equations.size(), 0);
  for (const Index e : structure.checks) watched[idx(e)] = 1;
  for (std::size_t e = 0; e < watched.size(); ++e) {
    if (watched[e] == 0) equations.push_back(static_cast<Index>(e));
  }
  decomposition_ = decompose(system_, equations, unknowns);

  std::vector<std::int8_t> need = needed_by_outputs(system_, wanted_outputs(system_));
  const std::vector<std::uint8_t> needed = needed_blocks(system_, decomposition_, need);

  // `need` now includes the inputs of all needed blocks.
  std::vector<std::uint8_t> read(need.size());
  std::transform(need.begin(), need.end(), read.begin(), [](std::int8_t n) { return n >= 0 ? 1 : 0; });
  driven_ = driven_behind(system_, std::move(read));

  for (Index b = 0; b < decomposition_.size(); ++b) {
    Block block = block_of(b);
    const auto reads_moving = [&](Index e) {
      system_.mentioned(e, mentioned);
      return std::any_of(mentioned.begin(), mentioned.end(), [&](Index c) { return moves[idx(c)] != 0; });
    };
    block.moves = std::any_of(block.equations.begin(), block.equations.end(), reads_moving);
    for (const Index u : block.unknowns) moves[idx(u)] = block.moves ? 1 : 0;
    if (needed[idx(b)] == 0) continue;
    block.index = blocks_.size();
    blocks_.push_back(std::move(block));
  }
}

ReferenceMotion::Block ReferenceMotion::block_of(Index b) const {
  Block block;
  block.equations = decomposition_.equations_of(b);
  block.unknowns = decomposition_.unknowns_of(b);
  block.tolerance = kQuadConverged;
  for (const Index e : block.equations) {
    const Equation& equation = system_.equations[idx(e)];
    if (equation.linear >= 0) block.forms.push_back(equation.linear);
    for (const Product& p : system_.products_of(equation)) block.forms.insert(block.forms.end(), {p.a, p.b});
    if (equation.callback >= 0) {
      const auto& arguments = system_.callbacks[idx(equation.callback)].coordinates;
      block.forms.insert(block.forms.end(), arguments.begin(), arguments.end());
      block.tolerance = kConvergedCallback;
    }
  }
  std::sort(block.forms.begin(), block.forms.end());
  block.forms.erase(std::unique(block.forms.begin(), block.forms.end()), block.forms.end());
  return block;
}

void ReferenceMotion::advance(double t, int pieces) {
  const double span = t - state_.time;
  double h = span / pieces;
  while (state_.time != t) {
    const bool last = std::abs(t - state_.time) <= std::abs(h) * (1 + 1e-12);
    const double target = last ? t : state_.time + h;
    if (target == state_.time) refuse(t);  // halved below the spacing of doubles
    // The sign of a determinant changes at change points only, which only the smallest step may pass.
    const bool smallest = std::abs(h) <= std::ldexp(std::abs(span), -kQuadHalvings);
    if (step(target, smallest)) {
      h = std::copysign(std::min(2 * std::abs(h), std::abs(span / pieces)), span);
    } else if (smallest) {
      refuse(target);
    } else {
      h = (target - state_.time) / 2;
    }
  }
}

bool ReferenceMotion::step(double t, bool any_sign) {
  State before = state_;
  predict(t);
  drive(t);
  for (const Block& block : blocks_) {
    if (!block.moves || solve(block, any_sign)) continue;
    state_ = std::move(before);
    return false;
  }
  return true;
}

void ReferenceMotion::predict(double t) {
  const Quad h = Quad(t) - Quad(state_.time), half_square = h * h / 2;
  for (const Block& block : blocks_) {
    if (!block.moves) continue;
    for (const Index u : block.unknowns) {
      state_.q[0][idx(u)] += h * state_.q[1][idx(u)] + half_square * state_.q[2][idx(u)];
    }
  }
}

void ReferenceMotion::drive(double t) {
  state_.time = t;
  const auto law = [&](std::size_t input, int k) {
    return evaluate<Quad>(system_.inputs[input].laws[static_cast<std::size_t>(k)], Quad(t));
  };
  assur::drive<Quad>(system_, driven_, law, state_.q[0].data(), state_.q[1].data(), state_.q[2].data());
  scale_ = {1, 0, 0};
  for (std::size_t c = 0; c < rounded_.size(); ++c) {
    rounded_[c] = static_cast<double>(state_.q[0][c]);
    if (system_.coordinates[c].role != Role::driven) continue;
    for (const std::size_t d : {1u, 2u}) scale_[d] = std::max(scale_[d], std::abs(static_cast<double>(state_.q[d][c])));
  }
  scale_[2] = std::max(scale_[2], scale_[1] * scale_[1]);
}

bool ReferenceMotion::solve(const Block& block, bool any_sign) {
  lost_ = block.unknowns.front();
  const DenseBlock jacobian(system_, block.equations, block.unknowns, column_);
  if (!approach(block, jacobian)) return false;
  lu_.compute(jacobian, rounded_);
  int& sign = state_.determinant_sign[block.index];
  if (sign != 0 && sign != lu_.determinant_sign() && !any_sign) return false;
  sign = lu_.determinant_sign();
  for (const Index u : block.unknowns) state_.q[0][idx(u)] = rounded_[idx(u)];
  for (int d = 0; d < 3; ++d) {
    if (!refine(block, d)) return false;
    evaluate_forms(block, d);  // once more, after the last correction
  }
  for (const Index u : block.unknowns) rounded_[idx(u)] = static_cast<double>(state_.q[0][idx(u)]);
  return true;
}

// Newton in double with the Jacobian of the prediction.
bool ReferenceMotion::approach(const Block& block, const DenseBlock& jacobian) {
  lu_.compute(jacobian, rounded_);
  double before = HUGE_VAL;
  for (int k = 0; k < kMostCorrections; ++k) {
    const Eigen::VectorXd correction = lu_.solve(jacobian.residuals(rounded_));
    const double norm = infinity_norm(correction);
    if (norm == HUGE_VAL) return false;
    double size = scale_[0];
    for (const Index u : block.unknowns) size = std::max(size, std::abs(rounded_[idx(u)]));
    if (norm > kQuadContraction * before) return norm <= kStagnated * size;
    for (Eigen::Index i = 0; i < correction.size(); ++i) {
      rounded_[idx(block.unknowns[static_cast<std::size_t>(i)])] -= correction[i];
    }
    if (norm <= kQuadHandover * size) return true;
    before = norm;
  }
  return false;
}

void ReferenceMotion::evaluate_forms(const Block& block, int d) {
  const std::vector<Quad>& q = state_.q[static_cast<std::size_t>(d)];
  for (const Index f : block.forms) {
    Quad& sum = form_[static_cast<std::size_t>(d)][idx(f)];
    sum = 0;
    for (const Term& t : system_.form(f)) sum += constants_[idx(t.constant)] * q[idx(t.coordinate)];
  }
}

// The d-th derivative of the block's unknowns, from residuals in quad and corrections in double.
bool ReferenceMotion::refine(const Block& block, int d) {
  std::vector<Quad>& q = state_.q[static_cast<std::size_t>(d)];
  const double tolerance = d == 0 ? block.tolerance : kQuadConverged;
  Eigen::VectorXd left(static_cast<Eigen::Index>(block.unknowns.size()));
  double before = HUGE_VAL;
  for (int k = 0; k < kMostCorrections; ++k) {
    evaluate_forms(block, d);
    for (Eigen::Index i = 0; i < left.size(); ++i) {
      left[i] = static_cast<double>(equation(block.equations[static_cast<std::size_t>(i)], d));
    }
    const Eigen::VectorXd correction = lu_.solve(left);
    const double norm = infinity_norm(correction);
    double size = scale_[static_cast<std::size_t>(d)];
    for (Eigen::Index i = 0; i < left.size(); ++i) {
      Quad& x = q[idx(block.unknowns[static_cast<std::size_t>(i)])];
      x -= correction[i];
      size = std::max(size, std::abs(static_cast<double>(x)));
    }
    if (norm <= tolerance * size) return true;
    if (!(norm <= kQuadContraction * before)) return false;
    before = norm;
  }
  return false;
}

// The d-th time derivative of an equation, computed from the derivatives of its forms.
Quad ReferenceMotion::equation(Index e, int d) const {
  const Equation& equation = system_.equations[idx(e)];
  if (equation.callback >= 0) return callback(e, d);
  Quad sum = equation.linear >= 0 ? form_[static_cast<std::size_t>(d)][idx(equation.linear)] : Quad(0);
  for (const Product& p : system_.products_of(equation)) {
    const auto a = [&](std::size_t k) -> const Quad& { return form_[k][idx(p.a)]; };
    const auto b = [&](std::size_t k) -> const Quad& { return form_[k][idx(p.b)]; };
    const Quad product = d == 0   ? a(0) * b(0)
                         : d == 1 ? a(1) * b(0) + a(0) * b(1)
                                  : a(2) * b(0) + 2 * (a(1) * b(1)) + a(0) * b(2);
    sum += constants_[idx(p.constant)] * product;
  }
  return sum;
}

// Callbacks compute in double, so the reference is only as good as their residual, Jacobian and curvature.
Quad ReferenceMotion::callback(Index e, int d) const {
  if (d == 0) return residual<Quad>(system_, e, state_.q[0]);
  const Equation& equation = system_.equations[idx(e)];
  const CallbackBlock& block = system_.callbacks[idx(equation.callback)];
  const std::size_t m = block.coordinates.size(), row = idx(equation.row);
  const auto rows = static_cast<std::size_t>(block.callback->equations);
  std::vector<double> x(m), rate(m), jacobian(m * rows), curvature(rows, 0.0);
  for (std::size_t i = 0; i < m; ++i) {
    x[i] = static_cast<double>(form_[0][idx(block.coordinates[i])]) * block.unit[i];
    rate[i] = static_cast<double>(form_[1][idx(block.coordinates[i])]) * block.unit[i];
  }
  block.callback->jacobian(x, jacobian);
  if (d == 2) block.callback->curvature(x, rate, curvature);
  Quad sum = curvature[row];
  for (std::size_t i = 0; i < m; ++i) {
    sum += Quad(jacobian[row * m + i] * block.unit[i]) * form_[static_cast<std::size_t>(d)][idx(block.coordinates[i])];
  }
  return sum;
}

void ReferenceMotion::refuse(double t) const {
  char text[32];
  const std::string time(text, std::to_chars(text, text + sizeof text, t).ptr);
  throw Error(Error::Kind::numerical, "the reference in quad precision does not converge at t = " + time +
                                          " s, in the group of " + system_.coordinate_name(lost_));
}

}  // namespace assur
