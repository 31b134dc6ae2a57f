// The section of what `auto` loses, from answers that are there.
#pragma once

#include <vector>

#include "measure/regret_question.hpp"
#include "report/section.hpp"

namespace assur::report {

// planned: questions that there are.
[[nodiscard]] Section regret_section(const std::vector<measure::Answer>& answers, std::size_t planned);

}  // namespace assur::report
