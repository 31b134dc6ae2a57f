// Candidates measured in turns: every round measures all of them, so that other work of the machine disturbs all alike.
// A time counts only if the timed result is correct.
#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "measure/deviation.hpp"
#include "measure/step_times.hpp"

namespace assur::bench {

// Times of one step: by the clock, and processor time of the calling thread.
struct Cost {
  double seconds = 0, processor = 0;
};

// Something that computes the same motion as the others of its contest.
class Contender {
 public:
  virtual ~Contender() = default;

  // One block of work. Throws Error (numerical) if it fails.
  virtual Cost work() = 0;

  // Results of the last block: rows of columns(). `sample` is the part that the base computes as well.
  [[nodiscard]] virtual std::span<const double> result() const = 0;
  [[nodiscard]] virtual std::span<const double> sample() const { return result(); }
  [[nodiscard]] virtual const std::vector<std::string>& columns() const = 0;
  [[nodiscard]] virtual double residual() const = 0;  // ErrorFigures::position so far

  // Times of single steps, if they are timed one by one; else null.
  [[nodiscard]] virtual const measure::StepTimes* step_times() const { return nullptr; }
};

// One candidate, with its measurements.
struct Entry {
  static constexpr std::size_t kItself = static_cast<std::size_t>(-1);

  std::string scene, strategy;
  std::string condition = "";  // "pinned", "4 busy processes"; "": none
  int members = 1;
  int legs = 0;                 // number of legs; the table of legs divides the time of a step by it
  std::size_t base = kItself;   // index of the entry that has the speed-up 1
  std::size_t alone = kItself;  // index of the entry with the same strategy on one thread
  double bound = 0;             // largest allowed deviation from `alone`, or else from `base`; 0: the same bits
  std::unique_ptr<Contender> contender = nullptr;

  std::string failure = "";            // reason why it has no times; "": it has times
  bool wrong = false;                  // the failure is a wrong result
  std::vector<double> seconds = {};    // rounds: for one step
  std::vector<double> processor = {};  // the same as processor time of the calling thread
  double deviation = 0;                // the largest of all rounds
  double residual = std::numeric_limits<double>::quiet_NaN();
};

// Measures all entries in turns, `rounds` times. An entry that fails, or whose result is wrong, gets no times, only
// `failure`.
void hold(std::vector<Entry>& contest, int rounds);

using measure::deviation;

struct Spread {
  double lower = 0, median = 0, upper = 0;  // quartiles
};
[[nodiscard]] Spread spread(const std::vector<double>& values);

// The most reliable times of an entry, one for each round: processor time if it has one thread, because a busy machine
// disturbs it little; time by the clock if it has several threads.
[[nodiscard]] const std::vector<double>& telling(const Entry& entry);

// Times of `of` divided by those of `entry`, round by round, because the machine has a similar load within a round.
// Processor time if both have one thread.
[[nodiscard]] Spread speed_up(const Entry& entry, const Entry& of);

}  // namespace assur::bench
