// The sections about this machine, a file each, and what they are made under.
#pragma once

#include <functional>
#include <istream>
#include <string>
#include <vector>

#include "measure/race.hpp"
#include "measure/regret_question.hpp"
#include "report/knowledge.hpp"
#include "report/section.hpp"

namespace assur::report {

struct Conditions {
  // To take, about: the smallest piece of a section is always made, no further one that cannot fit.
  double seconds = 60;
  bool quick = false;
  int threads = 1;  // budget
  std::function<bool()> interrupted = [] { return false; };

  // For races: they end when the report is interrupted.
  [[nodiscard]] measure::Instruments instruments() const {
    measure::Instruments out;
    out.stop = interrupted;
    return out;
  }
};

// Which strategy is expected to win for how many groups of how many unknowns, and where another one begins to.
[[nodiscard]] Section winners(const Knowledge& knowledge, const Conditions& conditions);

// The regret of `auto` and of the best constant strategy over mechanisms that no tuner has seen.
[[nodiscard]] Section regret(const Knowledge& knowledge, const Conditions& conditions);
// The same from answers that are there; planned: questions that there are.
[[nodiscard]] Section regret_section(const std::vector<measure::Answer>& answers, std::size_t planned);

// Error against run time of some mechanisms, with the front and what `auto` takes.
[[nodiscard]] Section work_precision(const Knowledge& knowledge, const Conditions& conditions);

// Speed-up by threads, lanes and members of an ensemble.
[[nodiscard]] Section scaling(const Knowledge& knowledge, const Conditions& conditions);

// How long single steps take: their histogram.
[[nodiscard]] Section step_histogram(const Knowledge& knowledge, const Conditions& conditions);

// Regret on what was held out, over the seconds that a tuning run has taken.
[[nodiscard]] Section tuning_cost(const Knowledge& knowledge, const Conditions& conditions);

// Expected against measured times of what a tuning run has held out.
[[nodiscard]] Section model_fit(const Knowledge& knowledge, const Conditions& conditions);

// Other libraries on the same mechanisms: what each takes, how far off it is, and how many times as long as assur with
// the same levels it takes. in: what bench/peers/peers.sh writes with --csv; file: its name, for messages. Throws Error
// (input) for what is something else.
[[nodiscard]] Section peers_section(std::istream& in, const std::string& file);

}  // namespace assur::report
