// Texts for numerical outcomes.
#pragma once

#include <string>
#include <vector>

#include "assur/report.hpp"

namespace assur {

// "the mechanism cannot move further (fold)"
[[nodiscard]] std::string explained(Code code);

// Reason and place where a run stopped: "t = 1.3 s, group C: the mechanism cannot move further (fold)".
[[nodiscard]] std::string why_stopped(const Status& status, const std::vector<Event>& events, double reached);

// "t = 1.5 s", or "t = 1.5 ... 1.6 s" for a bracket
[[nodiscard]] std::string time_of(const Event& event);
// ", group G", ", driver D", ", limit of Q" or ", 'equation'"; "" if the object has no name.
[[nodiscard]] std::string place_of(Code kind, const std::string& name);
// The same of an event, with the figure of an equation: ", 'equation' off by 0.001 m".
[[nodiscard]] std::string place_of(const Event& event);

}  // namespace assur
