// The regret of the dispatcher over many mechanisms that were not tuned for.
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "tuning/regret_question.hpp"

namespace assur::tuning {

// Questions with sizes between those of the tuner, odd numbers of groups, and mixed classes. Each question has three
// versions: with all backends, without `lanes`, and (except for the largest mechanisms) without `lanes` and `klu`.
[[nodiscard]] std::vector<Question> regret_questions(int threads);

// Mechanisms as people bring them, none of which the tuner measures: those that come with assur, with joints, gears,
// limits and redundant equations; many small groups; few and many outputs, inexact motions, and both modes.
[[nodiscard]] std::vector<Question> unlike_questions(int threads);

// The best constant strategy for all questions of one set of backends, as a user would choose it by hand: the strategy
// with the smallest mean regret among those that ran in all questions.
struct Constant {
  std::string strategy;
  std::vector<double> regrets;  // one for each question of the set, in their order
};
[[nodiscard]] std::map<std::string, Constant> constants(
    std::span<const Answer> answers);  // by Question::without_text()

}  // namespace assur::tuning
