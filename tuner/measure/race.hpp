// Workloads measured in turns, each round in another order, so that whatever else the machine does falls on all of them
// alike. Who is hopeless leaves early; what it took until then stays known.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "measure/workload.hpp"

namespace assur::measure {

struct Runner {
  Workload* work = nullptr;
  int heat = 0;             // only those of one heat are compared
  int share = 1;            // results of one call: seconds are compared for one result
  int threads = 1;          // at work side by side: of several, only times on cores at the same pace say much
  double by_the_clock = 0;  // s of one call that the work waits by the clock: they are the same at any pace

  // What the race finds out.
  int calls = 1;                     // of a block
  std::vector<double> seconds = {};  // rounds: of one call, at the usual pace
  std::vector<double> raw = {};      // the same, as the clock had them
  bool hopeless = false;             // left early
  bool failed = false;               // a call failed: no times

  [[nodiscard]] double median() const;  // of one call, s; infinite without a time
  // Median absolute deviation, s. From less than three rounds: the range of two, all of one.
  [[nodiscard]] double spread() const;
  // How many times as long as usual it took: the median by the clock over that at the usual pace, but for by_the_clock.
  [[nodiscard]] double slowness() const;
};

struct RaceRules {
  double block = 20e-6;  // s that a block takes at least
  double seconds = 0.5;  // for everything; what has begun is ended
  int trial_rounds = 3;  // after which the hopeless leave
  int least_rounds = 7;  // of the others, time permitting
  int most_rounds = 40;  // also if the two best cannot be told apart
  double hopeless = 3;   // the best time over the leader's median from which on a runner is
  int repeats = 3;       // of a block that was disturbed, at most
  std::uint64_t seed = 1;
};

struct Instruments {
  std::function<double()> clock;                      // s, monotonic
  std::function<std::int64_t(int threads)> switches;  // involuntary ones so far: see involuntary_switches()
  std::function<bool()> stop;                         // asked before each block
  // How many times as long as usual everything takes at the moment: what times are divided by. Asked every millisecond.
  std::function<double()> slowness;
  // How many times as long as on the fastest core a piece of work takes on the slowest at the moment.
  std::function<double()> unevenness;

  Instruments();  // those of the system; never stops; times count as they are
};

struct RaceFigures {
  std::int64_t blocks = 0;     // repeated ones as well
  std::int64_t disturbed = 0;  // of these, those during which the processor was taken away
  std::int64_t shared = 0;     // blocks of several threads, repeated ones as well
  std::int64_t uneven = 0;     // of these, those while one core was much slower than another
  double slowness = 1;         // of the machine, the middle one
};

// Runners are compared for one result with all of their heat that have the same or a smaller share: what needs fewer
// groups side by side is never hopeless only because wider ones are faster.
RaceFigures race(std::span<Runner> runners, const RaceRules& rules, const Instruments& instruments = {});

// Since they began: of the calling thread, or, where several threads are at work, of all in this process.
[[nodiscard]] std::int64_t involuntary_switches(int threads);

}  // namespace assur::measure
