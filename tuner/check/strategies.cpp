#include "check/strategies.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include "assur/backend.hpp"
#include "assur/plan.hpp"
#include "assur/structure.hpp"
#include "output/format.hpp"

namespace assur::check {
namespace {

constexpr int kLanes = 8;
constexpr std::array kPolicies = {"", "+once", "+refine", "+reuse=step", "+reuse=run"};
constexpr std::array kPredictors = {"taylor:0", "taylor:1", "taylor:2", "hermite:5", "past:0", "past:3", "past:5"};

// What a formulation asks of a backend.
struct Demand {
  std::vector<Shape> shapes;  // classes
  int side_by_side = 1;       // most groups of a class on one level
  std::int32_t largest = 0;   // unknowns
};

Demand demand_of(const Scene& scene, Formulation formulation) {
  StructureOptions options;
  options.formulation = formulation;
  options.predictor_derivatives = 2;
  const Structure s = analyze(scene, options);
  Demand demand;
  std::map<std::pair<std::int32_t, std::int32_t>, int> on_level;
  std::vector<std::int32_t> groups(s.classes.size(), 0);
  for (const Group& g : s.groups) {
    demand.side_by_side = std::max(demand.side_by_side, ++on_level[{g.level, g.group_class}]);
    ++groups[static_cast<std::size_t>(g.group_class)];
  }
  for (std::size_t c = 0; c < s.classes.size(); ++c) {
    const Pattern pattern = s.pattern(static_cast<std::int32_t>(c));
    demand.shapes.push_back({.n = pattern.n, .nnz = pattern.nnz(), .groups = groups[c], .rhs = 3});
    demand.largest = std::max(demand.largest, pattern.n);
  }
  return demand;
}

// Of one step, by counts; infinite if the backend is none of the candidates.
double seconds_of(const Demand& demand, std::string_view backend) {
  static const auto kNothingKnown = std::make_shared<const PerformanceModel>();
  double sum = 0;
  for (const Shape& shape : demand.shapes) {
    double least = HUGE_VAL;
    for (const Candidate& c : candidates(shape, {.model = kNothingKnown, .budget = ThreadBudget{1}, .without = {}})) {
      if (c.strategy.solver.backend == backend && c.why_not.empty()) least = std::min(least, c.expected_seconds);
    }
    sum += least;
  }
  return sum;
}

class Selector {
 public:
  Selector(double seconds, std::int64_t steps, bool quick) : seconds_(seconds), steps_(steps), quick_(quick) {}

  void formulation(Formulation f, const Demand& demand) {
    const std::string front = std::string(name(f)) + "/";
    std::vector<std::string> hopeless;
    bool first = true;
    double worst = 0;
    for (const Backend& backend : backends()) {
      const Shape shape{.n = demand.largest};
      if (!backend.why_not(shape, ThreadBudget{1}).empty()) continue;
      const double takes = seconds_of(demand, backend.id) * static_cast<double>(steps_ + 1);
      if (takes > seconds_) {
        hopeless.emplace_back(backend.id);
        worst = std::max(worst, takes);
        continue;
      }
      one_backend(front + std::string(backend.id), backend, demand, std::exchange(first, false));
    }
    if (hopeless.empty()) return;
    out_.left_out.push_back(output::listed(hopeless) + " in " + std::string(name(f)) + ": hopeless, up to some " +
                            output::duration(worst) + " for each run");
  }

  [[nodiscard]] Selection take() { return std::move(out_); }

 private:
  void one_backend(const std::string& front, const Backend& backend, const Demand& demand, bool first) {
    std::vector<std::string> lanes = {""};
    if (demand.side_by_side > 1 && (!quick_ || backend.fills_lanes)) lanes.push_back(":" + std::to_string(kLanes));
    for (const std::string& w : lanes) {
      for (const char* precision : {"", "+float"}) {
        if (*precision != '\0' && !backend.single) continue;
        for (const char* policy : kPolicies) {
          if (*policy == '\0' || !quick_ || (first && *precision == '\0' && w.empty())) {
            out_.strategies.push_back(front + w + precision + policy);
          }
        }
      }
    }
    if (!first) return;
    for (const char* predictor : kPredictors) out_.strategies.push_back(front + "+predict=" + predictor);
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
    // Without declared groups these are the irreducible ones, but for the equations that are eliminated.
    if (quick && f == Formulation::groups && formulations.size() == 3) continue;
    selector.formulation(f, demand_of(scene, f));
  }
  return selector.take();
}

}  // namespace assur::check
