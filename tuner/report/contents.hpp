// What a report has, in order.
#pragma once

#include <vector>

#include "report/report.hpp"

namespace assur::report {

[[nodiscard]] std::vector<Planned> contents(const Knowledge& knowledge);

}  // namespace assur::report
