#include "motion/whole_step.hpp"

#include <algorithm>
#include <utility>

#include "groups/pack_memory.hpp"
#include "index.hpp"
#include "program/group_step.hpp"
#include "program/mechanism_step.hpp"

namespace assur {

std::unique_ptr<WholeStep> WholeStep::make(Layout& layout, DriveProgram* drivers, const State& state, StepCode& code,
                                           std::size_t first, int lanes) {
  constexpr std::size_t kLeast = 100;  // instructions of a group
  std::unique_ptr<WholeStep> out(new WholeStep(layout, drivers, first));
  if (out->packs_.empty() || kLeast * out->packs_.size() > kMostInstructions) return nullptr;
  MechanismOutline outline{drivers != nullptr ? drivers->outline(lanes) : DrivenOutline{}, state.weights(), {}, lanes};
  for (const Pack& pack : out->packs_) {
    const GroupSolver& s = out->solver(pack);
    if (!s.has_small_step()) return nullptr;
    outline.groups.push_back({s.lanes(), s.group_class(), s.blocks().reads(0), pack.inputs,
                              static_cast<std::uint32_t>(pack.unknowns - layout.first_unknown)});
  }
  MechanismStep step = mechanism_step(outline, kMostInstructions);
  if (step.program.phases.empty()) return nullptr;
  out->code_ = code.of(step.program, 1);
  if (!out->code_) return nullptr;
  for (const Pack& pack : out->packs_) {
    const GroupSolver& s = out->solver(pack);
    Anchors& anchors = out->anchors_.emplace_back();
    anchors.of = out.get();
    anchors.number = out->anchors_.size() - 1;
    anchors.code = code.of(anchor_program(s.group_class(), s.blocks().reads(0)), s.lanes());
    if (!anchors.code) return nullptr;
  }
  out->lanes_ = lanes;
  out->weights_ = outline.weights;
  out->reserve(step.work);
  return out;
}

void WholeStep::reserve(std::size_t work) {
  const std::span<Pack> packs = packs_;
  const auto lanes = [&](const Pack& pack) { return idx(solver(pack).lanes()); };
  std::size_t inputs = 0, all_lanes = 0, most_lanes = 0;
  for (const Pack& pack : packs) {
    inputs += pack.inputs.size();
    all_lanes += lanes(pack);
    most_lanes = std::max(most_lanes, lanes(pack));
  }
  work_.assign(work * most_lanes, 0.0);
  inputs_.assign(3 * inputs, 0.0);
  of_lanes_.assign(all_lanes * kGroupFigures, 0.0);
  figures_.resize(packs.size());
  memory_.assign(packs.size() * kMemories, nullptr);
  take_drivers();
  at(kUndefined.memory) = &undefined_;
  double *next = inputs_.data(), *figures = of_lanes_.data();
  for (std::size_t p = 0; p < packs.size(); ++p) {
    for (const Memory m : {Memory::inputs, Memory::input_rates, Memory::input_accelerations}) {
      at(m, p) = std::exchange(next, next + packs[p].inputs.size());
    }
    figures_[p].of_lanes = std::exchange(figures, figures + kGroupFigures * lanes(packs[p]));
    const int w = solver(packs[p]).lanes();
    figures_[p].kernels = w == 1 ? nullptr : &pack_kernels(w);
    at(Memory::settings, p) = settings_.data();
    at(Memory::work, p) = work_.data();
    at(Memory::figures, p) = figures_[p].of_lanes;
    point_to(packs[p], &at(Memory{}, p));
  }
}

void WholeStep::take_drivers() {
  if (drivers_ == nullptr) return;
  at(Memory::laws) = drivers_->jets(0);
  at(Memory::law_rates) = drivers_->jets(1);
  at(Memory::law_accelerations) = drivers_->jets(2);
  at(Memory::sines) = drivers_->sines();
  at(Memory::cosines) = drivers_->cosines();
  factors_.clear();
  for (const DrivenOutline::Sum& sum : drivers_->outline(lanes_).sums) {
    for (const DrivenOutline::Term& term : sum.terms) factors_.push_back(term.factor);
  }
  at(Memory::factors) = factors_.data();
}

void WholeStep::take_rest(const double* state) {
  for (std::size_t p = 0; p < packs_.size(); ++p) {
    const Pack& pack = packs_[p];
    for (std::size_t i = 0; i < pack.inputs.size(); ++i) at(Memory::inputs, p)[i] = state[idx(pack.inputs[i])];
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
  for (const Pack& pack : packs_) {
    point_to_unknowns(pack, state, to);
    to += kMemories;
  }
  if (drivers_ != nullptr) drivers_->find_sines();
  code_->run(memory_);
  return find_figures();
}

const double* WholeStep::Anchors::renew_anchors(Pack& pack, double* const (&)[3], double time) {
  of->settings_[slot_of(GroupSetting::time).index] = time;
  code->run({&of->at(Memory{}, number), kMemories});
  return of->figures_[number].of_lanes + static_cast<std::size_t>(GroupFigure::failed) * idx(of->solver(pack).lanes());
}

// False if a lane fails.
bool WholeStep::find_figures() {
  double failed = undefined_;
  for (Figures& f : figures_) {
    if (f.kernels == nullptr) {
      std::copy_n(f.of_lanes, kGroupFigures, f.largest);
    } else {
      f.kernels->row_maxima(f.of_lanes, kGroupFigures, f.largest);
    }
    failed += f[GroupFigure::failed];
  }
  return failed <= 0;
}

Status WholeStep::finish(double* const (&state)[3], const Attempt& attempt, Counters& counters, StepErrors& errors,
                         std::size_t& failed) {
  const std::span<Pack> packs = packs_;
  failed = layout_.packs.size();
  Status status;
  for (std::size_t p = 0; p < packs.size(); ++p) {
    if (!status.ok() && packs[failed - first_].level != packs[p].level) break;
    const Figures& f = figures_[p];
    const auto row = [&](GroupFigure figure) {
      return f.of_lanes + static_cast<std::size_t>(figure) * idx(solver(packs[p]).lanes());
    };
    SmallStepFigures of_pack;
    of_pack.position = std::max(errors.position, f[GroupFigure::position]);
    of_pack.velocity = std::max(errors.velocity, f[GroupFigure::velocity]);
    of_pack.acceleration = std::max(errors.acceleration, f[GroupFigure::acceleration]);
    of_pack.iterations = row(GroupFigure::iterations);
    of_pack.ball_used = row(GroupFigure::ball_used);
    of_pack.needs_anchor = row(GroupFigure::needs_anchor);
    of_pack.balls_last = f[GroupFigure::needs_anchor] <= 0;
    const Status s =
        solver(packs[p]).finish_small_step(packs[p], state, attempt, of_pack, anchors_[p], counters, errors);
    if (s.ok() || !status.ok()) continue;
    status = s;
    failed = first_ + p;
  }
  return status;
}

}  // namespace assur
