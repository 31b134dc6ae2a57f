// Outputs as step programs: of one mechanism, by machine code; or of mechanisms of one structure, one in each lane of
// the state, by machine code or by lists of operations.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "evaluation/lane_array.hpp"
#include "executors/step_code.hpp"
#include "outputs/output_program.hpp"

namespace assur {

class OutputSteps {
 public:
  // Of one mechanism, whose program does not change. Null if it has no code.
  [[nodiscard]] static std::unique_ptr<OutputSteps> of_one(const OutputProgram& outputs, StepCode& code);
  // One program for each lane; they must outlive this object. code: null if there is none
  OutputSteps(std::span<const OutputProgram> outputs, std::shared_ptr<StepCode> code);

  // What is new in the programs of the lanes.
  enum class News : std::uint8_t { none, numbers, all };
  // To be called when programs of lanes have changed. used: number of lanes with mechanisms; the others repeat the
  // first.
  void bind(std::size_t used, News news = News::all);

  // Computes the vectors of all angles(), see OutputProgram::arm(): x and then, from padded(angles x W) on, y; each
  // angles x W. False: they must be computed one by one.
  [[nodiscard]] bool arms(const double* q, double* vectors) const;

  // Like OutputProgram::evaluate() for all lanes: turns, out and divisors are angles x W, columns x W, measures x W.
  void evaluate(const double* const (&state)[3], double* out, const double* turns, double* divisors);

  // Like OutputProgram::differentiate() for all lanes. state, change: with all lanes; out: columns x W
  void differentiate(const double* const (&state)[3], const double* const (&change)[3], RandomSign* sign, double* out);

 private:
  using Numbers = OutputProgram::Numbers;
  explicit OutputSteps(const OutputProgram& outputs) : outputs_(&outputs, 1) {}
  template <class Make>
  void make(Numbers numbers, const Make& executor);
  [[nodiscard]] std::array<double*, kMemories> memory(const double* q) const;
  [[nodiscard]] bool by_program() const { return values_ && is_alike_; }
  void evaluate_one_by_one(const double* const (&state)[3], double* out, const double* turns, double* divisors);

  std::span<const OutputProgram> outputs_;
  std::size_t used_ = 1, compared_ = 0;            // compared_: lanes whose shapes were compared
  std::shared_ptr<const Executor> values_, arms_;  // null: they have nothing to do, or too much
  std::shared_ptr<const Executor> changes_;        // null: it was not needed yet
  std::shared_ptr<StepCode> code_;                 // for changes_, if they are needed often
  int changed_ = 0;                                // number of differentiate()
  LaneArray roundings_;                            // x W
  bool has_others_ = true;                         // measures that are not in the programs
  bool is_alike_ = true;                           // the programs of all lanes have one shape
  LaneArray numbers_;                              // x W
  std::vector<double> row_, turns_, divisors_;     // of one lane
};

}  // namespace assur
