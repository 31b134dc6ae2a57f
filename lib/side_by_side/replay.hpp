// Computes the numbers of a tape for other values of its parameters, for several members side by side: by step
// programs, between which muParser evaluates formulas.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "equations/lane_array.hpp"
#include "execute/step_code.hpp"
#include "scene/expression.hpp"
#include "scene/tape.hpp"

namespace assur {

class Replay {
 public:
  // lanes: number of members at once, at most; wanted: nodes whose values are asked for; code: null if there is none
  Replay(const Tape& tape, std::span<const Tape::Node> wanted, std::size_t lanes, StepCode* code = nullptr);

  // Computes the wanted numbers of the members; parameters[l]: those of lane l.
  void run(std::span<const double* const> parameters);
  // The wanted number i of each lane.
  [[nodiscard]] const double* wanted(std::size_t i) const { return wanted_.data() + i * w_; }
  // False if the recorded computation would have gone another way for the member, or if a number is not finite.
  [[nodiscard]] bool holds(std::size_t lane) const { return off_[lane] == 0; }

 private:
  struct TextOf {
    Formula formula;
    std::vector<std::uint32_t> arguments;  // rows
    std::uint32_t row;                     // of its value
  };
  // What can be computed without formulas that were not evaluated yet; then these formulas.
  struct Part {
    std::shared_ptr<const Executor> program;
    std::vector<TextOf> formulas;
  };

  std::size_t w_;
  std::vector<Part> parts_;
  LaneArray parameters_, rows_, wanted_, off_;  // x W; rows_: numbers that formulas and later parts read
  std::vector<double> arguments_;               // of one formula and lane
};

}  // namespace assur
