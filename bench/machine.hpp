// What a time was measured on: written before any number.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace assur::bench {

// Name and text: processor, compiler, build type, library versions.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> machine_facts();

// Adds them to the context that Google Benchmark prints and stores.
void describe_machine();

}  // namespace assur::bench
