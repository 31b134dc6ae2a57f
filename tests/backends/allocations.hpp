// Counts all allocations of this program and of the libraries that it loads.
#pragma once

#include <cstdint>

namespace assur::test {

// Calls of malloc and its relatives, operator new included, since the program started.
std::int64_t allocations();

}  // namespace assur::test
