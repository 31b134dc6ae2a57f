#include "path/whole_step.hpp"

#include <algorithm>
#include <utility>

#include "group/pack_memory.hpp"
#include "index.hpp"
#include "program/group_step.hpp"
#include "program/step_rules.hpp"

namespace assur {
namespace {

std::size_t inputs_of(const Pack& pack) { return pack.inputs.size(); }

}  // namespace

std::unique_ptr<WholeStep> WholeStep::make(Layout& layout, DriveProgram& drivers, const State& state, StepCode& code) {
  static_assert(kMostWeights == kMostPast);
  if (layout.packs.empty()) return nullptr;
  const auto solver = [&](const Pack& pack) -> const GroupSolver& { return *layout.solvers[idx(pack.group_class)]; };
  MechanismOutline outline{solver(layout.packs[0]).lanes(), drivers.outline(), state.weights(), {}};
  for (const Pack& pack : layout.packs) {
    const GroupSolver& s = solver(pack);
    if (!s.has_small_step() || s.lanes() != outline.lanes) return nullptr;
    outline.groups.push_back({s.group_class(), s.program(), s.blocks().reads(0), pack.inputs, pack.used,
                              static_cast<std::uint32_t>(pack.unknowns - layout.first_unknown)});
  }
  MechanismStep step = mechanism_step(outline, kMostInstructions);
  if (step.program.phases.empty()) return nullptr;
  std::unique_ptr<WholeStep> out(new WholeStep(layout, drivers, outline.lanes));
  out->code_ = code.of(step.program, outline.lanes);
  if (!out->code_) return nullptr;
  out->factors_.assign(step.factors.begin(), step.factors.end());
  out->weights_ = outline.weights;
  out->reserve(step.work);
  return out;
}

void WholeStep::reserve(std::size_t work) {
  const std::vector<Pack>& packs = layout_.packs;
  std::size_t inputs = 0;
  for (const Pack& pack : packs) inputs += inputs_of(pack);
  work_.assign(work * lanes_, 0.0);
  inputs_.assign(3 * inputs, 0.0);
  figures_.assign((packs.size() * kGroupFigures + kMechanismFigures) * lanes_, 0.0);
  memory_.assign((packs.size() + 1) * kMemories, nullptr);
  at(Memory::laws) = drivers_.jets(0);
  at(Memory::law_rates) = drivers_.jets(1);
  at(Memory::law_accelerations) = drivers_.jets(2);
  at(Memory::sines) = drivers_.sines();
  at(Memory::cosines) = drivers_.cosines();
  at(Memory::factors) = factors_.data();
  double* next = inputs_.data();
  for (std::size_t p = 0; p < packs.size(); ++p) {
    for (const Memory m : {Memory::inputs, Memory::input_rates, Memory::input_accelerations}) {
      at(m, p) = std::exchange(next, next + inputs_of(packs[p]));
    }
    at(Memory::settings, p) = settings_.data();
    at(Memory::work, p) = work_.data();
    at(Memory::figures, p) = figures_.data() + p * kGroupFigures * lanes_;
  }
  at(Memory::figures, packs.size()) = figures_.data();
}

void WholeStep::take_rest(const double* state) {
  for (std::size_t p = 0; p < layout_.packs.size(); ++p) {
    const Pack& pack = layout_.packs[p];
    for (std::size_t i = 0; i < inputs_of(pack); ++i) at(Memory::inputs, p)[i] = state[idx(pack.inputs[i])];
  }
  knows_rest_ = true;
}

bool WholeStep::run(double* const (&state)[3], const State::Prediction& prediction, const Attempt& attempt) {
  if (!knows_rest_) take_rest(state[0]);
  settings_[slot_of(GroupSetting::converged_at).index] = attempt.converged;
  settings_[slot_of(GroupSetting::most_iterations).index] = attempt.most_iterations;
  double** to = memory_.data();
  const auto put = [&](Memory m, const double* from) { to[static_cast<std::size_t>(m)] = const_cast<double*>(from); };
  put(Memory::state, state[0]);
  put(Memory::state_rates, state[1]);
  put(Memory::state_accelerations, state[2]);
  put(Memory::weights, prediction.weights);
  for (std::size_t k = 0; k < weights_; ++k) {
    to[static_cast<std::size_t>(Memory::past) + k] = const_cast<double*>(prediction.sources[k]);
  }
  for (const Pack& pack : layout_.packs) {
    point_to(pack, state, to);
    to += kMemories;
  }
  drivers_.find_sines();
  code_->run(memory_);
  const double* const failed = row(layout_.packs.size(), MechanismFigure::failed);
  return std::all_of(failed, failed + lanes_, [](double f) { return f <= 0; });
}

Status WholeStep::finish(double* const (&state)[3], const Attempt& attempt, Counters& counters, StepErrors& errors,
                         std::size_t& failed) {
  std::vector<Pack>& packs = layout_.packs;
  failed = packs.size();
  const auto solver = [&](const Pack& pack) -> GroupSolver& { return *layout_.solvers[idx(pack.group_class)]; };
  if (const Figures all = figures(packs.size()); all.position <= kConverged && all.needs_anchor <= 0) {
    for (std::size_t p = 0; p < packs.size(); ++p) {
      solver(packs[p]).count_small_step(packs[p], row(p, GroupFigure::iterations), counters);
      packs[p].keep_use(attempt.number);
      std::copy_n(row(p, GroupFigure::ball_used), lanes_, packs[p].ball_used.begin());
    }
    errors.position = std::max(errors.position, all.position);
    errors.velocity = std::max(errors.velocity, all.velocity);
    errors.acceleration = std::max(errors.acceleration, all.acceleration);
    return {};
  }
  Status status;
  for (std::size_t p = 0; p < packs.size(); ++p) {
    if (!status.ok() && packs[failed].level != packs[p].level) break;
    const Figures of_pack = figures(p);
    SmallStepFigures f;
    f.position = std::max(errors.position, of_pack.position);
    f.velocity = std::max(errors.velocity, of_pack.velocity);
    f.acceleration = std::max(errors.acceleration, of_pack.acceleration);
    f.iterations = row(p, GroupFigure::iterations);
    f.ball_used = row(p, GroupFigure::ball_used);
    f.balls_last = of_pack.needs_anchor <= 0;
    const Status s = solver(packs[p]).finish_small_step(packs[p], state, attempt, f, counters, errors);
    if (s.ok() || !status.ok()) continue;
    status = s;
    failed = p;
  }
  return status;
}

// Of a group, or, behind the last one, of the mechanism.
WholeStep::Figures WholeStep::figures(std::size_t group) {
  static_assert(kMechanismFigures <= kGroupFigures);
  const bool all = group == layout_.packs.size();
  double of_lanes[kGroupFigures];
  const double* largest = row(group, GroupFigure{0});
  if (lanes_ > 1) {
    kernels_.row_maxima(largest, static_cast<std::int32_t>(all ? kMechanismFigures : kGroupFigures), of_lanes);
    largest = of_lanes;
  }
  const auto of = [&](MechanismFigure m, GroupFigure g) {
    return largest[all ? static_cast<std::size_t>(m) : static_cast<std::size_t>(g)];
  };
  return {of(MechanismFigure::position, GroupFigure::position), of(MechanismFigure::velocity, GroupFigure::velocity),
          of(MechanismFigure::acceleration, GroupFigure::acceleration),
          of(MechanismFigure::needs_anchor, GroupFigure::needs_anchor)};
}

}  // namespace assur
