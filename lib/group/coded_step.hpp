// The ordinary step of a small group as machine code (execute/step_code.hpp).
#pragma once

#include <array>
#include <memory>
#include <utility>

#include "execute/step_code.hpp"
#include "group/branch.hpp"
#include "group/small_step.hpp"
#include "group/workspace.hpp"
#include "program/group_step.hpp"

namespace assur {

class CodedStep final : public SmallStep {
 public:
  // code: of group_step() for the class of the workspace, which must outlive this object.
  CodedStep(const Workspace& work, std::shared_ptr<const Executor> code);

  void choose_pivots(Pack& pack, const double* state) override;
  [[nodiscard]] bool run(const Pack& pack, double* const (&state)[3], int most_iterations, double converged,
                         SmallStepFigures& figures) override;

 private:
  void set(GroupSetting setting, double value);
  [[nodiscard]] double*& at(Memory m) { return memory_[static_cast<std::size_t>(m)]; }

  const Workspace& work_;
  std::shared_ptr<const Executor> code_;
  std::array<LaneArray, 3> inputs_;  // [d]: d-th derivatives of the inputs, inputs x W
  std::array<double, kGroupSettings> set_{};
  LaneArray settings_, values_, figures_;  // memory of the code, rows x W
  std::array<double*, kMemories> memory_{};
  std::size_t unknowns_ = 0;    // of all lanes
  std::vector<double> matrix_;  // of one lane
};

// The fastest SmallStep for a class; null if it has none. The kernels for distances are faster than their machine code:
// four_bar:10 takes 0.94 times as long with them, stewart 1.3 times as long with those for other equations. code: null,
// or machine code.
[[nodiscard]] std::unique_ptr<SmallStep> fastest_small_step(const Workspace& work, const BlockConditions& blocks,
                                                            StepCode* code);

}  // namespace assur
