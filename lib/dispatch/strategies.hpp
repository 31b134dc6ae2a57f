// The space of strategies. Only this file lists the sensible ways to solve.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "assur/backend.hpp"
#include "assur/strategy.hpp"
#include "structure/grouped_system.hpp"

namespace assur {

// Predictors of each kind; if a kind has many orders, a low, a middle and the highest one.
inline constexpr std::array kTypicalPredictors = {
    Predictor{Predictor::Kind::taylor, 0}, Predictor{Predictor::Kind::taylor, 1},
    Predictor{Predictor::Kind::taylor, 2}, Predictor{Predictor::Kind::hermite, 5},
    Predictor{Predictor::Kind::past, 1},   Predictor{Predictor::Kind::past, 3},
    Predictor{Predictor::Kind::past, 5}};

// A space: all combinations of these values.
struct StrategySpace {
  std::vector<Formulation> formulations = {RunSettings{}.formulation};
  std::vector<std::int32_t> packs = {1};    // P: packs at once
  std::vector<std::int32_t> lanes = {1};    // W
  std::vector<std::int32_t> threads = {1};  // Q, inside the linear algebra
  std::vector<SolverSettings> policies = {
      {}};  // precision, refinement, reuse, factorisations; other members are ignored
  std::vector<Predictor> predictors = {{}};
  bool together = false;  // each strategy also with +together, if its settings allow it
};

// The formulations that differ for a scene, the irreducible one first. Without declared groups, `groups` differs if
// linear equations were eliminated.
[[nodiscard]] std::vector<Formulation> formulations_of(const GroupedSystem& irreducible);

// Selection of strategies.
struct StrategyFilter {
  std::span<const Backend> table;
  Shape shape = {};  // shape of the groups; n = 0: any shape
  std::span<const std::string> without = {};
  // True for strategies that are wanted; empty: all.
  std::function<bool(const Backend&, const Strategy&)> wanted = {};
};

// 1, 2, 4, ... up to `most`, which is at least 1.
[[nodiscard]] std::vector<std::int32_t> powers_of_two(std::int32_t most);

// The strategies of a space that can run: for each backend of the table, in the order of the members of the space, with
// predictors varying fastest. Strategies that only repeat another one are left out: several lanes or packs for the
// single group of `global`, threads within several lanes, several packs with a backend that takes turns.
[[nodiscard]] std::vector<Strategy> strategies(const StrategySpace& space, const StrategyFilter& filter);

}  // namespace assur
