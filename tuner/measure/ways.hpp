// Ways to run a scene that are worth comparing: solvers, and variations of a solver.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "assur/plan.hpp"
#include "assur/scene.hpp"
#include "assur/strategy.hpp"

namespace assur::measure {

enum class Knob : std::uint8_t {
  solver,  // formulation, backend, lanes, threads
  predictor,
  iterations,  // fixed
  precision,   // float, refinement
  policy,      // how often to factorise
};

[[nodiscard]] std::string_view name(Knob knob) noexcept;  // "solver", ...: part of the command's JSON

struct Way {
  Strategy strategy;
  int iterations = 0;  // StepSettings::iterations
  Knob knob = Knob::solver;
};

// "groups/klu --iterations 2": as `assur run` takes it.
[[nodiscard]] std::string to_string(const Way& way);

// Every solver that can run here in every formulation that the scene has, on one thread and on as many as allowed.
[[nodiscard]] std::vector<Way> solvers(const Scene& scene, ThreadBudget budget);

// One solver with one setting changed at a time, and each of these with fixed iterations.
[[nodiscard]] std::vector<Way> variations(const Strategy& solver);

// The solver with fixed iterations only.
[[nodiscard]] std::vector<Way> fixed_iterations(const Strategy& solver);

// The strategies of the classes, " | " between them; one if all are the same.
[[nodiscard]] std::string text_of(const Plan& plan);

// A text that is equal for plans that run alike, including threads of levels.
[[nodiscard]] std::string essence(const Plan& plan);

// True for dense factors of many hundred unknowns, which take up to a second for a step.
[[nodiscard]] bool is_hopeless(const Plan& plan);

}  // namespace assur::measure
