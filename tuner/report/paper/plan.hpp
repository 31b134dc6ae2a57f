// Plans the runs for each cell of the paper's tables within a budget of time.
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "report/paper/paper.hpp"

namespace assur::report {

// Backends on this machine that replace the solvers of the paper, chosen by their properties; ids.
struct StandIns {
  std::string dense;                      // for MKL, one thread in each group
  std::string threaded;                   // for MKL with several threads in each of several groups; "": none
  std::string sparse;                     // for MA27
  bool ma27 = false;                      // true if MA27 itself is available, for one thread
  std::vector<std::string> devices = {};  // for MAGMA: all backends on a GPU
};
[[nodiscard]] StandIns stand_ins();

// Versions of this library beyond those of the paper: `auto`, and the solver that fills lanes.
[[nodiscard]] const std::vector<std::string>& ours();

// A version of a cell with the strategy that is run for it.
struct Entrant {
  std::string version;
  Split split;
  Reading reading = Reading::shared;
  std::string strategy;
};

// All splits with p q <= threads and p <= groups; p and q are 1 to 4, then 6, 8, 12, 16, ...
[[nodiscard]] std::vector<Split> splits(int threads, int groups);

// The splits 6x2 and 2x6 of table 5, or similar ones for fewer threads: 2x1 and 1x2 for two, 4x1 and 1x4 for four
// threads.
struct WideAndNarrow {
  Split wide, narrow;
};
[[nodiscard]] WideAndNarrow wide_and_narrow(int threads);

// True if both readings are run: not in the large cells of table 5, where a step has 11 or 12 factorisations.
[[nodiscard]] bool reads_twice(const PaperCell& cell);

// A mechanism with all entrants that are timed in turns.
struct PaperContest {
  PaperCell cell;
  std::vector<Entrant> entrants;
};
// The contests of all tables, one for each mechanism; quick: small mechanisms only.
[[nodiscard]] std::vector<PaperContest> contests(int threads, bool quick, const StandIns& with);

// Expected seconds of one step: by operation counts until a similar entrant was timed.
class PaperCosts {
 public:
  [[nodiscard]] double step(const PaperCell& cell, const Entrant& entrant) const;
  // Expected seconds of the least work for an entrant: preparation, verification, and three rounds.
  [[nodiscard]] double least(const PaperCell& cell, const Entrant& entrant) const;
  void learn(const PaperCell& cell, const Entrant& entrant, double seconds);

 private:
  std::map<std::string, double>
      correction_;  // measured over counted seconds, by type of entrant, of the last timed one
};

// Selects entrants that fit into `seconds` together, the cheapest first over all contests. [contest][entrant]: true if
// it runs.
[[nodiscard]] std::vector<std::vector<bool>> affordable(std::span<const PaperContest> contests, const PaperCosts& costs,
                                                        double seconds);

}  // namespace assur::report
