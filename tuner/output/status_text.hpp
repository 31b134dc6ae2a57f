// Numerical outcomes in words.
#pragma once

#include <string>

#include "assur/report.hpp"

namespace assur::output {

// "the mechanism cannot move further (limit_reached)"
[[nodiscard]] std::string explained(Code code);

// "t = 1.5 s", or "t = 1.5 ... 1.6 s" for a bracket
[[nodiscard]] std::string time_of(const Event& event);

}  // namespace assur::output
