#include "groups/branch_guard.hpp"

#include <algorithm>
#include <cmath>

#include "backends/small_steps.hpp"
#include "numbers.hpp"
#include "program/step_rules.hpp"

namespace assur {

BranchGuard::BranchGuard(Workspace& work, JacobianSolver& solver)
    : work_(work), solver_(solver), blocks_(work.group_class, work.lanes, has_small_steps(solver.settings())) {
  there_.resize(idx(work_.group_class.n) * BoxTest::kPostures);
  there_inputs_.resize(idx(work_.group_class.inputs) * BoxTest::kPostures);
  for (LaneArray* v : {&omega_, &used_}) v->resize(idx(work_.lanes));
  changes_.resize(idx(work_.lanes));
  posture_errors_.resize(idx(work_.lanes));
}

// Fills used_.
void BranchGuard::use_ball(const Pack& pack, const double* x, std::int32_t b) {
  const auto reads = blocks_.reads(b);
  work_.kernels.ball_use(reads.data(), static_cast<std::int32_t>(reads.size()), work_.group_class.n, x,
                         work_.inputs.data(), pack.anchor.data() + blocks_.reads_start(b) * idx(work_.lanes),
                         pack.omega.data() + b * work_.lanes, used_.data());
}

// Tests the lanes that left the ball coordinate by coordinate. Returns the failure of the lane that is farthest out.
Status BranchGuard::check_tubes(const Pack& pack, double* const (&state)[3], std::int32_t b, const Attempt& attempt) {
  Status worst;
  for (std::int32_t l = 0; l < pack.used; ++l) {
    const double used = used_[idx(l)], seconds = attempt.time - pack.anchor_time[idx(b * work_.lanes + l)];
    if (used <= std::max(kBall, worst.figure) || tube_leads_here(pack, state, b, l, seconds)) continue;
    worst = pack.failed(Code::branch_unknown, used, l);
  }
  return worst;
}

// Examines the tube along the cubic from the anchor, `seconds` ago, to the new posture, with the rates of both.
bool BranchGuard::tube_leads_here(const Pack& pack, double* const (&state)[3], std::int32_t b, int lane,
                                  double seconds) {
  static_assert(kAlongTheTube.size() == BoxTest::kPostures);
  if (!std::isfinite(seconds)) return false;
  const double *x = state[0] + pack.unknowns, *rate = state[1] + pack.unknowns;
  work_.gather(pack, state[1], work_.input_rates);
  const std::size_t w = idx(work_.lanes), first = blocks_.reads_start(b) * w + idx(lane), n = idx(work_.group_class.n);
  const auto row = [&](std::size_t c) {
    return (c < n ? there_ : there_inputs_).data() + (c < n ? c : c - n) * BoxTest::kPostures;
  };
  const auto at = [&](std::size_t c, const double* unknowns, const LaneArray& inputs) {
    return c < n ? unknowns[c * w + idx(lane)] : inputs[(c - n) * w + idx(lane)];
  };
  for (std::size_t c = 0; c < n + idx(work_.group_class.inputs); ++c) {
    std::fill_n(row(c), BoxTest::kPostures, at(c, x, work_.inputs));
  }
  const auto reads = blocks_.reads(b);
  for (std::size_t i = 0; i < reads.size(); ++i) {
    const std::size_t c = idx(reads[i]);
    const double q0 = pack.anchor[first + i * w], v0 = pack.anchor_rates[first + i * w];
    const double q1 = at(c, x, work_.inputs), v1 = at(c, rate, work_.input_rates);
    for (std::size_t p = 0; p < BoxTest::kPostures; ++p) {
      const double t = kAlongTheTube[p], s = 1 - t, end = t * t * (3 - 2 * t), begin = 1 - end;
      row(c)[p] = begin * q0 + end * q1 + seconds * t * s * (s * v0 - t * v1);
    }
  }
  return blocks_.hold_one_solution(b, {work_.lanes, lane, pack.coefficients.data(), work_.jacobian.data()},
                                   there_.data(), there_inputs_.data());
}

// Makes the posture the anchor of the next steps in the lanes of changes_. Fails if it is so close to a singular
// posture that rounding decides about the branch.
Status BranchGuard::set_anchor(Pack& pack, double* const (&state)[3], std::int32_t b, const Attempt& attempt,
                               Counters& counters) {
  counters.branch_checks += std::count(changes_.begin(), changes_.begin() + pack.used, 1);
  const std::size_t w = idx(work_.lanes);
  using Factors = JacobianSolver::Factors;
  if (solver_.factors() != Factors::solution && blocks_.needs_solver(b, work_.jacobian.data(), changes_)) {
    (void)solver_.factorize(pack, Factors::solution, counters);
  }
  work_.evaluator->scale(work_.scale.data());
  blocks_.measure(b, work_.jacobian.data(), {pack.lipschitz.data(), work_.scale.data()}, solver_.at_hand(),
                  {omega_.data(), posture_errors_.data()}, changes_);
  if (attempt.branch == Attempt::Branch::inside) {
    for (std::int32_t l = 0; l < pack.used; ++l) {
      if (changes_[idx(l)] == 0) continue;
      const double error = kConverged * posture_errors_[idx(l)];
      if (!(omega_[idx(l)] * error <= kRoundingRoom)) return pack.failed(Code::branch_unknown, error, l);
    }
  }
  pack.keep_anchor(attempt.number);
  work_.gather(pack, state[1], work_.input_rates);
  // Without rates the cubic, and so the tube, is unknown.
  const double time = work_.group_class.derivatives > 0 || attempt.all_rates ? attempt.time : kNan;
  for (std::size_t l = 0; l < w; ++l) {
    if (changes_[l] != 0) move_anchor(pack, state, b, l, time);
  }
  return {};
}

// Makes the posture the anchor of one lane.
void BranchGuard::move_anchor(Pack& pack, const double* const (&state)[3], std::int32_t b, std::size_t lane,
                              double time) {
  const std::size_t w = idx(work_.lanes), at_block = idx(b) * w + lane;
  pack.omega[at_block] = omega_[lane];
  pack.anchor_time[at_block] = time;
  pack.ball_used[at_block] = 0;
  const std::size_t first = blocks_.reads_start(b) * w;
  double *anchor = pack.anchor.data() + first + lane, *rates = pack.anchor_rates.data() + first + lane;
  for (const std::int32_t c : blocks_.reads(b)) {
    const bool unknown = c < work_.group_class.n;
    const std::size_t at = (unknown ? pack.unknowns + idx(c) * w : idx(c - work_.group_class.n) * w) + lane;
    *anchor = unknown ? state[0][at] : work_.inputs[at];
    *rates = unknown ? state[1][at] : work_.input_rates[at];
    anchor += w;
    rates += w;
  }
}

bool BranchGuard::is_near(const Pack& pack, std::int32_t b, int lane) const {
  const std::size_t at = idx(b * work_.lanes + lane);
  const double largest = work_.correction[at];
  return largest == 0 || pack.omega[at] * largest <= largest_first_correction(pack.ball_used[at]);
}

bool BranchGuard::is_near(const Pack& pack) const {
  for (std::int32_t b = 0; b < work_.group_class.blocks; ++b) {
    for (int l = 0; l < pack.used; ++l) {
      if (!is_near(pack, b, l)) return false;
    }
  }
  return true;
}

// If omega |first correction| <= 1/4 of the rest of the ball, the iteration converges to the one solution nearby. If
// not, a box around the prediction, whose equations the workspace holds, must contain exactly one solution.
Status BranchGuard::check_first_correction(const Pack& pack) {
  for (std::int32_t b = 0; b < work_.group_class.blocks; ++b) {
    for (int l = 0; l < pack.used; ++l) {
      if (is_near(pack, b, l)) continue;
      work_.evaluator->scale(work_.scale.data());
      const bool one = blocks_.holds_one_solution(b, {work_.lanes, l, pack.coefficients.data(), work_.jacobian.data()},
                                                  work_.phi.data(), work_.scale.data());
      const std::size_t at = idx(b * work_.lanes + l);
      if (!one) {
        return pack.failed(Code::branch_unknown, pack.omega[at] * work_.correction[at] / (1 - pack.ball_used[at]), l);
      }
    }
  }
  return {};
}

bool BranchGuard::stays_inside(double used, double& before) {
  const bool lasts = ball_lasts(used, before);
  if (lasts) before = used;
  return lasts;
}

Status BranchGuard::check(Pack& pack, double* const (&state)[3], const Attempt& attempt, Counters& counters) {
  if (!work_.group_class.quadratic()) return {};
  blocks_.forget_inverse();
  const double* x = state[0] + pack.unknowns;
  pack.keep_use(attempt.number);
  for (std::int32_t b = 0; b < work_.group_class.blocks; ++b) {
    // At the start, after a change point, and before the next step of this length would leave the ball.
    std::fill(changes_.begin(), changes_.end(), std::uint8_t{1});
    if (attempt.branch == Attempt::Branch::inside) {
      use_ball(pack, x, b);
      if (const Status s = check_tubes(pack, state, b, attempt); !s.ok()) return s;
      for (std::size_t l = 0; l < used_.size(); ++l) {
        changes_[l] = stays_inside(used_[l], pack.ball_used[idx(b * work_.lanes) + l]) ? 0 : 1;
      }
      if (std::find(changes_.begin(), changes_.end(), 1) == changes_.end()) continue;
    }
    if (const Status s = set_anchor(pack, state, b, attempt, counters); !s.ok()) return s;
  }
  return {};
}

}  // namespace assur
