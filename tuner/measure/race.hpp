// Races: workloads are measured in turns, in a new order in each round, so that other programs of the machine disturb
// all of them alike. Hopeless workloads leave early and keep the times measured so far.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "measure/workload.hpp"

namespace assur::measure {

// A workload in a race, with its results.
struct Runner {
  Workload* work = nullptr;
  int heat = 0;               // only runners of one heat are compared
  int share = 1;              // results of one call; seconds for one result are compared
  int threads = 1;            // threads of the work; if several, only times on cores of equal pace are reliable
  bool by_the_clock = false;  // true: its times do not follow the pace of one core (follows_pace())

  // Results of the race.
  int calls = 1;                     // calls in a block
  std::vector<double> seconds = {};  // rounds: time of one call, at the usual pace
  std::vector<double> raw = {};      // rounds: time of one call, by the clock
  bool hopeless = false;             // left early
  bool failed = false;               // a call failed: no times

  [[nodiscard]] double median() const;  // median time of one call, s; infinite without a time
  // Median absolute deviation, s; with two rounds the range of their times, with one round its whole time.
  [[nodiscard]] double spread() const;
  // Slowness during its blocks: median by the clock over median at the usual pace.
  [[nodiscard]] double slowness() const;
};

struct RaceRules {
  double block = 20e-6;     // least duration of a block, s
  double seconds = 0.5;     // duration of the whole race, s; a block that has begun is finished
  int least_blocks = 1;     // a runner with fewer times has none; from 2 on, those that would not get them do not start
  bool awaits_even = true;  // false: does not wait until all cores have the same pace
  int trial_rounds = 3;     // rounds after which hopeless runners leave
  int least_rounds = 7;     // rounds of the others, if time allows
  int most_rounds = 40;     // even if the two best are still close
  double hopeless = 3;      // a runner is hopeless if its best time exceeds this times the leader's median
  int repeats = 3;          // largest number of repetitions of a disturbed block
  std::uint64_t seed = 1;
};

struct Instruments {
  std::function<double()> clock;                      // s, monotonic
  std::function<std::int64_t(int threads)> switches;  // see involuntary_switches()
  std::function<bool()> stop;                         // called before each block; true ends the race
  // Current slowness of the machine, which times are divided by. Called every millisecond.
  std::function<double()> slowness;
  // Current time of the slowest core over that of the fastest core.
  std::function<double()> unevenness;

  Instruments();  // the clock of the system; never stops; slowness 1
};

struct RaceFigures {
  std::int64_t blocks = 0;     // including repeated ones
  std::int64_t disturbed = 0;  // blocks among them during which the system took the processor away
  std::int64_t shared = 0;     // blocks of several threads, including repeated ones
  std::int64_t uneven = 0;     // blocks among them while one core was much slower than another
  double slowness = 1;         // median slowness of the machine
  double timed = 0;            // s that all blocks took together
};

// Runs a race. A runner is compared, by the time of one result, with runners of its heat that have the same or a
// smaller share: a runner that needs fewer groups side by side is never hopeless only because wider ones are faster.
RaceFigures race(std::span<Runner> runners, const RaceRules& rules, const Instruments& instruments = {});

// Involuntary context switches so far: of the calling thread, or of all threads of the process if threads > 1.
[[nodiscard]] std::int64_t involuntary_switches(int threads);

}  // namespace assur::measure
