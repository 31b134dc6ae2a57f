// What is not computed because no output needs it, for `inspect` and `run`.
#pragma once

#include "assur/structure.hpp"
#include "output/json.hpp"
#include "output/page.hpp"

namespace assur::output {

// {groups, unknowns, equations, levels[{group, derivatives, for_predictor}], static_groups}
[[nodiscard]] Json to_json(const LeftOut& left_out);

void print(Page& page, const LeftOut& left_out);

}  // namespace assur::output
