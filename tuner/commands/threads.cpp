#include <iostream>
#include <string>

#include "assur/machine.hpp"
#include "commands/commands.hpp"

namespace assur::command {

void check_threads(const Common& common) {
  if (common.threads == 0) return;
  const Machine machine = this_machine();
  const std::string threads = std::to_string(common.threads);
  if (common.threads > machine.processors) {
    refuse("--threads", threads + " threads are too many: this process may use " + std::to_string(machine.processors) +
                            (machine.processors == 1 ? " processor" : " processors"));
  }
  if (common.threads > machine.budget().threads && !common.quiet) {
    std::cerr << "warning: --threads: " << threads << " threads exceed the budget of this machine; "
              << to_string(machine) << '\n';
  }
}

}  // namespace assur::command
