// The contenders in measurements of scaling: a mechanism step after step, a mechanism over a whole run, and an
// ensemble.
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
  int budget = 1;  // largest number of threads
};

// Latency: blocks of step(). Contenders with the same `steps` go through the same times. times_steps: also times single
// steps.
[[nodiscard]] std::unique_ptr<Contender> make_steps(const Scene& scene, const Prepare& prepare, int steps,
                                                    const StepSettings& settings = {}, bool times_steps = false);

// Number of steps of `scene` by `strategy` that take about this time on one thread; at least 1.
[[nodiscard]] int steps_in(double seconds, const Scene& scene, const std::string& strategy);

// Throughput of one run over all times of the scene.
[[nodiscard]] std::unique_ptr<Contender> make_run(const Scene& scene, const Prepare& prepare);

// Throughput of an ensemble. make_members runs all members over their times, in lanes and threads;
// make_members_one_by_one runs a few of them one after the other. Both give the results of these few as their sample.
[[nodiscard]] std::unique_ptr<Contender> make_ensemble(const std::vector<Scene>& members, const Prepare& prepare);
[[nodiscard]] std::unique_ptr<Contender> make_members_one_by_one(const std::vector<Scene>& members,
                                                                 const Prepare& prepare);

// The same contender, while `processes` other processes keep the processors busy.
[[nodiscard]] std::unique_ptr<Contender> in_a_crowd(std::unique_ptr<Contender> contender, int processes);

}  // namespace assur::bench
