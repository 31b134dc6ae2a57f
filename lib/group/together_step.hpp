// The passes over all groups of a class that are solved together with those of other levels
// (program/together_step.hpp): by machine code where there is some, else by kernels, with the same bits.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "assur/structure.hpp"
#include "equations/coefficients.hpp"
#include "execute/step_code.hpp"
#include "program/slopes.hpp"
#include "program/together_step.hpp"

namespace assur {

// What the passes of a class need; all must outlive the step.
struct TogetherClass {
  const GroupClass& group_class;
  std::span<const std::int32_t> reads;  // coordinates of the branch test, as registers
  const Slopes& slopes;
};

class TogetherStep {
 public:
  virtual ~TogetherStep() = default;
  // memory: see Executor
  virtual void run(TogetherPass pass, std::span<double* const> memory) = 0;
};

// For a class that why_not_together() allows.
[[nodiscard]] std::unique_ptr<TogetherStep> make_together_step(const TogetherClass& of, const TogetherShape& shape);
// By machine code. Null if there is none.
[[nodiscard]] std::unique_ptr<TogetherStep> make_coded_together_step(const TogetherClass& of,
                                                                     const TogetherShape& shape, StepCode& code);

}  // namespace assur
