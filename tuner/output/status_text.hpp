// Numerical outcomes in words.
#pragma once

#include <string>
#include <vector>

#include "assur/report.hpp"

namespace assur::output {

// "the mechanism cannot move further (limit_reached)"
[[nodiscard]] std::string explained(Code code);

// Why a run stopped and where: "t = 1.3 s, group C: the mechanism cannot move further (limit_reached)".
[[nodiscard]] std::string why_stopped(const Status& status, const std::vector<Event>& events, double reached);

// "t = 1.5 s", or "t = 1.5 ... 1.6 s" for a bracket
[[nodiscard]] std::string time_of(const Event& event);
// ", group G", ", driver D" or ", 'equation' off by 0.001 m"; "" if the event has none.
[[nodiscard]] std::string place_of(const Event& event);

}  // namespace assur::output
