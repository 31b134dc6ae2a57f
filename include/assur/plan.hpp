// Preparation: from a scene and a strategy, or the performance model, to everything that a simulator needs.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "assur/backend.hpp"
#include "assur/performance.hpp"
#include "assur/scene.hpp"
#include "assur/strategy.hpp"
#include "assur/structure.hpp"

namespace assur {

struct Preparation;  // for use inside the library

// The solvers of a run: one choice for each class of a structure. At most Choice::threads packs of a class, at most
// level_threads packs of a level, and never more than run.threads packs are solved at once.
struct Plan {
  // The solver of one class.
  struct Choice {
    std::int32_t group_class = 0;   // class of groups, see Group
    Shape shape;                    // size of the class
    SolverSettings solver;          // backend, lanes and policies
    std::int32_t threads = 1;       // packs (groups in SIMD lanes) of this class that are solved at once
    std::string reason;             // "forced", "interpolated: 2.1 times as fast as klu", ...
    double expected_seconds = 0;    // time of one step of one pack; 0: not predicted
    Origin origin = Origin::prior;  // evidence for the expected time
  };
  RunSettings run;                          // for all groups; the predictor is never automatic
  std::int32_t lanes = 1;                   // W of ensembles and chunks: mechanisms that run side by side
  std::vector<Choice> choices;              // one for each class, in their order
  std::vector<std::int32_t> level_threads;  // threads of each level, at most run.threads; empty: run.threads for all
  double accuracy = 0;                      // PrepareOptions::accuracy
  std::string reason;                       // reason for the formulation and for P
  double expected_seconds = 0;  // one step: groups, laws, prediction, outputs, without storing; 0: not predicted
  double meeting_seconds = 0;   // one start and meeting of the threads, a part of expected_seconds; 0: not predicted

  // The strategy of one class. Its text, given to prepare(), forces this solver for all classes.
  [[nodiscard]] Strategy strategy(const Choice& choice) const;
};

// Steps with a larger estimated error are `inaccurate` if no accuracy is required.
inline constexpr double kDoubtfulError = 1e-6;

// Optimisation goal of a plan.
enum class Mode : std::uint8_t {
  latency,     // a short time for each step of one mechanism
  throughput,  // many steps per second: members of an Ensemble, or chunks of the time grid, side by side
};

// Options of prepare().
struct PrepareOptions {
  std::string strategy = "auto";  // "auto", or a strategy text that is used for all classes
  // Names of drivers that the program sets with Simulator::set(); "pose", not "pose.x". Each driver, or each value of a
  // pose, follows its law until its own first set().
  std::vector<std::string> controlled = {};
  // Largest number of threads; it may exceed the number of cores. Empty: this_machine().budget(). Asking the machine
  // takes time: give a budget if you prepare many scenes.
  std::optional<ThreadBudget> budget = std::nullopt;
  // Goal of `auto`. For throughput, `auto` fills the lanes and all threads of the budget. A strategy text without
  // +chunks then gets as many chunks as fill its lanes and threads.
  Mode mode = Mode::latency;
  // The model that `auto` decides by; null: machine_model(). A model without samples decides by operation counts. With
  // a strategy text, the plan has expected times only if a model is given.
  std::shared_ptr<const PerformanceModel> model = nullptr;
  std::vector<std::string> without = {};  // ids of backends that must not be used
  // Largest forward error (ErrorFigures) that any output may have, e.g. 1e-8; a larger value may save time. 0: as exact
  // as doubles allow. Steps with a larger estimated error carry Code::inaccurate; with 0, those above kDoubtfulError.
  double accuracy = 0;
  // False: without the machine code that the backend `lanes` makes when a simulator is made (docs/strategies.md).
  // Results have the same bits. load_plan() does without.
  bool machine_code = true;
};

// A scene that is ready to run, as prepare() or load_plan() returns it. Copies, and any number of simulators, share its
// parts, which do not change. References that its functions return are valid as long as one of them.
class Prepared {
 public:
  // Name of the scene.
  [[nodiscard]] const std::string& name() const;
  // The scene; null if load_plan() made this.
  [[nodiscard]] const Scene* scene() const;
  // Time grid of the scene, the default of a run.
  [[nodiscard]] const TimeGrid& time() const;
  // Groups, their order, and findings.
  [[nodiscard]] Structure structure() const;
  // Solvers and threads.
  [[nodiscard]] const Plan& plan() const;
  // Names of the controlled drivers, PrepareOptions::controlled.
  [[nodiscard]] const std::vector<std::string>& controlled() const;

  // The same with another end or step of the time grid. Throws Error (input) for another start, because the start
  // posture is that of the start time, and for a grid without a whole number of steps.
  [[nodiscard]] Prepared with_time(const TimeGrid& time) const;

 private:
  friend struct Preparation;  // for use inside the library
  explicit Prepared(std::shared_ptr<const Preparation> parts) : parts_(std::move(parts)) {}
  std::shared_ptr<const Preparation> parts_;
};

// Analyses the scene, assembles its start posture and makes a plan. Several threads may prepare scenes at once. Needs
// the library assur::assur. Throws Error: input if the scene is undetermined (the free unknowns are named), if
// functions of the program return wrong derivatives (docs/accuracy.md), or for a wrong option: a strategy
// text that does not parse, an unknown backend or driver, a budget without a thread, a negative accuracy; numerical if
// the start posture cannot be assembled (the group and its most violated constraint are named); environment if the
// strategy text cannot run here, with the reason.
[[nodiscard]] Prepared prepare(const Scene& scene, const PrepareOptions& options = {});

// As prepare(), with the plan of `like` if the scene has the same structure, so that nothing needs to be chosen: for
// many variants of one scene, which `auto` takes several times as long to prepare. Without effect for scenes with
// callbacks or gears. Options that belong to the choice have no effect if the plan of `like` is taken.
[[nodiscard]] Prepared prepare_like(const Prepared& like, const Scene& scene, const PrepareOptions& options = {});

// A strategy with its expected time.
struct Candidate {
  Strategy strategy;  // the strategy
  // s, for all shape.groups together: one step with all derivatives that are needed, or the factorisations of all
  // matrices and their solutions
  double expected_seconds = 0;
  double factor = 1;              // with probability 2/3 the time is within this factor of expected_seconds
  Origin origin = Origin::prior;  // evidence for the expected time
  std::string why_not;            // reason why it cannot run here, or backward error above 1e-12; "": it can be used
};

// Options of candidates() and choose_solver().
struct CandidateOptions {
  std::shared_ptr<const PerformanceModel> model = nullptr;  // null: machine_model()
  std::optional<ThreadBudget> budget = std::nullopt;        // empty: that of this machine
  std::vector<std::string> without = {};                    // ids of backends that must not be used
};

// All candidates for shape.groups groups of one class, solved at the same time: the fastest first, and those that
// cannot run last. Plan::Choice::shape is the shape of a class of groups. If shape.terms is 0, the groups are bare
// matrices: each one is factorised once and solved with shape.rhs right-hand sides. In mode latency, `auto` without a
// required accuracy takes the first candidate; among candidates within 2 % of the fastest, the one with the fewest
// threads comes first. Throws Error (input) if `without` names an unknown backend. Needs the library assur::assur.
[[nodiscard]] std::vector<Candidate> candidates(const Shape& shape, const CandidateOptions& options = {});

// Chooses a solver for systems of your own: `count` matrices with one pattern, each factorised once and solved with
// `rhs` right-hand sides. Returns the first of candidates() that factorises in double: strategy.solver has the backend,
// W and the threads Q for Backend::make(), and strategy.run.threads is P, the packs to solve at once. Throws Error:
// input for fewer than one matrix or a negative number of right-hand sides, environment if no backend can run. Needs
// the library assur::assur.
[[nodiscard]] Candidate choose_solver(const Pattern& pattern, std::int32_t count, std::int32_t rhs = 1,
                                      const CandidateOptions& options = {});

}  // namespace assur
