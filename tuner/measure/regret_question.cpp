#include "measure/regret_question.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>

#include "assur/assur.hpp"
#include "measure/motion.hpp"
#include "measure/step_times.hpp"
#include "measure/ways.hpp"

namespace assur::measure {
namespace {

constexpr double kWrong = 1e-9;  // residual of a step from which on nobody wants it
constexpr int kPasses = 5;       // of the last race
constexpr std::size_t kFailed = static_cast<std::size_t>(-1);

// A prepared scene that can be raced.
struct Racer {
  std::string text;
  Prepared prepared;
  std::vector<std::string> others = {};  // texts that mean the same here
  std::unique_ptr<WholeStep> step = nullptr;
  double first_seconds = 0;  // of its first steps
  double seconds = HUGE_VAL, spread = 0;
  std::size_t rounds = 0;
};

std::size_t idx(std::int32_t i) { return static_cast<std::size_t>(i); }

std::string text_of(const Plan& plan) {
  std::vector<std::string> texts;
  for (Plan::Choice c : plan.choices) {
    c.strategy.predictor = {};  // the same for all
    texts.push_back(to_string(c.strategy));
  }
  if (std::set<std::string>(texts.begin(), texts.end()).size() <= 1) return texts.empty() ? "-" : texts[0];
  std::string all;
  for (const std::string& text : texts) all += (all.empty() ? "" : " | ") + text;
  return all;
}

bool is_right(const Report& report) {
  return report.status.ok() && report.error.position < kWrong && report.error.velocity < kWrong &&
         report.error.acceleration < kWrong;
}

// False if it cannot run or is wrong.
bool enter(Racer& racer) {
  if (is_hopeless(racer.prepared.plan)) return false;
  try {
    // Where the system puts two threads is luck in a race of many teams: each has its core.
    static const std::vector<int> kCores = this_machine().cores;
    const bool enough = idx(racer.prepared.plan.threads) <= kCores.size();
    racer.step = std::make_unique<WholeStep>(racer.prepared, enough ? kCores : std::vector<int>{});
    const double begin = StepTimes::steady();
    const bool runs = racer.step->run(3);
    racer.first_seconds = StepTimes::steady() - begin;
    return runs && is_right(racer.step->report());
  } catch (const Error&) {
    return false;
  }
}

// Should a few slow ones need all the time, they are the ones without a turn.
void race(std::vector<Racer*> racers, const RaceRules& rules, const Instruments& instruments) {
  std::stable_sort(racers.begin(), racers.end(),
                   [](const Racer* a, const Racer* b) { return a->first_seconds < b->first_seconds; });
  std::vector<Runner> runners;
  for (Racer* r : racers) runners.push_back({.work = r->step.get()});
  (void)measure::race(runners, rules, instruments);
  for (std::size_t i = 0; i < racers.size(); ++i) {
    racers[i]->seconds = runners[i].failed || !is_right(racers[i]->step->report()) ? HUGE_VAL : runners[i].median();
    racers[i]->spread = runners[i].spread();
    racers[i]->rounds = runners[i].seconds.size();
  }
}

// Every strategy that is the same for all classes, on one thread or on several. Policies and formulations multiply what
// is already many: they are tried where they can matter.
std::vector<std::string> uniform_strategies(const Scene& scene, const Question& q) {
  std::vector<std::string> all;
  std::vector<std::string> formulations = {"irreducible", "global"};
  if (!scene.groups().empty()) formulations.push_back("groups");
  for (const Backend& backend : backends()) {
    const std::string id(backend.id);
    if (!backend.why_not({}, {}).empty()) continue;
    if (std::find(q.without.begin(), q.without.end(), id) != q.without.end()) continue;
    for (const std::string& formulation : formulations) {
      const std::string solver = formulation + "/" + id;
      all.push_back(solver);
      all.push_back(solver + "+once");
      if (formulation == "global" || id == "mumps" || id == "umfpack") continue;
      for (const int lanes : {2, 4, 8, 16}) all.push_back(solver + ":" + std::to_string(lanes));
      all.push_back(solver + ":8+once");
    }
    for (int p = 2; p <= q.threads; p *= 2) {
      const std::string threads = std::to_string(p);
      for (const int lanes : {1, 4, 8, 16}) {
        if (lanes > 1 && (id == "mumps" || id == "umfpack")) continue;
        all.push_back("irreducible/" + id + (lanes > 1 ? ":" + std::to_string(lanes) : "") + " " + threads + "x1");
      }
      if (backend.why_not({}, ThreadBudget{p}).empty()) all.push_back("irreducible/" + id + " 1x" + threads);
    }
  }
  return all;
}

// What is run in the end: where there are no groups for more lanes or threads, other texts mean the same.
std::string essence_of(const Prepared& prepared) {
  Plan plan = prepared.plan;
  for (Plan::Choice& c : plan.choices) c.strategy.p = 1;
  std::string text = text_of(plan);
  const auto& threads = prepared.plan.level_threads;
  for (std::size_t level = 0; level < threads.size(); ++level) {
    if (threads[level] > 1) text += ", level " + std::to_string(level) + ": " + std::to_string(threads[level]);
  }
  return text;
}

std::vector<Racer> uniform_racers(const Scene& scene, const Question& q, const QuestionOptions& options) {
  std::vector<Racer> racers;
  std::map<std::string, std::size_t> place;  // by essence: of the racer, or kFailed
  for (const std::string& strategy : uniform_strategies(scene, q)) {
    if (options.instruments.stop()) return racers;
    try {
      Racer racer{strategy,
                  prepare(scene, {.strategy = strategy, .budget = ThreadBudget{q.threads}, .model = options.model})};
      const auto [at, is_new] = place.try_emplace(essence_of(racer.prepared), racers.size());
      if (is_new && enter(racer)) {
        racers.push_back(std::move(racer));
      } else if (is_new) {
        at->second = kFailed;
      } else if (at->second != kFailed) {
        racers[at->second].others.push_back(strategy);
      }
    } catch (const Error&) {
      // it cannot run here
    }
  }
  return racers;
}

// The fastest with another solver or other lanes for one class.
std::vector<Racer> mixed_racers(const Racer& fastest, const Question& q, const QuestionOptions& options) {
  std::vector<Racer> racers;
  const Plan& plan = fastest.prepared.plan;
  for (std::size_t c = 0; c < plan.choices.size() && plan.choices.size() > 1; ++c) {
    for (const Backend& backend : backends()) {
      if (!backend.why_not({}, {}).empty()) continue;
      if (std::find(q.without.begin(), q.without.end(), backend.id) != q.without.end()) continue;
      for (const int lanes : {1, 2, 4, 8, 16}) {
        if (options.instruments.stop()) return racers;
        if (lanes > 2 * plan.choices[c].shape.groups - 1) continue;
        Racer racer{.text = "", .prepared = fastest.prepared};
        Strategy& s = racer.prepared.plan.choices[c].strategy;
        if (s.backend == backend.id && s.lanes == lanes) continue;
        s.backend = backend.id;
        s.lanes = lanes;
        s.once = false;
        racer.text = text_of(racer.prepared.plan);
        if (enter(racer)) racers.push_back(std::move(racer));
      }
    }
  }
  return racers;
}

// What is best for each class alone, all at once.
std::optional<Racer> combined(const Racer& fastest, const std::vector<Racer>& mixed) {
  Racer all{"", fastest.prepared};
  Plan& plan = all.prepared.plan;
  bool changed = false;
  for (std::size_t c = 0; c < plan.choices.size(); ++c) {
    double best = fastest.seconds;
    for (const Racer& m : mixed) {
      const Strategy& s = m.prepared.plan.choices[c].strategy;
      if (m.seconds >= best || s == fastest.prepared.plan.choices[c].strategy) continue;
      best = m.seconds;
      plan.choices[c].strategy = s;
      changed = true;
    }
  }
  all.text = text_of(plan);
  if (!changed || !enter(all)) return std::nullopt;
  return all;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The last race, in passes with simulators made anew: where memory lies, and what else the machine does for a moment,
// is not the strategy's. Racers get the medians of their passes, and the largest of their spreads.
void race_in_passes(std::vector<Racer*>& racers, RaceRules rules, const Instruments& instruments) {
  std::map<const Racer*, std::vector<double>> seconds, spreads;
  std::map<const Racer*, std::size_t> rounds;
  rules.seconds /= kPasses;
  for (int pass = 0; pass < kPasses && !instruments.stop(); ++pass) {
    for (Racer* r : racers) {
      if (pass > 0 && !enter(*r)) throw Error(Error::Kind::numerical, r->text + " fails when it is prepared again");
    }
    rules.seed += 1;
    race(racers, rules, instruments);
    for (const Racer* r : racers) {
      seconds[r].push_back(r->seconds);
      spreads[r].push_back(r->spread);
      rounds[r] += r->rounds;
    }
  }
  for (Racer* r : racers) {
    if (seconds[r].empty()) return;
    r->seconds = median(seconds[r]);
    r->spread = *std::max_element(spreads[r].begin(), spreads[r].end());
    r->rounds = rounds[r];
  }
}

bool faster(const Racer* a, const Racer* b) { return a->seconds < b->seconds; }

Finalist finalist(const Racer& r) {
  const ErrorFigures& error = r.step->report().error;
  return {r.text, r.seconds, r.spread, r.rounds, std::max({error.position, error.velocity, error.acceleration})};
}

std::vector<Racer*> pointers(std::vector<Racer>& racers) {
  std::vector<Racer*> all;
  for (Racer& r : racers) all.push_back(&r);
  return all;
}

}  // namespace

std::string Question::without_text() const {
  std::string text;
  for (const std::string& backend : without) text += "-" + backend;
  return text;
}

std::optional<Answer> answer(const Question& q, const QuestionOptions& options) {
  const Scene scene = open_scene(q.scene);
  Racer chosen{"", prepare(scene, {.budget = ThreadBudget{q.threads}, .model = options.model, .without = q.without})};
  chosen.text = text_of(chosen.prepared.plan);
  if (!enter(chosen)) throw Error(Error::Kind::numerical, q.scene + ": " + chosen.text + " fails");

  const RaceRules trial{
      .block = 50e-6, .seconds = options.seconds, .least_rounds = 5, .most_rounds = options.quick ? 5 : 9};
  std::vector<Racer> uniform = uniform_racers(scene, q, options);
  std::vector<Racer*> all = pointers(uniform);
  if (options.instruments.stop()) return std::nullopt;
  if (all.empty()) throw Error(Error::Kind::environment, q.scene + ": no strategy can run");
  race(all, trial, options.instruments);
  std::sort(all.begin(), all.end(), faster);

  std::vector<Racer> mixed = mixed_racers(*all[0], q, options);
  std::optional<Racer> together;
  if (!mixed.empty()) {
    std::vector<Racer*> entrants = pointers(mixed);
    Racer again{all[0]->text, all[0]->prepared};
    if (enter(again)) entrants.push_back(&again);
    race(entrants, trial, options.instruments);
    together = combined(again, mixed);
    for (Racer* m : pointers(mixed)) all.push_back(m);
    std::sort(all.begin(), all.end(), faster);
  }

  Answer out;
  out.best_trial_seconds = all[0]->seconds;
  out.question = q;
  out.expected_seconds = chosen.prepared.plan.expected_seconds;
  for (const Racer& u : uniform) {
    if (!std::isfinite(u.seconds)) continue;
    out.uniform[u.text] = u.seconds;
    for (const std::string& other : u.others) out.uniform[other] = u.seconds;
  }
  // Of the others, what the dispatcher chose takes no part.
  std::vector<Racer*> final;
  const std::string essence = essence_of(chosen.prepared);
  for (Racer* r : all) {
    if (final.size() < 4 && essence_of(r->prepared) != essence) final.push_back(r);
  }
  if (together && essence_of(together->prepared) != essence) final.push_back(&*together);
  Racer again{chosen.text, chosen.prepared};
  if (!enter(again)) throw Error(Error::Kind::numerical, q.scene + ": " + again.text + " fails when it is made again");
  final.push_back(&again);
  final.push_back(&chosen);
  const RaceRules last{.block = 500e-6,
                       .seconds = options.seconds,
                       .least_rounds = 5,
                       .most_rounds = options.quick ? 5 : 11,
                       .hopeless = 1e9};
  race_in_passes(final, last, options.instruments);
  if (options.instruments.stop()) return std::nullopt;
  out.chosen = finalist(chosen);
  out.again = finalist(again);
  std::erase(final, &again);
  out.best = finalist(**std::min_element(final.begin(), final.end(), faster));
  return out;
}

}  // namespace assur::measure
