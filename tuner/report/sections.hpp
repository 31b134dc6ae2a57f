// The sections about this machine, one file each, and their conditions.
#pragma once

#include <functional>
#include <istream>
#include <string>
#include <vector>

#include "measure/race.hpp"
#include "report/knowledge.hpp"
#include "report/section.hpp"
#include "tuning/regret_question.hpp"

namespace assur::report {

struct Conditions {
  // Approximate time limit. The smallest piece of a section is always made; further pieces are made only if the time
  // suffices.
  double seconds = 60;
  bool quick = false;
  int threads = 1;  // budget
  std::function<bool()> interrupted = [] { return false; };

  // Instruments for races, which end when the report is interrupted.
  [[nodiscard]] measure::Instruments instruments() const {
    measure::Instruments out;
    out.stop = interrupted;
    return out;
  }
};

// The strategy that is expected to be the fastest, over number of groups and unknowns, and the crossovers.
[[nodiscard]] Section winners(const Knowledge& knowledge, const Conditions& conditions);

// The regret of `auto` and of the best constant strategy over mechanisms that were not tuned for.
[[nodiscard]] Section regret(const Knowledge& knowledge, const Conditions& conditions);
// The same section from given answers; planned: number of all questions.
[[nodiscard]] Section regret_section(const std::vector<tuning::Answer>& answers, std::size_t planned);

// Error and run time of some mechanisms, with the Pareto front and the choice of `auto`.
[[nodiscard]] Section work_precision(const Knowledge& knowledge, const Conditions& conditions);

// Speed-up by threads, lanes and members of an ensemble.
[[nodiscard]] Section scaling(const Knowledge& knowledge, const Conditions& conditions);

// Histogram of the times of single steps.
[[nodiscard]] Section step_histogram(const Knowledge& knowledge, const Conditions& conditions);

// Regret on held-out cells over the duration of a tuning run.
[[nodiscard]] Section tuning_cost(const Knowledge& knowledge, const Conditions& conditions);

// Expected and measured times of the held-out cells of a tuning run.
[[nodiscard]] Section model_fit(const Knowledge& knowledge, const Conditions& conditions);

// Other libraries on the same mechanisms: time, error, and time relative to assur with the same derivatives. in: output
// of bench/peers/peers.sh --csv; file: its name for messages. Throws Error (input) for another format.
[[nodiscard]] Section peers_section(std::istream& in, const std::string& file);

}  // namespace assur::report
