// Questions to the dispatcher about mechanisms that no tuner has seen, and what their answers say together.
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "measure/regret_question.hpp"

namespace assur::measure {

// Sizes off the grid of the tuner, odd counts of groups, mixed classes; each with all backends, without lanes, and, but
// for the largest, without lanes and klu, as users have them.
[[nodiscard]] std::vector<Question> regret_questions(int threads);

// The best strategy that is the same for all questions of one set of backends, which those ask who tune by hand: of
// those that ran in all of them that of the least mean regret.
struct Constant {
  std::string strategy;
  std::vector<double> regrets;  // one for each question of the set, in their order
};
[[nodiscard]] std::map<std::string, Constant> constants(
    std::span<const Answer> answers);  // by Question::without_text()

}  // namespace assur::measure
