// Scene + strategy, or what is known about the machine -> everything that a simulator needs, prepared.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "assur/backend.hpp"
#include "assur/performance.hpp"
#include "assur/scene.hpp"
#include "assur/strategy.hpp"
#include "assur/structure.hpp"

namespace assur {

// One solver for each class of a structure.
struct Plan {
  struct Choice {
    std::int32_t group_class = 0;
    Shape shape;
    SolverSettings solver;
    std::int32_t threads = 1;     // packs of this class at once
    std::string reason;           // "forced", "interpolated: 2.1 times as fast as klu", ...
    double expected_seconds = 0;  // one step of one pack; 0: nobody asked
    Origin origin = Origin::prior;
  };
  RunSettings run;              // its predictor is never automatic
  std::int32_t lanes = 1;       // W asked for: of a class, or, where mechanisms run side by side, mechanisms
  std::vector<Choice> choices;  // one for each class
  std::vector<std::int32_t> level_threads;  // of each level, of run.threads; empty: those for all
  double accuracy = 0;                      // PrepareOptions::accuracy
  std::string reason;                       // of the formulation and of p
  double expected_seconds = 0;              // one step: groups, laws, prediction, outputs (no rows); 0: nobody asked
  double meeting_seconds = 0;               // of the threads, once; 0: nobody asked

  // The strategy text of one class: what forces its solver, and this run, for all classes.
  [[nodiscard]] Strategy strategy(const Choice& choice) const;
};

// An estimated error that a run tells of where no accuracy was asked for.
inline constexpr double kDoubtfulError = 1e-6;

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
  // What `auto` decides by; null: machine_model(). A model without samples decides by counts of operations.
  std::shared_ptr<const PerformanceModel> model = nullptr;
  std::vector<std::string> without = {};  // backends that `auto` leaves out, and a strategy text must not name
  // Largest forward error (ErrorFigures) that any output may have; looser ones take less time. 0: as exact as doubles
  // are. Steps whose estimated error is larger, or where nothing is asked larger than kDoubtfulError, carry
  // Code::inaccurate.
  double accuracy = 0;
};

// A scene made ready: immutable, shared by any number of simulators.
struct Prepared {
  std::shared_ptr<const Scene> scene;  // null: loaded by load_plan()
  std::string name;                    // of the scene
  TimeGrid time;                       // of the scene: what a run goes over if it is not told its times
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
// undetermined scene (the free unknowns are named), a budget of no threads, or laws and Jacobians of the program that
// are wrong at the start (docs/accuracy.md), numerical if the start posture cannot be assembled (group and
// most violated constraint are named), environment if a forced strategy cannot run here (and why).
[[nodiscard]] Prepared prepare(const Scene& scene, const PrepareOptions& options = {});

// What a strategy would cost.
struct Candidate {
  Strategy strategy;
  double expected_seconds = 0;  // all groups, or matrices, once
  double factor = 1;            // two times in three within expected_seconds / factor and expected_seconds * factor
  Origin origin = Origin::prior;
  std::string why_not;  // "": it can run here, and is as accurate as a solution in double
};

// What candidates are chosen by.
struct CandidateOptions {
  std::shared_ptr<const PerformanceModel> model = nullptr;  // null: machine_model()
  std::optional<ThreadBudget> budget = std::nullopt;        // empty: this machine's
  std::vector<std::string> without = {};
};

// Every candidate for the groups of one class that are solved side by side, the fastest first, those that cannot run
// last. shape.groups: how many; shape.terms = 0: bare matrices, each factorised once and solved with shape.rhs
// right-hand sides. The first is what `auto` takes: of those within 2 % of the fastest the one with fewer threads.
[[nodiscard]] std::vector<Candidate> candidates(const Shape& shape, const CandidateOptions& options = {});

// For equations of one's own: the strategy for `count` matrices with one pattern, each factorised once and solved with
// `rhs` right-hand sides: backend, W, precision and threads are those of the first of candidates(). Throws Error:
// input for less than one matrix, environment if no backend can run.
[[nodiscard]] Candidate choose_solver(const Pattern& pattern, std::int32_t count, std::int32_t rhs = 1,
                                      const CandidateOptions& options = {});

}  // namespace assur
