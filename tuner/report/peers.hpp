// Other libraries on the same mechanisms, as bench/peers/peers.sh has measured them.
#pragma once

#include <istream>
#include <string>

#include "report/section.hpp"

namespace assur::report {

// A table with what each takes, how far off it is, and how many times as long as assur with the same levels it takes.
// in: what peers.sh writes with --csv; file: its name, for messages. Throws Error (input) for what is something else.
[[nodiscard]] Section peers_section(std::istream& in, const std::string& file);

}  // namespace assur::report
