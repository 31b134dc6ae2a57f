// Results of queries to the tuning database, for people and as JSON.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "db/store.hpp"
#include "output/json.hpp"
#include "output/page.hpp"

namespace assur::output {

// [{column: value}]; unknown values are null, a column `content` is JSON itself.
[[nodiscard]] Json to_json(const db::Answer& answer);

// Prints the named columns, in this order, under these titles. Times and errors have units. A machine is shown by the
// beginning of its fingerprint, and only if there are several machines.
void print(Page& page, const db::Answer& answer, const std::vector<std::pair<std::string, std::string>>& columns);

}  // namespace assur::output
