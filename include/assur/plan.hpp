// Scene + strategy -> everything that a simulator needs, prepared.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "assur/backend.hpp"
#include "assur/scene.hpp"
#include "assur/strategy.hpp"
#include "assur/structure.hpp"

namespace assur {

// One strategy for each class of a structure.
struct Plan {
  struct Choice {
    std::int32_t group_class = 0;
    Shape shape;
    Strategy strategy;
    std::string reason;  // "forced", "not measured: sparse, in lanes", ...
  };
  Formulation formulation = Formulation::groups;
  Predictor predictor;          // resolved: never automatic
  std::int32_t lanes = 1;       // W asked for: of a class, or, where mechanisms run side by side, mechanisms
  std::int32_t chunks = 1;      // of the time grid, run side by side
  std::int32_t threads = 1;     // p
  std::vector<Choice> choices;  // one for each class
};

// What a plan is to be fast at.
enum class Mode : std::uint8_t {
  latency,     // one mechanism, step after step
  throughput,  // many steps a second: variants in an Ensemble, else chunks of the time grid side by side
};

struct PrepareOptions {
  std::string strategy = "auto";  // or a strategy text, which is then forced
  // Drivers that the program sets itself with Simulator::set(); their laws serve until the first set().
  std::vector<std::string> controlled = {};
  // Threads to use at most, which may be more than there are cores; empty: this_machine().budget().
  std::optional<ThreadBudget> budget = std::nullopt;
  // In throughput, `auto` fills lanes and all threads of the budget, and a text that does not say how many chunks gets
  // as many as fill its own lanes and threads. The machine is asked where no budget is given: give one to prepare many.
  Mode mode = Mode::latency;
};

// A scene made ready: immutable, shared by any number of simulators.
struct Prepared {
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const Structure> structure;
  Plan plan;
  std::span<const Backend> table;  // where the plan's backends are found
  std::vector<std::string> controlled;
  std::optional<double> start_time = std::nullopt;  // of structure->start; empty: the scene's
  // Chooses anew among redundant equations at a posture (all coordinates, internal units) and time; empty if there are
  // none.
  std::function<Prepared(std::vector<double> posture, double time)> reselect;
};

// Analyses the scene and assembles its start posture. Throws Error: input for a strategy text that does not parse or an
// undetermined scene (the free unknowns are named) or a budget of no threads, numerical if the start posture cannot be
// assembled (group and most violated constraint are named), environment if a forced strategy cannot run here (and why).
[[nodiscard]] Prepared prepare(const Scene& scene, const PrepareOptions& options = {});

}  // namespace assur
