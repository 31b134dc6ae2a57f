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
  double seconds = 0;      // one step, by paired_medians of the passes
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
  std::shared_ptr<const PerformanceModel> model = nullptr;  // what is asked; null: that of this machine
  bool quick = false;                                       // fewer rounds
  double seconds = 4;                                       // for each race, at most; a pass has a part of it
  Instruments instruments = {};
};

inline constexpr int kPasses = 5;  // of a last race, if there is time

// Who may be the answer to a question. The last race is in passes, which should be minutes apart: another program on
// the machine slows some strategies down more than others, as long as it runs.
class Contest {
 public:
  // Races every uniform strategy; then, class after class, other backends and lanes in the fastest ones. Empty if it
  // was stopped. Throws Error if nothing can run.
  [[nodiscard]] static std::optional<Contest> open(const Question& question, const QuestionOptions& options);

  // A pass: the four fastest, what is best for each class, and the dispatcher's choice, this twice, in turns, with
  // simulators made anew (where memory lies is not the strategy's). False if it was stopped or the choice had no turn:
  // then it does not count.
  [[nodiscard]] bool race();

  [[nodiscard]] Answer answer() const;  // of the passes, of which there has to be one
  [[nodiscard]] const Question& question() const;

  Contest(Contest&&) noexcept;
  Contest& operator=(Contest&&) noexcept;
  ~Contest();

 private:
  struct Impl;
  explicit Contest(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// What each racer takes, from what it took in each pass: of its times over those of the last racer in the same pass the
// median, times the last racer's median. A machine that is slower in one pass than in another changes no ratio.
// seconds[pass][racer].
[[nodiscard]] std::vector<double> paired_medians(const std::vector<std::vector<double>>& seconds);

}  // namespace assur::measure
