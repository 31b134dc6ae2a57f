#include "tables/replay.hpp"

#include <array>
#include <bit>

namespace assur {

Replay::Replay(const ParameterProgram& program, std::size_t lanes, StepCode* code)
    : w_(std::bit_ceil(lanes)),
      parameters_(program.parameters * w_),
      rows_(program.rows * w_),
      wanted_(program.wanted * w_),
      off_(w_) {
  for (const ParameterProgram::Stage& p : program.parts) {
    Stage& part = parts_.emplace_back();
    if (code != nullptr) part.program = code->of(p.program, static_cast<int>(w_));
    if (!part.program) part.program = make_interpreter(p.program, static_cast<int>(w_));
    for (const ParameterProgram::Text& t : p.texts) {
      part.texts.push_back({Formula(t.text, t.names), t.arguments, t.row});
    }
  }
}

void Replay::run(std::span<const double* const> parameters) {
  for (std::size_t l = 0; l < w_; ++l) {
    const double* const of_lane = parameters[l < parameters.size() ? l : 0];  // idle lanes repeat the first one
    for (std::size_t i = 0; i * w_ < parameters_.size(); ++i) parameters_[i * w_ + l] = of_lane[i];
  }
  std::array<double*, kMemories> memory;
  memory[static_cast<std::size_t>(Memory::factors)] = parameters_.data();
  memory[static_cast<std::size_t>(Memory::work)] = rows_.data();
  memory[static_cast<std::size_t>(Memory::outputs)] = wanted_.data();
  memory[static_cast<std::size_t>(Memory::figures)] = off_.data();
  for (Stage& part : parts_) {
    part.program->run(memory);
    for (Text& text : part.texts) {
      for (std::size_t l = 0; l < parameters.size(); ++l) {
        arguments_.clear();
        for (const std::uint32_t row : text.arguments) arguments_.push_back(rows_[row * w_ + l]);
        rows_[text.row * w_ + l] = text.formula(arguments_);
      }
    }
  }
}

}  // namespace assur
