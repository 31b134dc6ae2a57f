#include "tuning/regret_survey.hpp"

#include <numeric>

namespace assur::tuning {

std::vector<Question> regret_questions(int threads) {
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
    // Without sparse solvers, large scenes take long.
    const bool large = scene.find("n=334") != std::string::npos || scene.find("64") != std::string::npos;
    for (const auto& without : kWithout) {
      if (without.size() < 2 || !large) all.push_back({scene, without, threads});
    }
  }
  return all;
}

std::vector<Question> unlike_questions(int threads) {
  static const std::vector<std::string> kScenes = {"almost_parallelogram",
                                                   "bennett",
                                                   "bricard",
                                                   "bricard_joints",
                                                   "delta",
                                                   "double_wishbone",
                                                   "excavator",
                                                   "geared_five_bar",
                                                   "goldberg",
                                                   "hexa",
                                                   "jansen",
                                                   "jansen:64",
                                                   "klann",
                                                   "n_four_bar:7",
                                                   "parallelograms:5",
                                                   "peaucellier",
                                                   "sarrus",
                                                   "scissor",
                                                   "scissor:20",
                                                   "three_rps",
                                                   "watt",
                                                   "whitworth",
                                                   "whitworth_joints",
                                                   "dyads:7",
                                                   "dyads:24",
                                                   "dyads:64",
                                                   "dyads:128",
                                                   "tripods:5",
                                                   "tripods:30",
                                                   "four_bar:7",
                                                   "four_bar:150",
                                                   "stewart:platforms=3",
                                                   "stewart:platforms=37",
                                                   "stewart:legs=8,platforms=2",
                                                   "rings:legs=3,n=46",
                                                   "rings:legs=9,n=160"};
  std::vector<Question> all;
  for (const std::string& scene : kScenes) all.push_back({.scene = scene, .without = {}, .threads = threads});
  const auto add = [&](Question q) {
    q.threads = threads;
    all.push_back(std::move(q));
  };
  for (const char* scene : {"four_bar", "dyads:8", "delta", "hexa"}) {
    for (const double accuracy : {1e-4, 1e-6, 1e-8}) add({.scene = scene, .without = {}, .accuracy = accuracy});
  }
  for (const char* scene : {"four_bar", "four_bar:23", "delta", "double_wishbone", "hexa", "stewart"}) {
    add({.scene = scene, .without = {}, .mode = Mode::throughput});
  }
  add({.scene = "stewart", .without = {}, .outputs = {"handle1.value"}});
  add({.scene = "four_bar:23", .without = {}, .outputs = {"C23"}});
  return all;
}

std::map<std::string, Constant> constants(std::span<const Answer> answers) {
  std::map<std::string, std::map<std::string, std::vector<double>>> regrets;  // by set, strategy
  std::map<std::string, std::size_t> count;
  for (const Answer& a : answers) {
    const std::string set = a.question.without_text();
    ++count[set];
    for (const auto& [strategy, seconds] : a.uniform) {
      regrets[set][strategy].push_back(seconds / a.best_trial_seconds - 1);
    }
  }
  const auto total = [](const std::vector<double>& r) { return std::accumulate(r.begin(), r.end(), 0.0); };
  std::map<std::string, Constant> best;
  for (const auto& [set, by_strategy] : regrets) {
    for (const auto& [strategy, of_it] : by_strategy) {
      if (of_it.size() != count[set]) continue;
      Constant& c = best[set];
      if (c.strategy.empty() || total(of_it) < total(c.regrets)) c = {strategy, of_it};
    }
  }
  return best;
}

}  // namespace assur::tuning
