// The regret of the dispatcher for one question: how much slower is its plan than the best one?
#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "assur/performance.hpp"
#include "assur/plan.hpp"
#include "measure/race.hpp"

namespace assur::tuning {

struct Question {
  std::string scene;                      // as for a command, or "dyads:N" or "tripods:N" (tuning/mechanisms.hpp)
  std::vector<std::string> without;       // backends
  int threads = 1;                        // budget
  double accuracy = 0;                    // PrepareOptions::accuracy
  std::vector<std::string> outputs = {};  // empty: those of the scene
  Mode mode = Mode::latency;              // throughput: whole runs are timed, with their rows

  [[nodiscard]] std::string without_text() const;  // "-lanes-klu"; "": all backends
  [[nodiscard]] std::string text() const;          // scene, and what differs from the defaults except threads
};

// One plan in the last race of a question.
struct Finalist {
  std::string strategy;    // class by class if they differ
  double seconds = 0;      // of one step, by paired_medians of the passes
  double spread = 0;       // largest median absolute deviation of all passes, s
  std::size_t rounds = 0;  // timed rounds
  double error = 0;        // largest residual of all its steps
};

struct Answer {
  Question question;
  Finalist chosen, best;
  Finalist again;                         // the chosen plan, prepared again and raced against itself
  Finalist untuned;                       // the choice without any measurement
  double expected_seconds = 0;            // expected time of a step of the chosen plan
  double best_trial_seconds = 0;          // best time in the first race, for comparison with `uniform`
  std::map<std::string, double> uniform;  // seconds of a step, for each strategy that all classes share

  [[nodiscard]] double regret() const { return chosen.seconds / best.seconds - 1; }
  // Regret between two equal plans in the same race: the error of the measurement.
  [[nodiscard]] double regret_to_itself() const { return std::max(chosen.seconds / again.seconds - 1, 0.0); }
};

struct QuestionOptions {
  std::shared_ptr<const PerformanceModel> model = nullptr;  // null: the model of this machine
  bool quick = false;                                       // fewer rounds
  double seconds = 4;                                       // largest time of a race; each pass has a part of it
  measure::Instruments instruments = {};
};

inline constexpr int kPasses = 5;  // passes of the last race, if there is time

// The contest for one question. Its last race has several passes, which should be minutes apart: while another program
// runs, it slows some strategies down more than others.
class Contest {
 public:
  // Races all uniform strategies; then, class after class, other backends and lanes within the fastest of them. Empty
  // if it was stopped. Throws Error if no strategy can run.
  [[nodiscard]] static std::optional<Contest> open(const Question& question, const QuestionOptions& options);

  // Runs one pass of the last race: the four fastest strategies, the combination of the best strategies of all classes,
  // and the choice of the dispatcher twice. Each pass makes new simulators, because a strategy does not determine where
  // its memory lies. False if it was stopped, or if the choice was not timed; the pass is then not used.
  [[nodiscard]] bool race();

  [[nodiscard]] Answer answer() const;  // from the passes; at least one is needed
  [[nodiscard]] const Question& question() const;

  Contest(Contest&&) noexcept;
  Contest& operator=(Contest&&) noexcept;
  ~Contest();

 private:
  struct Impl;
  explicit Contest(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// Time of each racer from its times in all passes: the median of its ratios to the last racer in the same pass, times
// the median of the last racer. A machine that is slower in one pass changes no ratio. seconds[pass][racer].
[[nodiscard]] std::vector<double> paired_medians(const std::vector<std::vector<double>>& seconds);

}  // namespace assur::tuning
