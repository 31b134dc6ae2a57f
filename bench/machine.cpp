#include "machine.hpp"

#include <benchmark/benchmark.h>

#include <fstream>
#include <string>

#include "assur/backend.hpp"

namespace assur::bench {
namespace {

std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
  }
  return "unknown";
}

}  // namespace

void describe_machine() {
  benchmark::AddCustomContext("processor", processor());
  benchmark::AddCustomContext("compiler", "g++ " __VERSION__);
  benchmark::AddCustomContext("build", ASSUR_BUILD_TYPE);
  for (const Backend& backend : backends()) {
    const std::string version = backend.version();
    benchmark::AddCustomContext("backend " + std::string(backend.id), version.empty() ? "absent" : version);
  }
}

}  // namespace assur::bench
