#include "backends/lanes_alone.hpp"

#include <utility>

namespace assur::lanes {

LaneAlone::LaneAlone(std::shared_ptr<const Pattern> pattern, PivotMemory& memory)
    : pattern_(std::move(pattern)),
      memory_(memory),
      limits_(limits(pattern_->n, Precision::binary64)),
      factors_(1, Precision::binary64) {
  factors_.reserve(pattern_->n);
}

Code LaneAlone::factorize(std::span<const double> values) {
  if (good_ && factors_.factorize(values, limits_).any() == 0) return Code::ok;
  good_ = false;
  for (const PivotRule& rule : kRules) {
    // markowitz_order() divides, so that it decides about singularity; a small pivot that it leaves must be accepted.
    std::pmr::memory_resource* const temporary = memory_.anew();
    const Order order = markowitz_order(*pattern_, values, 1, 1, rule, temporary);
    if (!order.complete(pattern_->n)) return Code::singular;
    const std::shared_ptr<Elimination> program = memory_.program();
    write_program(*pattern_, order, temporary, *program);
    factors_.set_program(program);
    const Alarms alarms = factors_.factorize(values, limits_);
    good_ = alarms.any() == 0;
    if (alarms.growth == 0) return Code::ok;
  }
  return factors_.finite() ? Code::ok : Code::singular;  // no rule gives better factors
}

}  // namespace assur::lanes
