// All executors of this machine for one program.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "execute/executor.hpp"

namespace assur::test {

struct NamedExecutor {
  std::string name;
  int lanes;
  std::unique_ptr<Executor> executor;
};

inline std::vector<NamedExecutor> executors_of(const StepProgram& program) {
  std::vector<NamedExecutor> all;
  for (const int lanes : {1, 2, 4, 8, 16}) {
    all.push_back({"interpreter, W = " + std::to_string(lanes), lanes, make_interpreter(program, lanes)});
    for (const VectorCode vectors : {VectorCode::avx2, VectorCode::avx512}) {
      auto code = make_machine_code(program, lanes, vectors);
      const std::string name = vectors == VectorCode::avx2 ? "AVX2, W = " : "AVX-512, W = ";
      if (code) all.push_back({name + std::to_string(lanes), lanes, std::move(code)});
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
