// What may crash or hang is tried in a process of its own first.
#pragma once

#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "assur/backend.hpp"
#include "assur/strategy.hpp"

namespace assur::tuning {

// Runs a program, silent, for so many seconds at most. "" if it ends with status 0, else what happened instead.
[[nodiscard]] std::string try_in_child(const std::vector<std::string>& command, double seconds);

// The child's part: some factorisations and solutions of a strategy. Throws Error if it cannot run or is wrong.
void probe(const Strategy& strategy, std::span<const Backend> table);

// Backends beyond those of the core, and those with more than one thread, as far as they say that they can run here:
// each tried with command(strategy) in a child.
class Probes {
 public:
  Probes(std::span<const Backend> table, ThreadBudget budget,
         const std::function<std::vector<std::string>(const Strategy&)>& command, double seconds);

  // Why a strategy is not to be tried; "": it is.
  [[nodiscard]] std::string why_not(const Strategy& strategy) const;
  // "mumps": "crashes (signal 11)"
  [[nodiscard]] const std::map<std::string, std::string>& failed() const { return failed_; }

 private:
  std::map<std::string, std::string> failed_;  // by backend, with "1xQ" where it has several threads
};

}  // namespace assur::tuning
