// report.csv: every number of the report, a row each.
#pragma once

#include <ostream>
#include <span>

#include "report/section.hpp"

namespace assur::report {

// section, item, strategy, quantity, unit, value, repetitions, spread, error, origin; up to 17 digits. Empty: the
// spread of fewer than two repetitions, an unknown error. Texts in quotes, quotes within them doubled.
void write_csv(std::ostream& out, std::span<const Section> sections);

}  // namespace assur::report
