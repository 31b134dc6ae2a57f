// report.csv: every number of the report, a row each.
#pragma once

#include <ostream>
#include <span>

#include "report/section.hpp"

namespace assur::report {

// section, item, strategy, quantity, unit, value, repetitions, spread, error, origin; 17 digits, an error that nobody
// knows is empty. Texts in quotes, quotes within them doubled.
void write_csv(std::ostream& out, std::span<const Section> sections);

}  // namespace assur::report
