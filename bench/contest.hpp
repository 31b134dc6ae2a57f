// Candidates measured in turns: every round measures all of them, so that whatever else the machine does falls on all.
// A time counts only if the result that was timed is right.
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

// Of one step: by the clock, and processor time of the calling thread.
struct Cost {
  double seconds = 0, processor = 0;
};

// Something that computes the same motion as the others of its contest.
class Contender {
 public:
  virtual ~Contender() = default;

  // One block of work. Throws Error (numerical) if it fails.
  virtual Cost work() = 0;

  // What the last block arrived at: rows of columns(). `sample` is the part that the base has as well.
  [[nodiscard]] virtual std::span<const double> result() const = 0;
  [[nodiscard]] virtual std::span<const double> sample() const { return result(); }
  [[nodiscard]] virtual const std::vector<std::string>& columns() const = 0;
  [[nodiscard]] virtual double residual() const = 0;  // ErrorFigures::position so far

  // Of single steps, if they are timed one by one, else null.
  [[nodiscard]] virtual const measure::StepTimes* step_times() const { return nullptr; }
};

// One candidate, and what was measured of it.
struct Entry {
  static constexpr std::size_t kItself = static_cast<std::size_t>(-1);

  std::string scene, strategy;
  std::string condition = "";  // "pinned", "4 busy processes"; "": none
  int members = 1;
  int legs = 0;                 // that a step is divided by in the table of legs
  std::size_t base = kItself;   // of the contest: its time is that of speed-up 1
  std::size_t alone = kItself;  // the same strategy on one thread
  double bound = 0;             // of the deviation from `alone`, or else the base; 0: the same bits
  std::unique_ptr<Contender> contender = nullptr;

  std::string failure = "";            // why it has no times; "": it has
  bool wrong = false;                  // the failure is a wrong result
  std::vector<double> seconds = {};    // rounds: for one step
  std::vector<double> processor = {};  // the same as processor time of the calling thread
  double deviation = 0;                // the largest of all rounds
  double residual = std::numeric_limits<double>::quiet_NaN();
};

// Measures all entries in turns, `rounds` times. An entry whose result is wrong, or that fails, is left with its
// failure and no times.
void hold(std::vector<Entry>& contest, int rounds);

using measure::deviation;

struct Spread {
  double lower = 0, median = 0, upper = 0;  // quartiles
};
[[nodiscard]] Spread spread(const std::vector<double>& values);

// Rounds of an entry that tell most: processor time of one thread, which a busy machine disturbs little; by the clock
// of several.
[[nodiscard]] const std::vector<double>& telling(const Entry& entry);

// Times of `of` over those of `entry`, round by round: neighbours in time, which share the machine's mood. Processor
// time if both have one thread.
[[nodiscard]] Spread speed_up(const Entry& entry, const Entry& of);

}  // namespace assur::bench
