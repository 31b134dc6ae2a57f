// The dispatcher: chooses a strategy for each class and threads for each level, by the performance model.
#pragma once

#include "assur/plan.hpp"
#include "dispatch/candidates.hpp"

namespace assur {

// Goal of the plan.
struct Task {
  Mode mode = Mode::latency;
  std::int32_t threads = 1;  // largest number of threads
};

struct Dispatched {
  Plan plan;
  double modelled_seconds = 0;  // of a step, composed of its parts
  bool is_measured = false;     // true: Plan::expected_seconds follows from whole steps of this mechanism
};

// The plan with the shortest expected time. Measured times of whole steps count more than those that are composed. The
// caller sets predictor and chunks. The same structure, model and task give the same plan. Throws Error (environment)
// if no backend can solve a class.
[[nodiscard]] Dispatched dispatch(const GroupedSystem& structure, const Task& task, const Scales& scales);

// The plan that solves all classes by one strategy, without lanes that would stay empty. shapes: of the classes
[[nodiscard]] Plan uniform_plan(const Strategy& strategy, const GroupedSystem& structure,
                                const std::vector<Shape>& shapes);

// Expected time of a step beyond the solution of its groups, s.
struct BesideGroups {
  double around = 0;   // laws, predictions and outputs: part of Plan::expected_seconds
  double storing = 0;  // storing a row of outputs; no part of Plan::expected_seconds
  std::int64_t outputs = 0;
};
[[nodiscard]] BesideGroups beside_groups(const GroupedSystem& structure, const PerformanceModel& model,
                                         std::int32_t threads);

// Sets the expected times of a plan whose solvers are given, and the threads of its levels.
void expect(Plan& plan, const GroupedSystem& structure, Mode mode, const PerformanceModel& model);

}  // namespace assur
