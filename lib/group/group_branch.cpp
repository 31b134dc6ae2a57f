// The branch care of GroupSolver: how far a posture may move and still be on the branch of the last anchor.
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "group/group_solver.hpp"
#include "index.hpp"
#include "numbers.hpp"

namespace assur {
namespace {

constexpr double kFold = 30;  // velocity over input velocity near a singularity that makes it a fold

}  // namespace

double GroupSolver::ball_use(const Pack& pack, const double* x, std::int32_t b) const {
  const auto reads = blocks_.reads(b);
  return kernels_.ball_use(reads.data(), static_cast<std::int32_t>(reads.size()), program_.n, x, inputs_.data(),
                           pack.anchor.data() + blocks_.reads_start(b) * idx(lanes_), pack.omega.data() + b * lanes_);
}

// The same of one lane.
double GroupSolver::ball_use_of(const Pack& pack, const double* x, std::int32_t b, std::int32_t lane) const {
  const double* anchor = pack.anchor.data() + blocks_.reads_start(b) * idx(lanes_) + lane;
  double moved = 0;
  for (const std::int32_t c : blocks_.reads(b)) {
    const double at = c < program_.n ? x[c * lanes_ + lane] : inputs_[idx((c - program_.n) * lanes_ + lane)];
    const double by = std::abs(at - *anchor);
    if (!(by <= moved)) moved = by;
    anchor += lanes_;
  }
  return pack.omega[idx(b * lanes_ + lane)] * moved;
}

// Of what left the ball of one norm for all coordinates. The lane that is furthest off is told.
Status GroupSolver::check_tubes(const Pack& pack, double* const (&state)[3], std::int32_t b, const Attempt& attempt) {
  const double seconds = attempt.time - pack.anchor_time[idx(b)];
  const double* x = state[0] + pack.unknowns;
  Status worst;
  for (std::int32_t l = 0; l < pack.used; ++l) {
    const double used = ball_use_of(pack, x, b, l);
    if (used <= std::max(kBall, worst.figure) || tube_leads_here(pack, state, b, l, seconds)) continue;
    worst = fail(pack, Code::branch_unknown, used, l);
  }
  return worst;
}

// From the anchor, which was `seconds` ago, along the cubic with the rates of both postures.
bool GroupSolver::tube_leads_here(const Pack& pack, double* const (&state)[3], std::int32_t b, int lane,
                                  double seconds) {
  const double *x = state[0] + pack.unknowns, *rate = state[1] + pack.unknowns;
  if (!std::isfinite(seconds) || !blocks_.invert(b, lane, jacobian_.data())) return false;
  gather(pack, state[1], input_rates_);
  const auto reads = blocks_.reads(b);
  const std::size_t w = idx(lanes_), first = blocks_.reads_start(b) * w + idx(lane);
  std::copy_n(x, there_.size(), there_.begin());
  there_inputs_ = inputs_;
  bool leads = true;
  for (const double t : kAlongTheTube) {
    const double s = 1 - t, end = t * t * (3 - 2 * t), begin = 1 - end;
    for (std::size_t i = 0; i < reads.size(); ++i) {
      const bool unknown = reads[i] < program_.n;
      const std::size_t at = idx(unknown ? reads[i] : reads[i] - program_.n) * w + idx(lane);
      const double q0 = pack.anchor[first + i * w], v0 = pack.anchor_rates[first + i * w];
      const double q1 = unknown ? x[at] : inputs_[at], v1 = unknown ? rate[at] : input_rates_[at];
      (unknown ? there_ : there_inputs_)[at] = begin * q0 + end * q1 + seconds * t * s * (s * v0 - t * v1);
    }
    evaluator_->set_inputs(pack.coefficients.data(), there_inputs_.data());
    evaluator_->evaluate(there_.data(), there_phi_.data(), there_jacobian_.data());
    evaluator_->scale(scale_.data());
    leads = blocks_.holds_one_solution(b, lane, jacobian_.data(), there_jacobian_.data(), there_phi_.data(),
                                       scale_.data(), pack.coefficients.data());
    if (!leads) break;
  }
  evaluator_->set_inputs(pack.coefficients.data(), inputs_.data());
  evaluator_->evaluate(x, phi_.data(), jacobian_.data());
  return leads;
}

// The posture is where the next steps start from, unless so near a singular one that rounding decides on its branch.
Status GroupSolver::set_anchor(Pack& pack, double* const (&state)[3], std::int32_t b, const Attempt& attempt,
                               Counters& counters) {
  counters.branch_checks += pack.used;
  const std::size_t w = idx(lanes_);
  if (blocks_.needs_solver(b) && !factored_at_solution_) factored_at_solution_ = factorize(pack, counters).ok();
  evaluator_->scale(scale_.data());
  blocks_.measure(b, jacobian_.data(), {pack.lipschitz.data(), scale_.data()}, solver_,
                  {omega_.data(), posture_errors_.data()});
  if (attempt.branch == Attempt::Branch::inside) {
    for (std::int32_t l = 0; l < pack.used; ++l) {
      const double error = kConverged * posture_errors_[idx(l)];
      if (!(omega_[idx(l)] * error <= kRoundingRoom)) return fail(pack, Code::branch_unknown, error, l);
    }
  }
  pack.keep_anchor(attempt.number);
  std::copy(omega_.begin(), omega_.end(), pack.omega.begin() + b * lanes_);
  gather(pack, state[1], input_rates_);
  const std::size_t first = blocks_.reads_start(b) * w;
  double *anchor = pack.anchor.data() + first, *rates = pack.anchor_rates.data() + first;
  for (const std::int32_t c : blocks_.reads(b)) {
    const bool unknown = c < program_.n;
    const std::size_t at = unknown ? pack.unknowns + idx(c) * w : idx(c - program_.n) * w;
    std::copy_n(unknown ? state[0] + at : inputs_.data() + at, w, anchor);
    std::copy_n(unknown ? state[1] + at : input_rates_.data() + at, w, rates);
    anchor += w;
    rates += w;
  }
  // Without rates nothing is known of the way.
  const bool has_rates = class_.derivatives > 0 || attempt.all_rates;
  pack.anchor_time[idx(b)] = has_rates ? attempt.time : kNan;
  pack.ball_used[idx(b)] = 0;
  return {};
}

// The next steps of this length, too.
bool GroupSolver::stays_inside(double used, double& before) {
  const bool lasts = used + 2 * std::max(used - before, 0.0) <= kBall;
  if (lasts) before = used;
  return lasts;
}

Status GroupSolver::check_branch(Pack& pack, double* const (&state)[3], const Attempt& attempt, Counters& counters) {
  if (!class_.quadratic) return {};
  const double* x = state[0] + pack.unknowns;
  pack.keep_use(attempt.number);
  for (std::int32_t b = 0; b < program_.blocks; ++b) {
    double& before = pack.ball_used[idx(b)];
    if (attempt.branch == Attempt::Branch::inside) {
      const double used = ball_use(pack, x, b);
      if (!(used <= kBall)) {
        if (const Status s = check_tubes(pack, state, b, attempt); !s.ok()) return s;
      }
      if (stays_inside(used, before)) continue;
    }
    // At the start, after a change point, and before the next steps of this length leave the ball.
    if (const Status s = set_anchor(pack, state, b, attempt, counters); !s.ok()) return s;
  }
  return {};
}

GroupSolver::Singularity GroupSolver::diagnose(Pack& pack, double* const (&state)[3]) {
  const std::size_t w = idx(lanes_);
  gather(pack, state[0], inputs_);
  evaluator_->set_inputs(pack.coefficients.data(), inputs_.data());
  evaluator_->evaluate(state[0] + pack.unknowns, phi_.data(), jacobian_.data());
  gather(pack, state[1], input_rates_);
  evaluator_->velocity_rhs(input_rates_.data(), rhs_.data());
  // What the inputs and the group's other blocks ask of a block: rhs - J v over the unknowns of others.
  const double* rate = state[1] + pack.unknowns;
  for (std::int32_t c = 0; c < program_.n; ++c) {
    for (std::int32_t k = program_.pattern.column_start[idx(c)]; k < program_.pattern.column_start[idx(c) + 1]; ++k) {
      const std::int32_t row = program_.pattern.row[idx(k)];
      if (program_.equation_block[idx(row)] == program_.unknown_block[idx(c)]) continue;
      for (std::size_t l = 0; l < w; ++l) rhs_[idx(row) * w + l] -= jacobian_[idx(k) * w + l] * rate[idx(c) * w + l];
    }
  }
  const auto input_rate = [&](std::size_t lane) {
    double largest = 0;
    for (std::size_t i = lane; i < input_rates_.size(); i += w) largest = std::max(largest, std::abs(input_rates_[i]));
    return largest;
  };
  Singularity nearest;
  Status& worst = nearest.status = fail(pack, Code::branch_unknown, 1.0);
  std::vector<double> matrix;
  for (int lane = 0; lane < pack.used; ++lane) {
    for (std::int32_t b = 0; b < program_.blocks; ++b) {
      const auto n = static_cast<Eigen::Index>(blocks_.size(b));
      if (n > 400) continue;  // minutes for a dense SVD
      matrix.resize(static_cast<std::size_t>(n * n));
      blocks_.extract(jacobian_.data(), b, lane, matrix);
      const Eigen::BDCSVD<Eigen::MatrixXd> svd(Eigen::Map<const Eigen::MatrixXd>(matrix.data(), n, n),
                                               Eigen::ComputeFullU);
      const double ratio = svd.singularValues()[n - 1] / svd.singularValues()[0];
      if (!(ratio < worst.figure)) continue;
      worst = fail(pack, Code::branch_unknown, ratio, lane);
      nearest.block = b;
      nearest.lane = lane;
      nearest.smallest = svd.singularValues()[n - 1];
      if (ratio > 0.05) continue;
      // Towards a fold the velocity along the null vector grows like 1/sigma; at a change point it stays bounded.
      Eigen::VectorXd g(n);
      for (Eigen::Index i = 0; i < n; ++i)
        g[i] = rhs_[idx(blocks_.equations(b)[static_cast<std::size_t>(i)]) * w + idx(lane)];
      const double velocity = std::abs(svd.matrixU().col(n - 1).dot(g)) / svd.singularValues()[n - 1];
      worst.code = velocity > kFold * input_rate(idx(lane)) ? Code::limit_reached : Code::change_point_passed;
    }
  }
  if (nearest.block < 0) return nearest;
  for (const std::int32_t c : blocks_.reads(nearest.block)) {
    const bool unknown = c < program_.n;
    if (unknown && program_.unknown_block[idx(c)] == nearest.block) continue;
    const std::size_t at = idx(unknown ? c : c - program_.n) * w + idx(nearest.lane);
    nearest.reads.push_back(unknown ? state[0][pack.unknowns + at] : inputs_[at]);
  }
  return nearest;
}

}  // namespace assur
