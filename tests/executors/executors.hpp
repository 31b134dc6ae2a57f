// All executors of this machine for one program.
#pragma once

#include <hwy/targets.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "executors/executor.hpp"

namespace assur::test {

struct NamedExecutor {
  std::string name;
  int lanes;
  std::unique_ptr<Executor> executor;
};

// Interpreters for every instruction set of the processor, also those without fused products. only: numbers of lanes
inline std::vector<NamedExecutor> executors_of(const StepProgram& program,
                                               const std::vector<int>& only = {1, 2, 4, 8, 16}) {
  std::vector<NamedExecutor> all;
  for (const int lanes : only) {
    const std::string width = ", W = " + std::to_string(lanes);
    for (std::int64_t left = hwy::SupportedTargets(); left != 0; left &= left - 1) {
      hwy::SetSupportedTargetsForTest(left & -left);
      all.push_back({hwy::TargetName(left & -left) + width, lanes, make_interpreter(program, lanes)});
      hwy::SetSupportedTargetsForTest(0);
    }
    if (auto code = make_machine_code(program, lanes, VectorCode::avx2)) {
      all.push_back({"AVX2 code" + width, lanes, std::move(code)});
    }
    if (lanes < 8) continue;
    if (auto code = make_machine_code(program, lanes, VectorCode::avx512)) {
      all.push_back({"AVX-512 code" + width, lanes, std::move(code)});
    }
  }
  return all;
}

// Memory of a step for a number of lanes.
class StepMemory {
 public:
  // sizes: slots of each memory
  StepMemory(const std::array<std::size_t, kMemories>& sizes, int lanes) : lanes_(static_cast<std::size_t>(lanes)) {
    for (std::size_t m = 0; m < kMemories; ++m) {
      numbers_[m].assign(std::max(sizes[m], std::size_t{1}) * lanes_, 0.0);
      at[m] = numbers_[m].data();
    }
  }

  double& operator()(Slot slot, std::size_t lane) {
    return at[static_cast<std::size_t>(slot.memory)][slot.index * lanes_ + lane];
  }

  std::array<double*, kMemories> at;

 private:
  std::size_t lanes_;
  std::array<std::vector<double>, kMemories> numbers_;
};

}  // namespace assur::test
