// What a time was measured on, written before any number, and the clock of one thread.
#pragma once

#include <iosfwd>
#include <string>
#include <utility>
#include <vector>

namespace assur::bench {

// Name and text: processor, compiler, build type, library versions.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> machine_facts();

// A line for each, with `prefix` in front.
void describe_machine(std::ostream& out, const std::string& prefix = "");

// Processor time of the calling thread, s.
[[nodiscard]] double processor_seconds();

}  // namespace assur::bench
