// What is known about the machine -> a strategy for each class and threads for each level.
#pragma once

#include "assur/plan.hpp"
#include "planning/candidates.hpp"

namespace assur {

struct Task {
  Mode mode = Mode::latency;
  std::int32_t threads = 1;  // to use at most
};

// The plan of a structure with the strategies that are expected to be the fastest; predictor and chunks are the
// caller's. The same structure, model and task give the same plan. Throws Error (environment) if no backend can solve
// some class.
[[nodiscard]] Plan dispatch(const Structure& structure, const Task& task, const Scales& scales);

// Shape of every class, everything counted, in the order of the classes.
[[nodiscard]] std::vector<Shape> class_shapes(const Structure& structure);

// What a step of a plan is expected to take beside the solution of its groups, s.
struct BesideGroups {
  double around = 0;   // laws, predictions and outputs: part of Plan::expected_seconds
  double storing = 0;  // a row of outputs, where a run keeps them: no part of it
  std::int64_t outputs = 0;
  std::int64_t unknowns = 0, pieces = 0;  // that `around` is counted by, as PerformanceModel::around() takes them
};
[[nodiscard]] BesideGroups beside_groups(const Structure& structure, const PerformanceModel& model,
                                         std::int32_t threads);

// Fills what a plan expects of its strategies, whoever chose them.
void expect(Plan& plan, const Structure& structure, const PerformanceModel& model);

}  // namespace assur
