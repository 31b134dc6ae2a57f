// The ordinary step of a small mechanism, or of the mechanisms in the lanes of a tile, as one call of machine code
// (program/mechanism_step.hpp): driven coordinates, predictions and groups of all levels. If anything is unusual, the
// step is solved as if there were no such code, with the same bits.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "drivers/drive_program.hpp"
#include "executors/step_code.hpp"
#include "groups/attempt.hpp"
#include "groups/small_step.hpp"
#include "motion/layout.hpp"
#include "motion/state.hpp"
#include "program/group_step.hpp"

namespace assur {

class WholeStep {
 public:
  // Null if there is no such code: for a group that has no small step, or if it would be too long. All must outlive it.
  // drivers: null if run() finds the known coordinates at hand; their structure must not change. first: packs before
  // this one are at rest. lanes: of mechanisms side by side, all of which have these drivers
  [[nodiscard]] static std::unique_ptr<WholeStep> make(Layout& layout, DriveProgram* drivers, const State& state,
                                                       StepCode& code, std::size_t first = 0, int lanes = 1);

  // To be called when coordinates at rest may have changed.
  void forget() { knows_rest_ = false; }
  // To be called when numbers of the drivers may have changed.
  void take_drivers();

  // Tries the step to a time for which the laws are evaluated. True: the state at hand is solved, and finish() must
  // follow if nothing speaks against it. False: its unknowns, and known coordinates that it computes, are unspecified.
  [[nodiscard]] bool run(double* const (&state)[3], const State::Prediction& prediction, const Attempt& attempt);
  [[nodiscard]] Status finish(double* const (&state)[3], const Attempt& attempt, Counters& counters, StepErrors& errors,
                              std::size_t& failed);  // failed: among all packs

 private:
  // Of a pack, in Memory::figures.
  struct Figures {
    double* of_lanes;            // kGroupFigures x W
    const PackKernels* kernels;  // for this W; null: 1
    double largest[kGroupFigures];

    [[nodiscard]] double operator[](GroupFigure f) const { return largest[static_cast<std::size_t>(f)]; }
  };
  // New anchors of a pack.
  struct Anchors final : AnchorStep {
    [[nodiscard]] const double* renew_anchors(Pack& pack, double* const (&state)[3], double time) override;

    WholeStep* of = nullptr;
    std::size_t number = 0;  // of the pack
    std::shared_ptr<const Executor> code;
  };
  WholeStep(Layout& layout, DriveProgram* drivers, std::size_t first)
      : layout_(layout), drivers_(drivers), packs_(std::span(layout.packs).subspan(first)), first_(first) {}
  [[nodiscard]] GroupSolver& solver(const Pack& pack) {
    return *layout_.solvers[static_cast<std::size_t>(pack.group_class)];
  }
  void reserve(std::size_t work);
  void take_rest(const double* state);
  [[nodiscard]] bool find_figures();
  [[nodiscard]] double*& at(Memory memory, std::size_t group = 0) {
    return memory_[group * kMemories + static_cast<std::size_t>(memory)];
  }

  Layout& layout_;
  DriveProgram* drivers_;
  std::span<Pack> packs_;  // of the layout, from first_ on
  std::size_t first_;
  std::shared_ptr<const Executor> code_;
  std::size_t weights_ = 0;       // of the prediction
  int lanes_ = 1;                 // see make()
  LaneArray factors_, work_;      // memory of the code
  LaneArray inputs_;              // of all groups
  LaneArray of_lanes_;            // figures of all groups
  std::vector<Figures> figures_;  // packs
  std::vector<Anchors> anchors_;  // packs
  double undefined_ = 0;          // kUndefined
  std::vector<double*> memory_;
  std::array<double, kGroupSettings> settings_{};
  bool knows_rest_ = false;  // inputs_ hold the coordinates at rest
};

}  // namespace assur
