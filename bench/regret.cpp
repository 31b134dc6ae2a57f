// What the dispatcher loses: its choice against the best of all candidates, on mechanisms that no tuner has seen, and
// beside it the best strategy that is the same for all of them. Every time is of whole steps, measured in turns; a
// candidate whose motion is not right does not count.
//
//   regret_bench [--quick] [--threads N] [--only TEXT] [--csv FILE]
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "assur/assur.hpp"
#include "machine.hpp"
#include "regret_question.hpp"
#include "survey.hpp"

namespace assur::bench {
namespace {

// Sizes off the grid of the tuner, odd counts of groups, mixed classes; some with fewer backends, as users have them.
std::vector<Question> questions(const SurveyOptions& o, int budget) {
  static const std::vector<std::string> kScenes = {"four_bar:5",
                                                   "four_bar:11",
                                                   "four_bar:23",
                                                   "slider_crank",
                                                   "andrews",
                                                   "stewart",
                                                   "stewart:platforms=5",
                                                   "stewart:platforms=11",
                                                   "stewart:platforms=23",
                                                   "rings:legs=1,n=22",
                                                   "rings:legs=5,n=22",
                                                   "rings:legs=11,n=22",
                                                   "rings:legs=23,n=22",
                                                   "rings:legs=1,n=78",
                                                   "rings:legs=5,n=78",
                                                   "rings:legs=11,n=78",
                                                   "rings:legs=23,n=78",
                                                   "rings:legs=1,n=334",
                                                   "rings:legs=5,n=334",
                                                   "rings:legs=11,n=334",
                                                   "rings:legs=64,n=120",
                                                   "stewart:platforms=200"};
  static const std::vector<std::vector<std::string>> kWithout = {{}, {"lanes"}, {"lanes", "klu"}};
  std::vector<Question> all;
  for (const std::string& scene : kScenes) {
    if (scene.find(o.only) == std::string::npos) continue;
    for (const auto& without : kWithout) {
      // Dense solvers alone take their time.
      if (without.size() > 1 && (scene.find("n=334") != std::string::npos || scene.find("64") != std::string::npos)) {
        continue;
      }
      all.push_back({scene, without, budget});
    }
  }
  if (o.quick && all.size() > 9) {
    std::vector<Question> some;
    for (std::size_t i = 0; i < all.size(); i += all.size() / 9) some.push_back(all[i]);
    return some;
  }
  return all;
}

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1) + 0.5)];
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return values.empty() ? 0 : sum / static_cast<double>(values.size());
}

// For each set of backends the strategy with the least mean regret of those that ran in all its questions.
struct Constant {
  std::string strategy;
  std::vector<double> regrets;
};
std::map<std::string, Constant> constants(const std::vector<Answer>& answers) {
  std::map<std::string, std::map<std::string, std::vector<double>>> regrets;  // by set, strategy
  std::map<std::string, std::size_t> count;
  for (const Answer& a : answers) {
    const std::string set = a.question.without_text();
    ++count[set];
    for (const auto& [strategy, seconds] : a.uniform)
      regrets[set][strategy].push_back(seconds / a.best_trial_seconds - 1);
  }
  std::map<std::string, Constant> best;
  for (const auto& [set, by_strategy] : regrets) {
    for (const auto& [strategy, of_it] : by_strategy) {
      if (of_it.size() != count[set]) continue;
      Constant& c = best[set];
      if (c.strategy.empty() || mean(of_it) < mean(c.regrets)) c = {strategy, of_it};
    }
  }
  return best;
}

void print(const Answer& a) {
  std::printf("%-22s %-10s %9.2f us %7.1f %%   %-34s %s\n", a.question.scene.c_str(), a.question.without_text().c_str(),
              a.chosen_seconds * 1e6, 100 * a.regret(), a.chosen.c_str(), a.regret() > 0.005 ? a.best.c_str() : "");
  std::fflush(stdout);
}

void write_csv(std::ostream& out, const std::vector<Answer>& answers) {
  out << "scene,without,threads,chosen,chosen_seconds,expected_seconds,best,best_seconds,regret\n";
  for (const Answer& a : answers) {
    out << '"' << a.question.scene << "\",\"" << a.question.without_text() << "\"," << a.question.threads << ",\""
        << a.chosen << "\"," << a.chosen_seconds << ',' << a.expected_seconds << ",\"" << a.best << "\","
        << a.best_seconds << ',' << a.regret() << '\n';
  }
}

void summarise(const std::vector<Answer>& answers) {
  std::vector<double> ours, theirs, ratio;
  std::set<std::string> winners;
  for (const Answer& a : answers) {
    ours.push_back(a.regret());
    ratio.push_back(std::abs(std::log(a.chosen_seconds / a.expected_seconds)));
    winners.insert(a.best);
  }
  std::printf("\n%zu questions, %zu different strategies win somewhere\n", answers.size(), winners.size());
  for (const auto& [set, constant] : constants(answers)) {
    std::printf("best constant strategy, %s: %s, mean regret %.1f %%, max %.0f %%\n",
                set.empty() ? "all backends" : set.c_str(), constant.strategy.c_str(), 100 * mean(constant.regrets),
                100 * quantile(constant.regrets, 1));
    theirs.insert(theirs.end(), constant.regrets.begin(), constant.regrets.end());
  }
  std::printf("regret, %%         median      p95      max     mean\n");
  const auto line = [](const char* who, const std::vector<double>& r) {
    std::printf("%-14s %9.1f %8.1f %8.1f %8.1f\n", who, 100 * quantile(r, 0.5), 100 * quantile(r, 0.95),
                100 * quantile(r, 1), 100 * mean(r));
  };
  line("dispatcher", ours);
  line("constant", theirs);
  std::printf("expected against actual time of what was chosen: off by %.0f %% (median)\n",
              100 * (std::exp(quantile(ratio, 0.5)) - 1));
}

int run(const SurveyOptions& o) {
  const int budget = o.threads > 0 ? o.threads : this_machine().budget().threads;
  for (const auto& [name, text] : machine_facts()) std::printf("%s: %s\n", name.c_str(), text.c_str());
  const MachineModel& known = machine_model();
  for (const std::string& message : known.messages) std::printf("%s\n", message.c_str());
  std::printf("model: %zu samples, %s\n\n%-22s %-10s %12s %9s   %-34s %s\n", known.model->samples(),
              known.model->source().c_str(), "scene", "without", "chosen", "regret", "chosen", "best");
  std::vector<Answer> answers;
  for (const Question& q : questions(o, budget)) {
    answers.push_back(answer(q, known.model, o.quick));
    print(answers.back());
  }
  summarise(answers);
  if (o.csv.empty()) return 0;
  std::ofstream csv(o.csv);
  write_csv(csv, answers);
  csv.close();
  if (!csv) throw Error(Error::Kind::environment, "--csv: cannot write " + o.csv);
  return 0;
}

}  // namespace
}  // namespace assur::bench

int main(int argc, char** argv) {
  return assur::bench::run_survey(argc, argv, "What the dispatcher loses against the best of all candidates.",
                                  assur::bench::run);
}
