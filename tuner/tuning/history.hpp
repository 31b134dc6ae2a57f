// Times of candidates at smaller sizes, to skip hopeless ones at larger sizes.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tuning/entrants.hpp"

namespace assur::tuning {

class History {
 public:
  // Times of one candidate in one cell.
  struct CandidateTimes {
    double n = 0;        // unknowns
    double seconds = 0;  // time of a call, for one lane
    double leader = 0;   // time of a call of the fastest candidate of the cell
    double setup = 0;    // time of analysis, first factorisation and verification, s
  };
  void note(const std::string& family, const Candidate& candidate, const CandidateTimes& entry);

  // The reason why a candidate is hopeless at n unknowns of the family; "": it is not. It is hopeless if at the two
  // next smaller sizes it took more than twenty times the time of the leader and grew faster, or if its setup or one
  // call is expected to take more than `seconds`.
  [[nodiscard]] std::string hopeless(const std::string& family, const Candidate& candidate, double n,
                                     double seconds) const;

 private:
  std::map<std::string, std::vector<CandidateTimes>> entries_;  // by family, kernel and strategy
};

}  // namespace assur::tuning
