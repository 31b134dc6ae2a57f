// Computes numbers of a mechanism from the values of parameters, for several members side by side.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "evaluation/lane_array.hpp"
#include "executors/step_code.hpp"
#include "files/expression.hpp"
#include "tables/parameter_tape.hpp"

namespace assur {

class Replay {
 public:
  // lanes: number of members at once, at most; code: null if there is none
  Replay(const ParameterProgram& program, std::size_t lanes, StepCode* code = nullptr);

  // Computes the wanted numbers of the members; parameters[l]: those of lane l.
  void run(std::span<const double* const> parameters);
  // The wanted number i of each lane.
  [[nodiscard]] const double* wanted(std::size_t i) const { return wanted_.data() + i * w_; }
  // False if the recorded computation would have gone another way for the member, or if a number is not finite.
  [[nodiscard]] bool holds(std::size_t lane) const { return off_[lane] == 0; }

 private:
  struct Text {
    Formula formula;
    std::vector<std::uint32_t> arguments;  // rows
    std::uint32_t row;                     // of its value
  };
  struct Stage {
    std::shared_ptr<const Executor> program;
    std::vector<Text> texts;
  };

  std::size_t w_;
  std::vector<Stage> parts_;
  LaneArray parameters_, rows_, wanted_, off_;  // x W
  std::vector<double> arguments_;               // of one text and lane
};

}  // namespace assur
