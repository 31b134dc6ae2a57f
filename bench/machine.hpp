// The description of the machine, which is written before any number, and the clock of one thread.
#pragma once

#include <iosfwd>
#include <string>
#include <utility>
#include <vector>

namespace assur::bench {

// Name and text: processor, compiler, build type, library versions.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> machine_facts();

// Prints one line for each pair, with `prefix` in front.
void describe_machine(std::ostream& out, const std::string& prefix = "");

// Processor time of the calling thread, s.
[[nodiscard]] double processor_seconds();

}  // namespace assur::bench
