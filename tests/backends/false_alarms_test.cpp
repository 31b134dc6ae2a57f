// Checks cause few false alarms: of 100,000 regular matrices, hardly a lane is refused, factorised again or repeated in
// double.
#include <gtest/gtest.h>

#include <iostream>

#include "assur/backend.hpp"
#include "backends/available.hpp"
#include "backends/matrices.hpp"
#include "backends/refined.hpp"

namespace assur::test {
namespace {

constexpr int kMatrices = 100000;

// Matrices like the Jacobians of a motion: pattern and large pivots are constant, all else is random. Conditions are
// below 100, so that neither small pivots nor float justify an alarm.
struct Alarms {
  int matrices = 0, refused = 0;
  std::int64_t again = 0;
};

Alarms count_alarms(const Backend& backend, Precision precision, int matrices) {
  Alarms alarms;
  Random random(17);
  for (int n = 3; alarms.matrices < matrices; n = n == 15 ? 3 : n + 1) {
    for (int lanes : {1, 2, 4, 8, 16}) {
      const auto solver = make_solver(backend, {}, precision, false);
      EXPECT_TRUE(solver->analyze(sparse(n, 2, random).pattern, lanes).ok());
      std::vector<double> b(static_cast<std::size_t>(n * lanes), 1.0);
      for (int step = 0; step < 40; ++step) {
        std::vector<std::vector<double>> values;
        for (int lane = 0; lane < lanes; ++lane) values.push_back(sparse(n, 2, random).values);
        const bool factorized = solver->factorize(interleave(values)).ok();
        const bool solved = solver->solve(b, 1, Transpose::no, 0).ok();
        for (int lane = 0; lane < lanes; ++lane) alarms.refused += !solver->figures(lane).ok;
        alarms.refused += factorized && !solved;
        alarms.matrices += lanes;
        std::fill(b.begin(), b.end(), 1.0);
      }
      const Effort effort = solver->effort();
      alarms.again += effort.redone + effort.renewed + effort.in_double;
    }
  }
  return alarms;
}

class FalseAlarms : public testing::TestWithParam<const Backend*> {};

TEST_P(FalseAlarms, AreRare) {
  const Backend& backend = *GetParam();
  for (Precision precision : {Precision::binary64, Precision::binary32}) {
    if (precision == Precision::binary32 && !backend.single) continue;
    const Alarms alarms = count_alarms(backend, precision, kMatrices);
    EXPECT_GE(alarms.matrices, kMatrices);
    EXPECT_EQ(alarms.refused, 0);
    EXPECT_LE(static_cast<double>(alarms.again), 0.01 * alarms.matrices);
    std::cout << backend.id << (precision == Precision::binary32 ? "+float" : "") << ": " << alarms.again
              << " again of " << alarms.matrices << "\n";
  }
}

// The backends that allocate nothing in the steady state.
std::vector<const Backend*> steady() {
  std::vector<const Backend*> rows;
  for (const Backend* backend : available()) {
    if (backend->steady) rows.push_back(backend);
  }
  return rows;
}

INSTANTIATE_TEST_SUITE_P(Backends, FalseAlarms, testing::ValuesIn(steady()),
                         [](const auto& row) { return std::string(row.param->id); });

}  // namespace
}  // namespace assur::test
