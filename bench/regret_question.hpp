// One question to the dispatcher, and how good its answer was.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "assur/assur.hpp"

namespace assur::bench {

struct Question {
  std::string scene;
  std::vector<std::string> without;  // backends
  int threads = 1;                   // budget

  [[nodiscard]] std::string without_text() const;  // "-lanes-klu"; "": all backends
};

struct Answer {
  Question question;
  std::string chosen, best;                                           // strategies, class by class where they differ
  double chosen_seconds = 0, best_seconds = 0, expected_seconds = 0;  // one step
  double best_trial_seconds = 0;          // of all in the first race, which those of `uniform` are to be compared with
  std::map<std::string, double> uniform;  // seconds of every strategy that is the same for all classes

  [[nodiscard]] double regret() const { return chosen_seconds / best_seconds - 1; }
};

// Races every uniform strategy first; then, class after class, other backends and lanes in the fastest ones; then
// measures the four fastest and the dispatcher's choice again, in turns. Throws Error if nothing can run.
[[nodiscard]] Answer answer(const Question& question, const std::shared_ptr<const PerformanceModel>& model, bool quick);

}  // namespace assur::bench
