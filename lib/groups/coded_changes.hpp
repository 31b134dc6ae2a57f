// Changes of the unknowns of a pack that follow from changes of its inputs, by machine code (program/class_step.hpp).
#pragma once

#include <array>
#include <span>

#include "groups/workspace.hpp"

namespace assur {

// For the packs of one class.
class CodedChanges {
 public:
  // Takes memory only for a class that has a class_step().
  explicit CodedChanges(const Workspace& work);

  // See ErrorProbe::follow(), with the same bits. False: there is no code that serves, or something is unusual.
  [[nodiscard]] bool follow(const Pack& pack, LinearSolver& solver, const double* posture,
                            std::span<double* const> changes);

 private:
  [[nodiscard]] double*& at(Memory m) { return memory_[static_cast<std::size_t>(m)]; }

  const Workspace& work_;
  LaneArray inputs_, input_changes_, values_, failed_;  // inputs x W, inputs x W, memory of the code, W
  std::array<double*, kMemories> memory_{};
};

}  // namespace assur
