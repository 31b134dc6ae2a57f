// Report of `inspect` and `run` about parts that no output needs.
#pragma once

#include <string_view>

#include "output/json.hpp"
#include "output/page.hpp"
#include "structure/grouped_system.hpp"

namespace assur::output {

// {formulation, groups, unknowns, equations, levels[{group, derivatives, for_predictor}], static_groups}
[[nodiscard]] Json to_json(const LeftOut& left_out, Formulation formulation);

// The numbers depend on the formulation: `irreducible` leaves out eliminated linear equations.
void print(Page& page, const LeftOut& left_out, Formulation formulation, std::string_view label = "left out");

}  // namespace assur::output
