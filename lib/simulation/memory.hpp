#pragma once

#include <cstddef>

namespace assur {

// Throws Error (environment) if there is no room for so many results. Memory that is promised but not there ends the
// process later, so it is asked for first.
void check_memory(std::size_t rows, std::size_t columns);

}  // namespace assur
