// What is not computed because no output needs it, for `inspect` and `run`.
#pragma once

#include <string_view>

#include "assur/structure.hpp"
#include "output/json.hpp"
#include "output/page.hpp"

namespace assur::output {

// {formulation, groups, unknowns, equations, levels[{group, derivatives, for_predictor}], static_groups}
[[nodiscard]] Json to_json(const LeftOut& left_out, Formulation formulation);

// It depends on the formulation: linear equations that are eliminated do not count in `irreducible`.
void print(Page& page, const LeftOut& left_out, Formulation formulation, std::string_view label = "left out");

}  // namespace assur::output
