// Results on standard output.
#pragma once

#include <iostream>

#include "commands/commands.hpp"
#include "output/json.hpp"
#include "output/page.hpp"

namespace assur::command {

// Prints the JSON object of a report, or its page.
template <class Report>
void print_result(const Common& common, const Report& report) {
  if (common.json) return output::print(std::cout, to_json(report));
  output::Page page(std::cout);
  print(page, report);
}

}  // namespace assur::command
