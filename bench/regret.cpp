// Regret of the dispatcher on mechanisms that the tuner did not measure: its choice is compared with the best of all
// candidates, and with the best strategy that is the same for all mechanisms. Whole steps are timed, in turns;
// candidates with a wrong motion do not count. The first table is from one pass of the last races.
//
//   regret_bench [--quick] [--threads N] [--only TEXT] [--csv FILE]
#include <cmath>
#include <cstdio>
#include <ostream>
#include <set>
#include <string>
#include <vector>

#include "assur/assur.hpp"
#include "measure/pace.hpp"
#include "measure/regret_survey.hpp"
#include "median.hpp"
#include "output/csv_text.hpp"
#include "survey.hpp"

namespace assur::bench {
namespace {

using measure::Answer;
using measure::Contest;
using measure::Question;

constexpr double kLook = 1;  // s, at the usual pace

std::vector<Question> questions(const Survey& survey) {
  std::vector<Question> all = measure::regret_questions(survey.threads);
  std::erase_if(all, [&](const Question& q) { return !survey.wants(q.scene); });
  if (!survey.quick || all.size() <= 9) return all;
  std::vector<Question> some;
  for (std::size_t i = 0; i < all.size(); i += all.size() / 9) some.push_back(all[i]);
  return some;
}

void print(const Answer& a) {
  std::printf("%-22s %-10s %9.2f us %7.1f %% %7.1f %%   %-34s %s\n", a.question.scene.c_str(),
              a.question.without_text().c_str(), a.chosen.seconds * 1e6, 100 * a.regret(), 100 * a.regret_to_itself(),
              a.chosen.strategy.c_str(), a.regret() > 0.005 ? a.best.strategy.c_str() : "");
  std::fflush(stdout);
}

void write_csv(std::ostream& out, const std::vector<Answer>& answers) {
  using output::csv_text;
  out << "scene,without,threads,chosen,chosen_seconds,again_seconds,expected_seconds,best,best_seconds,regret\n";
  for (const Answer& a : answers) {
    out << csv_text(a.question.scene) << ',' << csv_text(a.question.without_text()) << ',' << a.question.threads << ','
        << csv_text(a.chosen.strategy) << ',' << a.chosen.seconds << ',' << a.again.seconds << ',' << a.expected_seconds
        << ',' << csv_text(a.best.strategy) << ',' << a.best.seconds << ',' << a.regret() << '\n';
  }
}

void summarise(const std::vector<Answer>& answers) {
  std::vector<double> ours, theirs, itself, ratio;
  std::set<std::string> winners;
  for (const Answer& a : answers) {
    ours.push_back(a.regret());
    itself.push_back(a.regret_to_itself());
    ratio.push_back(std::abs(std::log(a.chosen.seconds / a.expected_seconds)));
    winners.insert(a.best.strategy);
  }
  std::printf("\n%zu questions, %zu different strategies win somewhere\n", answers.size(), winners.size());
  for (const auto& [set, constant] : measure::constants(answers)) {
    std::printf("best constant strategy, %s: %s, mean regret %.1f %%, max %.0f %%\n",
                set.empty() ? "all backends" : set.c_str(), constant.strategy.c_str(), 100 * mean(constant.regrets),
                100 * quantile(constant.regrets, 1));
    theirs.insert(theirs.end(), constant.regrets.begin(), constant.regrets.end());
  }
  std::printf("regret, %%         median      p95      max     mean\n");
  const auto line = [](const char* who, const std::vector<double>& r) {
    std::printf("%-18s %5.1f %8.1f %8.1f %8.1f\n", who, 100 * quantile(r, 0.5), 100 * quantile(r, 0.95),
                100 * quantile(r, 1), 100 * mean(r));
  };
  line("dispatcher", ours);
  line("constant", theirs);
  line("choice to itself", itself);
  std::printf("expected against actual time of the choice: error %.0f %% (median)\n",
              100 * (std::exp(quantile(ratio, 0.5)) - 1));
}

void run(const Survey& survey, std::ostream& csv) {
  std::printf("\n%-22s %-10s %12s %9s %9s   %-34s %s\n", "scene", "without", "chosen", "regret", "to itself", "chosen",
              "best");
  measure::QuestionOptions how{.model = survey.model, .quick = survey.quick};
  measure::MachinePace pace(survey.threads, kLook);
  pace.attach(how.instruments);
  std::vector<Contest> contests;
  for (const Question& q : questions(survey)) {
    auto contest = Contest::open(q, how);
    if (!contest || !contest->race()) continue;
    contests.push_back(std::move(*contest));
    print(contests.back().answer());
  }
  for (int pass = 1; pass < measure::kPasses; ++pass) {
    for (Contest& c : contests) (void)c.race();
  }
  std::printf("\nafter %d passes, minutes apart\n", measure::kPasses);
  std::vector<Answer> answers;
  for (const Contest& c : contests) {
    answers.push_back(c.answer());
    print(answers.back());
  }
  summarise(answers);
  write_csv(csv, answers);
}

}  // namespace
}  // namespace assur::bench

int main(int argc, char** argv) {
  return assur::bench::run_survey(argc, argv, "Regret of the dispatcher against the best of all candidates.",
                                  assur::bench::run);
}
