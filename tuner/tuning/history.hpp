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
    double seconds = 0;  // time of a call, for one lane; infinite: there was no time to measure it
    double leader = 0;   // time of a call of the fastest candidate of the cell
    double setup = 0;    // time of analysis, first factorisation and verification, for one group, s
  };
  void note(const std::string& family, const Candidate& candidate, const CandidateTimes& entry);

  // The reason why a candidate is hopeless for groups of n unknowns of the family; "": it is not. It is hopeless if at
  // the two next smaller sizes it took more than twenty times the time of the leader and grew faster, or if its setup,
  // one call, or the analysis of its backend without policies and lanes is expected to take more than `seconds`.
  [[nodiscard]] std::string hopeless(const std::string& family, const Candidate& candidate, double n, double groups,
                                     double seconds) const;

 private:
  [[nodiscard]] std::string why_hopeless(const std::string& key, double n, double groups, double seconds) const;

  std::map<std::string, std::vector<CandidateTimes>> entries_;  // by family, kernel and strategy
};

}  // namespace assur::tuning
