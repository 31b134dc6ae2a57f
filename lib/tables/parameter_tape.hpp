// Writes programs that compute numbers of a mechanism from the values of parameters.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "program/step_graph.hpp"
#include "scene/tape.hpp"

namespace assur {

// Parts that run one after the other. They read the parameters in Memory::factors, and numbers of other parts and of
// texts in Memory::work. The last one writes the wanted numbers to Memory::outputs, and to Memory::figures: 0 if all
// comparisons have their recorded outcomes and all numbers that are compared or wanted are finite, else another number
// or NaN.
struct ParameterProgram {
  // A text that is evaluated between two parts.
  struct Text {
    std::string text;
    std::vector<std::string> names;
    std::vector<std::uint32_t> arguments;  // rows of Memory::work
    std::uint32_t row = 0;                 // of its value
  };
  struct Stage {
    StepProgram program;
    std::vector<Text> texts;  // evaluated after it
  };

  std::vector<Stage> parts;
  std::size_t parameters = 0, rows = 0, wanted = 0;
};

class ParameterTape final : public Tape {
 public:
  // The next parameter, with a value.
  [[nodiscard]] Number parameter(double value);
  [[nodiscard]] Number formula(std::string text, std::vector<std::string> names, std::span<const Number> arguments,
                               double value) override;
  // What computes these numbers, and the outcomes of all comparisons. Leaves out what they do not need.
  [[nodiscard]] ParameterProgram program(std::span<const Number> wanted);

 private:
  std::optional<std::size_t> operation(Number::Operation op, const Number& a, const Number& b,
                                       const Number& c) override;
  void comparison(const Number& a, const Number& b, bool is_less, bool outcome) override;

  // A value, and the number of texts on the longest way to it.
  struct StagedValue {
    Value value;
    std::size_t depth = 0;
  };
  struct Formula {
    ParameterProgram::Text text;
    std::vector<Value> arguments;
    std::size_t depth;
  };
  [[nodiscard]] StagedValue entry(const Number& number) const;
  std::size_t add(const StagedValue& entry);

  Graph graph_;
  std::vector<StagedValue> entries_;  // by place
  std::vector<Formula> formulas_;
  std::vector<Value> conditions_;  // 0 where the computation is repeated
  std::size_t parameters_ = 0, rows_ = 0;
};

}  // namespace assur
