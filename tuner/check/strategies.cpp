#include "check/strategies.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "assur/backend.hpp"
#include "dispatch/prior.hpp"
#include "dispatch/strategies.hpp"
#include "dispatch/together_rules.hpp"
#include "output/format.hpp"
#include "structure/grouped_system.hpp"

namespace assur::check {
namespace {

constexpr int kLanes = 8;
constexpr double kDeviceTime = 10;  // a GPU may take this many times as long: on small groups, launches take most of it

// All policies in double, then in float.
std::vector<SolverSettings> policies() {
  std::vector<SolverSettings> all;
  for (const bool single : {false, true}) {
    for (SolverSettings s : {SolverSettings{}, SolverSettings{.once = true}, SolverSettings{.refine = true},
                             SolverSettings{.reuse = Reuse::step}, SolverSettings{.reuse = Reuse::run}}) {
      s.single = single;
      all.push_back(s);
    }
  }
  return all;
}

// The demands of a formulation on a backend.
struct Demand {
  std::vector<Shape> shapes;  // classes
  int side_by_side = 1;       // most groups of a class on one level
  std::int32_t largest = 0;   // unknowns
  bool together = false;      // +together can solve the groups
};

Demand demand_of(const Scene& scene, Formulation formulation) {
  StructureOptions options;
  options.formulation = formulation;
  options.predictor_derivatives = 2;
  const GroupedSystem s = group_equations(scene, options);
  Demand demand;
  const std::vector<ClassSize> sizes = class_sizes(s);
  for (std::size_t c = 0; c < s.classes.size(); ++c) {
    const Pattern pattern = s.pattern(static_cast<std::int32_t>(c));
    demand.shapes.push_back({.n = pattern.n, .nnz = pattern.nnz(), .groups = sizes[c].groups, .rhs = 3});
    demand.side_by_side = std::max(demand.side_by_side, sizes[c].side_by_side);
    demand.largest = std::max(demand.largest, pattern.n);
  }
  demand.together = why_not_together(s).empty();
  return demand;
}

// Seconds of one step, by operation counts.
double seconds_of(const Demand& demand, const std::string& backend) {
  double sum = 0;
  for (const Shape& shape : demand.shapes) {
    double least = HUGE_VAL;
    for (const int lanes : {1, kLanes}) {
      const Strategy s{.run = {}, .solver = {.backend = backend, .lanes = lanes}};
      const double packs = std::ceil(static_cast<double>(shape.groups) / lanes);
      least = std::min(least, packs * (prior_seconds(Kernel::factor, shape, s) +
                                       shape.rhs * prior_seconds(Kernel::solve, shape, s)));
    }
    sum += least;
  }
  return sum;
}

class Selector {
 public:
  Selector(double seconds, std::int64_t steps, bool quick) : seconds_(seconds), steps_(steps), quick_(quick) {}

  void formulation(Formulation f, const Demand& demand) {
    StrategyFilter able{.table = backends(), .shape = {.n = demand.largest}};
    std::vector<std::string> hopeless;
    double worst = 0;
    for (const Strategy& s : strategies({}, able)) {
      const double takes = seconds_of(demand, s.solver.backend) * static_cast<double>(steps_ + 1);
      if (takes <= seconds_ * (find_backend(able.table, s.solver.backend).device ? kDeviceTime : 1)) continue;
      hopeless.push_back(s.solver.backend);
      worst = std::max(worst, takes);
    }
    able.without = hopeless;
    std::string first;
    StrategySpace space;
    space.formulations = {f};
    if (demand.side_by_side > 1 || demand.together) space.lanes = {1, kLanes};
    space.together = demand.together;
    space.policies = policies();
    able.wanted = [&](const Backend& backend, const Strategy& s) {
      if (first.empty()) first = backend.id;
      if (s.solver.lanes > 1 && !s.run.together && demand.side_by_side == 1) return false;
      const SolverSettings plain{.backend = s.solver.backend, .lanes = s.solver.lanes, .single = s.solver.single};
      const bool alone = first == backend.id && s.solver.lanes == 1 && !s.solver.single;
      return !quick_ || ((s.solver.lanes == 1 || backend.fills_lanes) && (s.solver == plain || alone));
    };
    enter(strategies(space, able));
    space.lanes = {1};
    space.policies = {{}};
    space.predictors.assign(kTypicalPredictors.begin(), kTypicalPredictors.end());
    able.wanted = [&](const Backend& backend, const Strategy&) { return first == backend.id; };
    enter(strategies(space, able));
    if (hopeless.empty()) return;
    out_.left_out.push_back(output::listed(hopeless) + " in " + std::string(name(f)) + ": too slow, up to about " +
                            output::duration(worst) + " for each run");
  }

  [[nodiscard]] Selection take() { return std::move(out_); }

 private:
  void enter(const std::vector<Strategy>& strategies) {
    for (const Strategy& s : strategies) out_.strategies.push_back(to_string(s));
  }

  double seconds_;
  std::int64_t steps_;
  bool quick_;
  Selection out_;
};

}  // namespace

Selection select_strategies(const Case& c, const Scene& scene, double seconds, bool quick) {
  if (!c.strategies.empty()) return {c.strategies, {}};
  std::vector<Formulation> formulations = c.formulations;
  if (formulations.empty()) formulations = {Formulation::global, Formulation::groups, Formulation::irreducible};
  Selector selector(seconds, scene.time().steps(), quick);
  for (const Formulation f : formulations) {
    // Without declared groups, `groups` has the irreducible ones before elimination, so the quick selection skips it.
    if (quick && f == Formulation::groups && formulations.size() == 3) continue;
    selector.formulation(f, demand_of(scene, f));
  }
  return selector.take();
}

}  // namespace assur::check
