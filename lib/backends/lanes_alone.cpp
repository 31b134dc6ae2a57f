#include "backends/lanes_alone.hpp"

#include <utility>

namespace assur::lanes {

LaneAlone::LaneAlone(std::shared_ptr<const Pattern> pattern)
    : pattern_(std::move(pattern)),
      limits_(limits(pattern_->n, Precision::binary64)),
      factors_(1, Precision::binary64) {}

Code LaneAlone::factorize(std::span<const double> values) {
  if (good_ && factors_.factorize(values, limits_).any() == 0) return Code::ok;
  good_ = false;
  for (const PivotRule& rule : kRules) {
    // markowitz_order() divides, so that it decides about singularity; a small pivot that it leaves must be accepted.
    const Order order = markowitz_order(*pattern_, values, 1, 1, rule);
    if (!order.complete(pattern_->n)) return Code::singular;
    factors_.set_program(std::make_shared<const Elimination>(write_program(*pattern_, order)));
    const Alarms alarms = factors_.factorize(values, limits_);
    good_ = alarms.any() == 0;
    if (alarms.growth == 0) return Code::ok;
  }
  return factors_.finite() ? Code::ok : Code::singular;  // no rule gives better factors
}

}  // namespace assur::lanes
