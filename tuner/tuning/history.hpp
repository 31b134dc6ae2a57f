// What candidates took at smaller sizes, and what that says about larger ones.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tuning/entrants.hpp"

namespace assur::tuning {

class History {
 public:
  // Of one candidate in one cell.
  struct Entry {
    double n = 0;        // unknowns
    double seconds = 0;  // of a call, for one lane
    double leader = 0;   // the same of the fastest in the cell
    double setup = 0;    // s until it could be timed: analysis, first factorisation, verification
  };
  void note(const std::string& family, const Candidate& candidate, const Entry& entry);

  // Why a candidate is not worth a try at n unknowns of the family; "": it is. It is not if at the two next smaller
  // sizes it took more than twenty times the leader's time and grew faster than the leader, or if it is expected to
  // take more than `seconds` to set up or for one call.
  [[nodiscard]] std::string hopeless(const std::string& family, const Candidate& candidate, double n,
                                     double seconds) const;

 private:
  std::map<std::string, std::vector<Entry>> entries_;  // by family, kernel and strategy
};

}  // namespace assur::tuning
