#include "machine.hpp"

#include <benchmark/benchmark.h>

#include <string>

#include "assur/backend.hpp"
#include "assur/machine.hpp"

namespace assur::bench {

void describe_machine() {
  benchmark::AddCustomContext("machine", to_string(this_machine()));
  benchmark::AddCustomContext("compiler", "g++ " __VERSION__);
  benchmark::AddCustomContext("build", ASSUR_BUILD_TYPE);
  for (const Backend& backend : backends()) {
    const std::string version = backend.version();
    benchmark::AddCustomContext("backend " + std::string(backend.id), version.empty() ? "absent" : version);
  }
}

}  // namespace assur::bench
