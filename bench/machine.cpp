#include "machine.hpp"

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

}  // namespace assur::bench
