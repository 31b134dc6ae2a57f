// The space of strategies: every way to solve that means something, listed here and nowhere else.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "assur/backend.hpp"
#include "assur/strategy.hpp"

namespace assur {

// Of each kind and, where there are many, a low, a middle and the highest order.
inline constexpr std::array kTypicalPredictors = {
    Predictor{Predictor::Kind::taylor, 0}, Predictor{Predictor::Kind::taylor, 1},
    Predictor{Predictor::Kind::taylor, 2}, Predictor{Predictor::Kind::hermite, 5},
    Predictor{Predictor::Kind::past, 1},   Predictor{Predictor::Kind::past, 3},
    Predictor{Predictor::Kind::past, 5}};

// What may vary, each with every other.
struct StrategySpace {
  std::vector<Formulation> formulations = {RunSettings{}.formulation};
  std::vector<std::int32_t> packs = {1};        // P, at once
  std::vector<std::int32_t> lanes = {1};        // W
  std::vector<std::int32_t> threads = {1};      // Q, inside the linear algebra
  std::vector<SolverSettings> policies = {{}};  // precision, refinement, reuse, factorisations; the rest is not read
  std::vector<Predictor> predictors = {{}};
};

struct StrategyFilter {
  std::span<const Backend> table;
  Shape shape = {};  // of the groups to be solved; n = 0: of any
  std::span<const std::string> without = {};
  // Which of those that can run are wanted; empty: all.
  std::function<bool(const Backend&, const Strategy&)> wanted = {};
};

// 1, 2, 4, ... up to `most`, which is at least 1.
[[nodiscard]] std::vector<std::int32_t> powers_of_two(std::int32_t most);

// The strategies of a space that can run: each backend of the table in turn, then as the members of the space are
// ordered, predictors fastest. Not among them is what would only repeat another: lanes or packs at once of the single
// group of `global`, threads inside several lanes, packs at once where a backend takes turns.
[[nodiscard]] std::vector<Strategy> strategies(const StrategySpace& space, const StrategyFilter& filter);

}  // namespace assur
