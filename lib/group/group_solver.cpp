#include "group/group_solver.hpp"

#include <algorithm>

#include "backends/small_steps.hpp"
#include "index.hpp"
#include "numbers.hpp"
#include "scene/residual_scale.hpp"

namespace assur {

GroupSolver::GroupSolver(const System& system, const Structure& structure, std::int32_t group_class,
                         const Plan::Choice& choice, std::span<const Backend> table, StepCode* code)
    : work_(system, structure.classes[idx(group_class)], structure.pattern(group_class), choice.solver.lanes),
      solver_(work_, choice, table),
      guard_(work_, solver_),
      step_(work_, solver_, guard_, choice.solver),
      probe_(system, work_, solver_, guard_.blocks()) {
  if (has_small_steps(choice.solver)) small_step_ = make_small_step(work_, guard_.blocks(), code);
}

void GroupSolver::size(Pack& pack) const {
  const std::size_t w = idx(work_.lanes);
  pack.coefficients.assign((idx(one_coefficient(work_.program)) + 1) * w, 0.0);
  std::fill_n(pack.coefficients.data() + idx(one_coefficient(work_.program)) * w, w, 1.0);
  pack.lipschitz.resize(idx(work_.program.n) * w);
  pack.anchor.resize(guard_.blocks().reads_start(work_.program.blocks) * w);
  pack.omega.assign(idx(work_.program.blocks) * w, 0.0);
  pack.own_use.assign(idx(work_.program.blocks), 0.0);
  pack.ball_used = pack.own_use;
  pack.anchor_rates.resize(pack.anchor.size());
  pack.anchor_time.assign(idx(work_.program.blocks), kNan);
  pack.kept = {0, 0, 0, pack.own_use, pack.anchor, pack.anchor_rates, pack.anchor_time, pack.omega, {}};
}

void GroupSolver::bind_lane(const System& system, const Group& group, Pack& pack, int lane) const {
  std::vector<double> constants;
  constants.reserve(group.constants.size());
  for (const std::int32_t k : group.constants) constants.push_back(system.constants[idx(k)]);
  bind_coefficients(work_.program, constants, pack.coefficients.data() + lane, idx(work_.lanes));
  lipschitz(work_.group_class, constants, pack.lipschitz.data() + lane, idx(work_.lanes));
}

Status GroupSolver::solve(Pack& pack, double* const (&state)[3], const Attempt& attempt, Counters& counters,
                          StepErrors& errors) {
  if (attempt.branch == Attempt::Branch::limit) return take(*attempt.limit, pack, state, counters, errors);
  if (Status s; small_step_ && small_step(pack, state, attempt, counters, errors, s)) return s;
  solver_.choose(pack);
  pack.kept.factors_of = attempt.number;
  work_.set_inputs(pack, state[0]);
  if (const Status s = step_.position(pack, state[0] + pack.unknowns, attempt, counters, errors); !s.ok()) return s;
  if (attempt.branch == Attempt::Branch::anywhere) return {};
  if (const Status s = step_.derivatives(pack, state, attempt, counters, errors); !s.ok()) return s;
  if (small_step_) {
    pack.keep_anchor(attempt.number);
    choose_pivots(work_, pack);
  }
  return guard_.check(pack, state, attempt, counters);
}

Status GroupSolver::take(const PackLimit& limit, const Pack& pack, double* const (&state)[3], Counters& counters,
                         StepErrors& errors) {
  const std::size_t size = work_.size();
  for (std::size_t d = 0; d < 3; ++d) std::copy_n(limit.values.data() + d * size, size, state[d] + pack.unknowns);
  counters.group_solutions += pack.used;
  const double left = step_.residual_of(pack, state[0]);
  if (!(left <= kConsistent)) return pack.failed(Code::not_converged, left, 0);
  errors.position = std::max(errors.position, left);
  return {};
}

bool GroupSolver::small_step(Pack& pack, double* const (&state)[3], const Attempt& attempt, Counters& counters,
                             StepErrors& errors, Status& status) {
  if (attempt.branch != Attempt::Branch::inside || attempt.iterations > 0) return false;
  if (attempt.all_rates && work_.group_class.derivatives == 0) return false;
  SmallStepFigures figures{0, errors.position, errors.velocity, errors.acceleration, 0};
  if (!small_step_->run(pack, state, attempt.most_iterations, attempt.converged, figures)) return false;
  const int factorizations = figures.iterations + (work_.group_class.derivatives > 0 ? 1 : 0);
  const std::int64_t unknowns = std::int64_t{pack.used} * work_.program.n;
  counters.group_solutions += pack.used;
  counters.newton_iterations += std::int64_t{pack.used} * figures.iterations;
  counters.most_iterations = std::max<std::int64_t>(counters.most_iterations, figures.iterations);
  counters.evaluated_equations += unknowns * (figures.iterations + 1);
  counters.factorizations += std::int64_t{pack.used} * factorizations;
  counters.factorized_unknowns += unknowns * factorizations;
  counters.solved_unknowns += unknowns * (figures.iterations + work_.group_class.derivatives);
  if (figures.position > std::max(errors.position, kConverged)) {
    figures.position = std::max(errors.position, step_.residual_of(pack, state[0]));
  }
  errors = {figures.position, figures.velocity, figures.acceleration};
  pack.keep_use(attempt.number);
  if (BranchGuard::stays_inside(figures.ball_used, pack.ball_used[0])) return true;
  status = renew_anchor(pack, state, attempt, counters);
  return true;
}

Status GroupSolver::renew_anchor(Pack& pack, double* const (&state)[3], const Attempt& attempt, Counters& counters) {
  pack.keep_anchor(attempt.number);
  work_.set_inputs(pack, state[0]);
  work_.evaluate(state[0] + pack.unknowns);
  choose_pivots(work_, pack);
  return guard_.check(pack, state, attempt, counters);
}

}  // namespace assur
