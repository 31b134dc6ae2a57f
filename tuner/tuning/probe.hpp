// Tries strategies that may crash or hang in a child process first.
#pragma once

#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "assur/backend.hpp"
#include "assur/strategy.hpp"

namespace assur::tuning {

// Runs a program without output for at most `seconds`. "" if it ends with status 0, else a description of its end.
[[nodiscard]] std::string try_in_child(const std::vector<std::string>& command, double seconds);

// Runs in the child: some factorisations and solutions. Throws Error if the strategy cannot run or is wrong.
void probe(const Strategy& strategy, std::span<const Backend> table);

// Results of trials of all backends that are not in the core, and of backends with several threads, if why_not() allows
// them. Each one runs command(strategy) in a child.
class Probes {
 public:
  Probes(std::span<const Backend> table, ThreadBudget budget,
         const std::function<std::vector<std::string>(const Strategy&)>& command, double seconds);

  // The reason why a strategy must not be tried; "": it may be tried.
  [[nodiscard]] std::string why_not(const Strategy& strategy) const;
  // "mumps": "crashes (signal 11)"
  [[nodiscard]] const std::map<std::string, std::string>& failed() const { return failed_; }

 private:
  std::map<std::string, std::string> failed_;  // reasons by backend, with "1xQ" for several threads
};

}  // namespace assur::tuning
