// What the tuning database answers, for people and as JSON.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "db/store.hpp"
#include "output/json.hpp"
#include "output/page.hpp"

namespace assur::output {

// [{column: value}]; what is not known is null, a column `content` is JSON itself.
[[nodiscard]] Json to_json(const db::Answer& answer);

// Those of its columns that are named, in this order, under these titles. Times and errors as text with units; a
// machine by the beginning of its fingerprint, and only if there are several.
void print(Page& page, const db::Answer& answer, const std::vector<std::pair<std::string, std::string>>& columns);

}  // namespace assur::output
