// What is run for each cell of the paper's tables, and how much of it a budget of time allows.
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "report/paper/paper.hpp"

namespace assur::report {

// The solvers that stand for the paper's on this machine, by their properties; ids of backends.
struct StandIns {
  std::string dense;     // for MKL, one thread in each group
  std::string threaded;  // for MKL with several threads in each of several groups; "": there is none
  std::string sparse;    // for MA27
  bool ma27 = false;     // itself is there as well, for one thread
};
[[nodiscard]] StandIns stand_ins();

// What this library has of its own, beside the paper's versions: auto, and the solver that fills lanes.
[[nodiscard]] const std::vector<std::string>& ours();

// One thing to run in a cell.
struct Entrant {
  std::string version;
  Split split;
  Reading reading = Reading::shared;
  std::string strategy;
};

// p q <= threads, p <= groups: 1 to 4, then 6, 8, 12, 16, ...
[[nodiscard]] std::vector<Split> splits(int threads, int groups);

// Table 5's 6x2 and 2x6, as far as the threads go: 2x1 and 1x2 of two, 4x1 and 1x4 of four, 6x2 and 2x6 of twelve.
struct WideAndNarrow {
  Split wide, narrow;
};
[[nodiscard]] WideAndNarrow wide_and_narrow(int threads);

// Whether both readings are run: not in the large cells of table 5, where they are 11 and 12 factorisations of a step.
[[nodiscard]] bool reads_twice(const PaperCell& cell);

// A mechanism and everything that is to be timed in turns on it.
struct PaperContest {
  PaperCell cell;
  std::vector<Entrant> entrants;
};
// Of all tables, each mechanism once; quick: small ones only.
[[nodiscard]] std::vector<PaperContest> contests(int threads, bool quick, const StandIns& with);

// Seconds of one step, expected: by counts until something like it has been timed.
class PaperCosts {
 public:
  [[nodiscard]] double step(const PaperCell& cell, const Entrant& entrant) const;
  // Of everything that has to happen once for an entrant: preparation, verification, and three rounds.
  [[nodiscard]] double least(const PaperCell& cell, const Entrant& entrant) const;
  void learn(const PaperCell& cell, const Entrant& entrant, double seconds);

 private:
  std::map<std::string, double> correction_;  // of the counts, by kind of entrant: the last one that was timed
};

// Entrants that fit into so many seconds together, the cheapest first over all contests: rows x entrants, true if it
// is to be run.
[[nodiscard]] std::vector<std::vector<bool>> affordable(std::span<const PaperContest> contests, const PaperCosts& costs,
                                                        double seconds);

}  // namespace assur::report
