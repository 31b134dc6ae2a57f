// Machine code for the steps of groups, which all simulators of a process share.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "backends/lanes_elimination.hpp"
#include "evaluation/coefficients.hpp"
#include "executors/executor.hpp"
#include "structure/grouped_system.hpp"

namespace assur {

// No code is made for longer steps; 1,000 instructions take about 0.5 ms.
inline constexpr std::size_t kMostInstructions = 16'000;
// Nor for more steps of a mechanism than these together have: 20 to 30 ms.
inline constexpr std::size_t kMostOfAll = 40'000;

// Null: there is no code. work: numbers in Memory::work
struct CodeOfStep {
  std::shared_ptr<const Executor> executor;
  std::size_t work = 0;
};

// Of class_step() and so on. Null: there is no code.
struct CodeOfClass {
  std::shared_ptr<const Executor> step, anchor, factors, changes;
};

class StepCode {
 public:
  virtual ~StepCode() = default;

  // "AVX-512" or "AVX2"
  [[nodiscard]] virtual std::string vectors() const = 0;

  // The code of group_step() for this number of lanes. It is made once, and then again only if many other classes were
  // asked for since. Several threads may call it at once.
  [[nodiscard]] virtual CodeOfStep of(const GroupClass& group_class, std::span<const std::int32_t> reads,
                                      int lanes) = 0;
  // The code of a class with this elimination, likewise. makes: false if only code that was made before may be used
  [[nodiscard]] virtual CodeOfClass of(const GroupClass& group_class, const lanes::Elimination& elimination,
                                       std::span<const std::int32_t> reads, int lanes, bool makes) = 0;
  // The code of any other program, likewise. Null if it is too long, or if there is no code.
  [[nodiscard]] virtual std::shared_ptr<const Executor> of(const StepProgram& program, int lanes) = 0;
};

// Code for one mechanism, with the best vectors of this processor. Null if it cannot run machine code, or if this build
// makes none. Needs the library assur::assur.
[[nodiscard]] std::shared_ptr<StepCode> step_code();

}  // namespace assur
