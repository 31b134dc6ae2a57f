// Regret of the dispatcher on mechanisms that the tuner did not measure: its choice is compared with the best of all
// candidates, and with the best strategy that is the same for all mechanisms. Whole steps are timed, in turns;
// candidates with a wrong motion do not count. The first table is from one pass of the last races.
//
//   regret_bench [--quick] [--threads N] [--only TEXT] [--csv FILE]
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ostream>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "assur/assur.hpp"
#include "measure/pace.hpp"
#include "median.hpp"
#include "output/csv_text.hpp"
#include "survey.hpp"
#include "tuning/regret_survey.hpp"

namespace assur::bench {
namespace {

using tuning::Answer;
using tuning::Contest;
using tuning::Question;

constexpr double kLook = 1;        // s, at the usual pace
constexpr std::size_t kQuick = 9;  // questions of each kind with --quick

// TEXT of --only may be in a question or in the title of its list.
std::vector<Question> chosen_from(std::vector<Question> all, const std::string& title, const Survey& survey) {
  if (!survey.wants(title)) std::erase_if(all, [&](const Question& q) { return !survey.wants(q.text()); });
  if (!survey.quick || all.size() <= kQuick) return all;
  std::vector<Question> some;
  for (std::size_t i = 0; i < all.size(); i += all.size() / kQuick) some.push_back(all[i]);
  return some;
}

void print(const Answer& a) {
  std::printf("%-40s %9.2f us %7.2f %7.1f %% %7.1f %% %7.1f %%   %-34s %s\n", a.question.text().c_str(),
              a.chosen.seconds * 1e6, a.chosen.seconds / a.expected_seconds, 100 * a.regret(),
              100 * a.regret_to_itself(), 100 * (a.chosen.seconds / a.untuned.seconds - 1), a.chosen.strategy.c_str(),
              a.regret() > 0.005 ? a.best.strategy.c_str() : "");
  std::fflush(stdout);
}

void write_csv(std::ostream& out, const std::vector<Answer>& answers) {
  using output::csv_text;
  for (const Answer& a : answers) {
    out << csv_text(a.question.text()) << ',' << a.question.threads << ',' << csv_text(a.chosen.strategy) << ','
        << a.chosen.seconds << ',' << a.again.seconds << ',' << a.expected_seconds << ','
        << csv_text(a.untuned.strategy) << ',' << a.untuned.seconds << ',' << csv_text(a.best.strategy) << ','
        << a.best.seconds << ',' << a.regret() << '\n';
  }
}

// Share of the questions whose time is within a factor of the expected one, %.
double within(double factor, const std::vector<double>& log_ratios) {
  const auto good =
      std::count_if(log_ratios.begin(), log_ratios.end(), [&](double r) { return r <= std::log(factor); });
  return 100 * static_cast<double>(good) / static_cast<double>(log_ratios.size());
}

void summarise(const std::vector<Answer>& answers) {
  std::vector<double> ours, untuned, theirs, itself, ratio;
  std::set<std::string> winners;
  for (const Answer& a : answers) {
    ours.push_back(a.regret());
    untuned.push_back(a.untuned.seconds / a.best.seconds - 1);
    itself.push_back(a.regret_to_itself());
    ratio.push_back(std::abs(std::log(a.chosen.seconds / a.expected_seconds)));
    winners.insert(a.best.strategy);
  }
  std::printf("\n%zu questions, %zu different strategies win somewhere\n", answers.size(), winners.size());
  for (const auto& [set, constant] : tuning::constants(answers)) {
    std::printf("best constant strategy, %s: %s, mean regret %.1f %%, max %.0f %%\n",
                set.empty() ? "all backends" : set.c_str(), constant.strategy.c_str(), 100 * mean(constant.regrets),
                100 * quantile(constant.regrets, 1));
    theirs.insert(theirs.end(), constant.regrets.begin(), constant.regrets.end());
  }
  std::printf("regret, %%         median      p95      max     mean\n");
  const auto line = [](const char* who, const std::vector<double>& r) {
    if (r.empty()) return;
    std::printf("%-18s %5.1f %8.1f %8.1f %8.1f\n", who, 100 * quantile(r, 0.5), 100 * quantile(r, 0.95),
                100 * quantile(r, 1), 100 * mean(r));
  };
  line("dispatcher", ours);
  line("untuned", untuned);
  line("constant", theirs);
  line("choice to itself", itself);
  std::printf("time of the choice over its expected time: %.0f %% within 1.5, %.0f %% within 2, largest factor %.1f\n",
              within(1.5, ratio), within(2, ratio), std::exp(quantile(ratio, 1)));
}

void answer(const std::vector<Question>& questions, const Survey& survey, measure::MachinePace& pace,
            std::ostream& csv) {
  tuning::QuestionOptions how{.model = survey.model, .quick = survey.quick};
  pace.attach(how.instruments);
  std::vector<Contest> contests;
  for (const Question& q : questions) {
    try {
      auto contest = Contest::open(q, how);
      if (!contest || !contest->race()) continue;
      contests.push_back(std::move(*contest));
      print(contests.back().answer());
    } catch (const Error& error) {
      std::printf("%-40s %s\n", q.text().c_str(), error.what());
    }
  }
  for (int pass = 1; pass < tuning::kPasses; ++pass) {
    for (Contest& c : contests) (void)c.race();
  }
  if (contests.empty()) return;
  std::printf("\nafter %d passes, minutes apart\n", tuning::kPasses);
  std::vector<Answer> answers;
  for (const Contest& c : contests) {
    answers.push_back(c.answer());
    print(answers.back());
  }
  summarise(answers);
  write_csv(csv, answers);
}

void run(const Survey& survey, std::ostream& csv) {
  csv << "question,threads,chosen,chosen_seconds,again_seconds,expected_seconds,untuned,untuned_seconds,best,"
         "best_seconds,regret\n";
  measure::MachinePace pace(survey.threads, kLook);
  for (const auto& [title, questions] :
       {std::pair{"Sizes between those of the tuner", tuning::regret_questions(survey.threads)},
        std::pair{"Mechanisms that the tuner does not have", tuning::unlike_questions(survey.threads)}}) {
    std::printf("\n%s\n%-40s %12s %7s %9s %9s %9s   %-34s %s\n", title, "question", "chosen", "/expect", "regret",
                "to itself", "untuned", "chosen", "best");
    answer(chosen_from(questions, title, survey), survey, pace, csv);
  }
}

}  // namespace
}  // namespace assur::bench

int main(int argc, char** argv) {
  return assur::bench::run_survey(argc, argv, "Regret of the dispatcher against the best of all candidates.",
                                  assur::bench::run);
}
