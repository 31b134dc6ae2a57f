// What is measured for scaling: a mechanism step after step, one over a whole run, and an ensemble.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "assur/scene.hpp"
#include "assur/simulator.hpp"
#include "contest.hpp"

namespace assur::bench {

struct Prepare {
  std::string strategy;
  int budget = 1;  // threads that it may take
};

// Latency: blocks of step(). Contenders of the same `steps` go through the same times. times_steps: one by one too.
[[nodiscard]] std::unique_ptr<Contender> make_steps(const Scene& scene, const Prepare& prepare, int steps,
                                                    const StepLimits& limits = {}, bool times_steps = false);

// Steps of `scene` by `strategy` that take about so long, on one thread; at least 1.
[[nodiscard]] int steps_in(double seconds, const Scene& scene, const std::string& strategy);

// Throughput: all of the scene's times in one run.
[[nodiscard]] std::unique_ptr<Contender> make_run(const Scene& scene, const Prepare& prepare);

// Throughput: all members over their times, in lanes and threads; or, by make_members_one_by_one, a few of them each on
// its own, which are the sample of both.
[[nodiscard]] std::unique_ptr<Contender> make_ensemble(const std::vector<Scene>& members, const Prepare& prepare);
[[nodiscard]] std::unique_ptr<Contender> make_members_one_by_one(const std::vector<Scene>& members,
                                                                 const Prepare& prepare);

// The same contender among `processes` busy ones.
[[nodiscard]] std::unique_ptr<Contender> in_a_crowd(std::unique_ptr<Contender> contender, int processes);

}  // namespace assur::bench
