// The ordinary step of a group as a program (program/group_step.hpp, program/class_step.hpp) that an executor runs.
#include <algorithm>
#include <array>
#include <memory>
#include <utility>

#include "groups/pack_memory.hpp"
#include "groups/small_step.hpp"
#include "index.hpp"
#include "program/class_step.hpp"
#include "program/group_step.hpp"
#include "program/step_rules.hpp"

namespace assur {
namespace {

class CodedStep final : public SmallStep {
 public:
  CodedStep(const Workspace& work, CodeOfStep code, std::shared_ptr<const Executor> anchors);

  [[nodiscard]] bool run(const Pack& pack, double* const (&state)[3], int most_iterations, double converged,
                         SmallStepFigures& figures) override;
  [[nodiscard]] const double* renew_anchors(Pack& pack, double* const (&state)[3], double time) override;

 private:
  [[nodiscard]] const double* row(GroupFigure f) const {
    return figures_.data() + static_cast<std::size_t>(f) * idx(work_.lanes);
  }
  [[nodiscard]] double*& at(Memory m) { return memory_[static_cast<std::size_t>(m)]; }

  const Workspace& work_;
  std::shared_ptr<const Executor> code_, anchors_;  // null: of a class step
  std::array<LaneArray, 3> inputs_;                 // [d]: d-th derivatives of the inputs, inputs x W
  std::array<double, kGroupSettings> settings_{};
  LaneArray values_, figures_;  // memory of the code, rows x W
  std::array<double*, kMemories> memory_{};
};

CodedStep::CodedStep(const Workspace& work, CodeOfStep code, std::shared_ptr<const Executor> anchors)
    : work_(work), code_(std::move(code.executor)), anchors_(std::move(anchors)) {
  const std::size_t w = idx(work.lanes);
  for (LaneArray& of : inputs_) of.assign(idx(work.group_class.inputs) * w, 0.0);
  values_.assign(code.work * w, 0.0);
  figures_.assign(kGroupFigures * w, 0.0);
  at(Memory::inputs) = inputs_[0].data();
  at(Memory::input_rates) = inputs_[1].data();
  at(Memory::input_accelerations) = inputs_[2].data();
  at(Memory::settings) = settings_.data();
  at(Memory::work) = values_.data();
  at(Memory::figures) = figures_.data();
}

bool CodedStep::run(const Pack& pack, double* const (&state)[3], int most_iterations, double converged,
                    SmallStepFigures& figures) {
  const int derivatives = work_.group_class.derivatives;
  if (work_.lanes == 1) {
    for (std::size_t i = 0; i < pack.inputs.size(); ++i) {
      const std::size_t from = idx(pack.inputs[i]);
      for (std::size_t d = 0; d <= idx(derivatives); ++d) inputs_[d][i] = state[d][from];
    }
  } else {
    work_.kernels.gather_all(pack.input_rows.data(), pack.inputs.data(), work_.group_class.inputs, state,
                             &at(Memory::inputs), derivatives + 1);
  }
  settings_[slot_of(GroupSetting::converged_at).index] = converged;
  settings_[slot_of(GroupSetting::most_iterations).index] = most_iterations;
  point_to(pack, memory_.data());
  point_to_unknowns(pack, state, memory_.data());
  (code_ ? code_ : pack.machine_code.step)->run(memory_);
  double of_all[kGroupFigures];
  const double* largest = figures_.data();
  if (work_.lanes > 1) {
    work_.kernels.row_maxima(figures_.data(), kGroupFigures, of_all);
    largest = of_all;
  }
  const auto figure = [&](GroupFigure f) { return largest[static_cast<std::size_t>(f)]; };
  figures.failed = row(GroupFigure::failed);
  if (figure(GroupFigure::failed) > 0) return false;
  if (!code_) {
    figures.weights = values_.data();
    figures.first_correction = values_.data() + values_.size() - idx(work_.lanes);
  }
  figures.iterations = row(GroupFigure::iterations);
  figures.position = std::max(figures.position, figure(GroupFigure::position));
  if (derivatives > 0) figures.velocity = std::max(figures.velocity, figure(GroupFigure::velocity));
  if (derivatives > 1) figures.acceleration = std::max(figures.acceleration, figure(GroupFigure::acceleration));
  figures.ball_used = row(GroupFigure::ball_used);
  figures.needs_anchor = row(GroupFigure::needs_anchor);
  figures.balls_last = figure(GroupFigure::needs_anchor) <= 0;
  return true;
}

const double* CodedStep::renew_anchors(Pack& pack, double* const (&)[3], double time) {
  const Executor* const anchors = code_ ? anchors_.get() : pack.machine_code.anchor.get();
  const double *const needs = row(GroupFigure::needs_anchor), *const used = row(GroupFigure::ball_used);
  bool any_inside = false;
  for (int l = 0; l < work_.lanes; ++l) any_inside = any_inside || (needs[l] > 0 && used[l] <= kBall);
  if (anchors == nullptr || !any_inside) return needs;
  settings_[slot_of(GroupSetting::time).index] = time;
  anchors->run(memory_);
  return row(GroupFigure::failed);
}

}  // namespace

std::unique_ptr<SmallStep> make_interpreted_step(const Workspace& work, const BlockConditions& blocks) {
  const auto reads = blocks.reads(0);
  const GroupProgram step = group_step(work.group_class, reads);
  return std::make_unique<CodedStep>(work, CodeOfStep{make_interpreter(step.program, work.lanes), step.work},
                                     make_interpreter(anchor_program(work.group_class, reads), work.lanes));
}

std::unique_ptr<SmallStep> make_coded_step(const Workspace& work, const BlockConditions& blocks, StepCode& code) {
  CodeOfStep of_step = code.of(work.group_class, blocks.reads(0), work.lanes);
  auto anchors = code.of(anchor_program(work.group_class, blocks.reads(0)), work.lanes);
  if (!of_step.executor || !anchors) return nullptr;
  return std::make_unique<CodedStep>(work, std::move(of_step), std::move(anchors));
}

std::unique_ptr<SmallStep> make_class_step(const Workspace& work) {
  return std::make_unique<CodedStep>(work, CodeOfStep{nullptr, work_of_class_step(work.group_class)}, nullptr);
}

}  // namespace assur
