// Two runs with different numbers of threads are bitwise equal.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <string>

#include "simulation/run.hpp"

namespace assur::test {

inline bool same_bits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

inline void expect_same_counters(const Counters& a, const Counters& b) {
  EXPECT_EQ(a.steps, b.steps);
  EXPECT_EQ(a.substeps, b.substeps);
  EXPECT_EQ(a.rejected, b.rejected);
  EXPECT_EQ(a.group_solutions, b.group_solutions);
  EXPECT_EQ(a.newton_iterations, b.newton_iterations);
  EXPECT_EQ(a.most_iterations, b.most_iterations);
  EXPECT_EQ(a.evaluated_equations, b.evaluated_equations);
  EXPECT_EQ(a.factorizations, b.factorizations);
  EXPECT_EQ(a.factorized_unknowns, b.factorized_unknowns);
  EXPECT_EQ(a.solved_unknowns, b.solved_unknowns);
  EXPECT_EQ(a.branch_checks, b.branch_checks);
  EXPECT_EQ(a.stored_values, b.stored_values);
}

inline void expect_same_report(const Report& a, const Report& b) {
  expect_same_counters(a.counters, b.counters);
  EXPECT_EQ(a.effort.redone, b.effort.redone);
  EXPECT_EQ(a.effort.renewed, b.effort.renewed);
  EXPECT_EQ(a.effort.refined, b.effort.refined);
  EXPECT_EQ(a.effort.in_double, b.effort.in_double);
  // The search for the worst residual compares rounded numbers, so that its last bits depend on the order.
  for (const auto figure : {&ErrorFigures::position, &ErrorFigures::velocity, &ErrorFigures::acceleration}) {
    EXPECT_EQ(std::isnan(a.error.*figure), std::isnan(b.error.*figure));
    if (!std::isnan(a.error.*figure)) {
      EXPECT_DOUBLE_EQ(a.error.*figure, b.error.*figure);
    }
  }
  EXPECT_EQ(a.status.code, b.status.code);
  EXPECT_EQ(a.status.where, b.status.where);
  EXPECT_TRUE(same_bits(a.status.figure, b.status.figure));
  EXPECT_EQ(a.reached, b.reached);
  EXPECT_EQ(a.fallbacks, b.fallbacks);
  ASSERT_EQ(a.events.size(), b.events.size());
  for (std::size_t i = 0; i < a.events.size(); ++i) {
    EXPECT_EQ(a.events[i].kind, b.events[i].kind);
    EXPECT_EQ(a.events[i].group, b.events[i].group);
    EXPECT_EQ(a.events[i].time, b.events[i].time);
    EXPECT_EQ(a.events[i].until, b.events[i].until);
    EXPECT_TRUE(same_bits(a.events[i].figure, b.events[i].figure));
  }
}

inline void expect_same_rows(const Trajectory& a, const Trajectory& b) {
  EXPECT_EQ(a.columns(), b.columns());
  ASSERT_EQ(a.times(), b.times());
  ASSERT_EQ(a.values().size(), b.values().size());
  for (std::size_t i = 0; i < a.values().size(); ++i) {
    ASSERT_TRUE(same_bits(a.values()[i], b.values()[i]))
        << a.columns()[i % a.columns().size()] << " in row " << i / a.columns().size();
  }
}

inline void expect_same_run(const Result& a, const Result& b) {
  expect_same_rows(a.trajectory, b.trajectory);
  expect_same_report(a.report(), b.report());
}

// Rows and report by machine code and without it. Returns the report.
inline Report expect_same_by_code(const Scene& scene, const std::string& strategy, const StepSettings& settings = {}) {
  PrepareOptions by_code{.strategy = strategy}, without = by_code;
  without.machine_code = false;
  Simulator a(prepare(scene, by_code), settings), b(prepare(scene, without), settings);
  expect_same_rows(a.run(), b.run());
  expect_same_report(a.report(), b.report());
  return a.report();
}

}  // namespace assur::test
