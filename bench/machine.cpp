#include "machine.hpp"

#include <time.h>

#include <ostream>

#include "assur/backend.hpp"
#include "assur/machine.hpp"

namespace assur::bench {

std::vector<std::pair<std::string, std::string>> machine_facts() {
  std::vector<std::pair<std::string, std::string>> facts = {
      {"machine", to_string(this_machine())}, {"compiler", "g++ " __VERSION__}, {"build", ASSUR_BUILD_TYPE}};
  for (const Backend& backend : backends()) {
    const std::string version = backend.version();
    facts.emplace_back("backend " + std::string(backend.id), version.empty() ? "absent" : version);
  }
  return facts;
}

void describe_machine(std::ostream& out, const std::string& prefix) {
  for (const auto& [name, text] : machine_facts()) out << prefix << name << ": " << text << std::endl;
}

double processor_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace assur::bench
