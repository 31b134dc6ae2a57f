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

// The plan with the shortest expected time. The caller sets predictor and chunks. The same structure, model and task
// give the same plan. Throws Error (environment) if no backend can solve a class.
[[nodiscard]] Plan dispatch(const GroupedSystem& structure, const Task& task, const Scales& scales);

// Shape of every class with all counts, in the order of the classes.
[[nodiscard]] std::vector<Shape> class_shapes(const GroupedSystem& structure);

// Expected time of a step beyond the solution of its groups, s.
struct BesideGroups {
  double around = 0;   // laws, predictions and outputs: part of Plan::expected_seconds
  double storing = 0;  // storing a row of outputs; no part of Plan::expected_seconds
  std::int64_t outputs = 0;
  std::int64_t unknowns = 0, pieces = 0;  // arguments of PerformanceModel::around()
};
[[nodiscard]] BesideGroups beside_groups(const GroupedSystem& structure, const PerformanceModel& model,
                                         std::int32_t threads);

// Sets the expected times of a plan, also of a plan with forced strategies.
void expect(Plan& plan, const GroupedSystem& structure, const PerformanceModel& model);

}  // namespace assur
