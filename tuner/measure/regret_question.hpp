// One question to the dispatcher, and how good its answer was.
#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "assur/performance.hpp"
#include "measure/race.hpp"

namespace assur::measure {

struct Question {
  std::string scene;
  std::vector<std::string> without;  // backends
  int threads = 1;                   // budget

  [[nodiscard]] std::string without_text() const;  // "-lanes-klu"; "": all backends
};

// One plan in the last race of a question, with what was verified.
struct Finalist {
  std::string strategy;    // class by class where they differ
  double seconds = 0;      // one step, median
  double spread = 0;       // of seconds: median absolute deviation, of the pass where it was largest
  std::size_t rounds = 0;  // that were timed
  double error = 0;        // the worst residual of all its steps
};

struct Answer {
  Question question;
  Finalist chosen, best;
  Finalist again;                         // what was chosen, prepared once more and raced beside itself
  double expected_seconds = 0;            // of a step as chosen
  double best_trial_seconds = 0;          // of all in the first race, which those of `uniform` are to be compared with
  std::map<std::string, double> uniform;  // seconds of every strategy that is the same for all classes

  [[nodiscard]] double regret() const { return chosen.seconds / best.seconds - 1; }
  // What such a race tells of two plans that are the same: regrets of this size are those of the measurement.
  [[nodiscard]] double regret_to_itself() const { return std::max(chosen.seconds / again.seconds - 1, 0.0); }
};

struct QuestionOptions {
  std::shared_ptr<const PerformanceModel> model;  // what is asked
  bool quick = false;                             // fewer rounds
  double seconds = 4;                             // for each of three races, at most
  Instruments instruments = {};
};

// Races every uniform strategy first; then, class after class, other backends and lanes in the fastest ones; then
// measures the four fastest and the dispatcher's choice, this twice, again, in turns, in several passes with simulators
// made anew. Empty if it was stopped. Throws Error if nothing can run.
[[nodiscard]] std::optional<Answer> answer(const Question& question, const QuestionOptions& options);

}  // namespace assur::measure
