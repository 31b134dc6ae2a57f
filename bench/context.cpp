#include <benchmark/benchmark.h>

#include "machine.hpp"

namespace assur::bench {

void describe_machine() {
  for (const auto& [name, text] : machine_facts()) benchmark::AddCustomContext(name, text);
}

}  // namespace assur::bench
