#include "tuning/regret_question.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <optional>
#include <string_view>
#include <utility>

#include "assur/assur.hpp"
#include "backends/backends.hpp"
#include "decimal.hpp"
#include "dispatch/strategies.hpp"
#include "dispatch/together_rules.hpp"
#include "measure/motion.hpp"
#include "measure/step_times.hpp"
#include "measure/ways.hpp"
#include "median.hpp"
#include "plan/preparation.hpp"
#include "tuning/mechanisms.hpp"

namespace assur::tuning {
namespace {

using measure::essence;
using measure::is_hopeless;
using measure::Runner;
using measure::StepTimes;
using measure::StepWorkload;
using measure::text_of;

constexpr int kMoreTime = 3;     // repetitions of a race, each with four times the time
constexpr double kWrong = 1e-9;  // residual of a step above which a strategy is not used, without a required accuracy
constexpr std::size_t kFailed = static_cast<std::size_t>(-1);

// One call is a whole run, with its rows.
class RunWorkload final : public measure::Workload {
 public:
  explicit RunWorkload(const Prepared& prepared) : simulator_(prepared, {.pin_to = this_machine().cores}) {}
  bool run(int calls) override {
    for (int i = 0; i < calls; ++i) {
      (void)simulator_.run();
      if (!simulator_.report().status.arrived()) return false;
    }
    return true;
  }
  [[nodiscard]] const Report& report() const { return simulator_.report(); }

 private:
  Simulator simulator_;
};

// A prepared scene in a race.
struct Racer {
  std::string text;
  Prepared prepared;
  std::vector<std::string> others = {};  // other texts with the same plan
  std::unique_ptr<measure::Workload> work = nullptr;
  std::function<const Report&()> report = nullptr;  // of `work`
  double steps = 1;                                 // of a call
  double first_seconds = 0;                         // s, of its first calls
  double seconds = HUGE_VAL, spread = 0;            // s for one step
  std::size_t rounds = 0;
};

template <class Work>
void make(Racer& racer, std::unique_ptr<Work> work) {
  racer.report = [of = work.get()]() -> const Report& { return of->report(); };
  racer.work = std::move(work);
}

bool is_right(const Racer& racer) {
  const Report& report = racer.report();
  const double most = std::max(kWrong, racer.prepared.plan().accuracy);
  return report.status.ok() && report.error.residual() < most;
}

// False if it cannot run or is wrong.
bool enter(Racer& racer, Mode mode) {
  if (is_hopeless(racer.prepared.plan())) return false;
  try {
    // Each thread has its core, because in a race of many teams the system places threads at random.
    static const std::vector<int> kCores = this_machine().cores;
    if (mode == Mode::throughput) {
      make(racer, std::make_unique<RunWorkload>(racer.prepared));
      racer.steps = static_cast<double>(racer.prepared.time().steps());
    } else {
      make(racer, std::make_unique<StepWorkload>(racer.prepared, kCores));
    }
    const double begin = StepTimes::steady();
    const bool runs = racer.work->run(mode == Mode::throughput ? 1 : 3);
    racer.first_seconds = StepTimes::steady() - begin;
    return runs && is_right(racer);
  } catch (const Error&) {
    return false;
  }
}

int threads_of(const Plan& plan) {
  std::int32_t q = 1;
  for (const Plan::Choice& c : plan.choices) q = std::max(q, c.solver.threads);
  return plan.run.threads * q;
}

// The slow runners come last: if time runs out, they are the ones without a turn.
void compete(std::vector<Racer*> racers, const measure::RaceRules& rules, const measure::Instruments& instruments) {
  std::stable_sort(racers.begin(), racers.end(),
                   [](const Racer* a, const Racer* b) { return a->first_seconds < b->first_seconds; });
  std::vector<Runner> runners;
  for (Racer* r : racers) runners.push_back({.work = r->work.get(), .threads = threads_of(r->prepared.plan())});
  const bool shares = std::any_of(runners.begin(), runners.end(), [](const Runner& r) { return r.threads > 1; });
  for (Runner& r : runners) r.by_the_clock = shares;  // times of one thread and of several are compared
  (void)race(runners, rules, instruments);
  for (std::size_t i = 0; i < racers.size(); ++i) {
    Racer& r = *racers[i];
    r.seconds = runners[i].failed || !is_right(r) ? HUGE_VAL : runners[i].median() / r.steps;
    r.spread = runners[i].spread() / r.steps;
    r.rounds = runners[i].seconds.size();
  }
}

// Every strategy with the same settings for all classes, on one or several threads. Policies and formulations would
// multiply their number, so they are only tried where they may matter.
std::vector<Strategy> uniform_strategies(const Scene& scene, const Question& q) {
  StrategySpace space;
  space.formulations = formulations_of(group_equations(scene, {.formulation = Formulation::irreducible}));
  space.lanes = powers_of_two(kMostLanes);
  space.packs = space.threads = powers_of_two(q.threads);
  space.policies = {{}, {.once = true}};
  space.together = true;
  const auto wanted = [](const Backend& backend, const Strategy& s) {
    const SolverSettings& solver = s.solver;
    if (solver.lanes > 1 && !backend.steady) return false;
    if (s.run.threads == 1 && solver.threads == 1) return !solver.once || solver.lanes == 1 || solver.lanes == 8;
    if (s.run.threads > 1 && solver.threads > 1) return false;
    return s.run.formulation == Formulation::irreducible && !solver.once && solver.lanes != 2;
  };
  return strategies(space, {.table = backends(), .without = q.without, .wanted = wanted});
}

// Whole numbers after "dyads:" and "tripods:" only; anything else is a scene as for a command.
Scene scene_of(const Question& q) {
  const auto count_after = [&](std::string_view name) {
    const std::string_view text = q.scene;
    return text.starts_with(name) ? std::atoi(text.substr(name.size()).data()) : 0;
  };
  const int dyads_in_it = count_after("dyads:"), tripods_in_it = count_after("tripods:");
  Scene scene = dyads_in_it > 0 ? dyads(dyads_in_it) : tripods_in_it > 0 ? tripods(tripods_in_it) : open_scene(q.scene);
  return q.outputs.empty() ? scene : scene.with_outputs(q.outputs);
}

PrepareOptions how(const Question& q, const QuestionOptions& options, const std::string& strategy) {
  return {.strategy = strategy,
          .budget = ThreadBudget{q.threads},
          .mode = q.mode,
          .model = options.model,
          .without = q.without,
          .accuracy = q.accuracy};
}

std::vector<Racer> uniform_racers(const Scene& scene, const Question& q, const QuestionOptions& options) {
  std::vector<Racer> racers;
  std::map<std::string, std::size_t> place;  // index of the racer with this essence(), or kFailed
  for (const Strategy& uniform : uniform_strategies(scene, q)) {
    if (options.instruments.stop()) return racers;
    const std::string strategy = to_string(uniform);
    try {
      Racer racer{strategy, prepare(scene, how(q, options, strategy))};
      const auto [at, is_new] = place.try_emplace(essence(racer.prepared.plan()), racers.size());
      if (is_new && enter(racer, q.mode)) {
        racers.push_back(std::move(racer));
      } else if (is_new) {
        at->second = kFailed;
      } else if (at->second != kFailed) {
        racers[at->second].others.push_back(strategy);
      }
    } catch (const Error&) {
      // this strategy cannot run here
    }
  }
  return racers;
}

// Variants of the fastest strategy with another solver or other lanes for one class.
std::vector<Racer> mixed_racers(const Racer& fastest, const Question& q, const QuestionOptions& options) {
  std::vector<Racer> racers;
  const Plan& plan = fastest.prepared.plan();
  for (std::size_t c = 0; c < plan.choices.size() && plan.choices.size() > 1; ++c) {
    StrategySpace space;
    space.lanes = powers_of_two(std::min(kMostLanes, 2 * plan.choices[c].shape.groups - 1));
    for (const Strategy& s : strategies(space, {.table = backends(), .without = q.without})) {
      if (options.instruments.stop()) return racers;
      Preparation changed = preparation(fastest.prepared);
      SolverSettings& solver = changed.plan.choices[c].solver;
      if (solver.backend == s.solver.backend && solver.lanes == s.solver.lanes) continue;
      if (plan.run.together && !why_not_together(s).empty()) continue;
      solver.backend = s.solver.backend;
      solver.lanes = s.solver.lanes;
      solver.once = false;
      Racer racer{text_of(changed.plan), Preparation::shared(std::move(changed))};
      if (enter(racer, q.mode)) racers.push_back(std::move(racer));
    }
  }
  return racers;
}

// The combination of the best strategies of all classes.
std::optional<Racer> combined(const Racer& fastest, const std::vector<Racer>& mixed, Mode mode) {
  Preparation best_of_all = preparation(fastest.prepared);
  Plan& plan = best_of_all.plan;
  bool changed = false;
  for (std::size_t c = 0; c < plan.choices.size(); ++c) {
    double best = fastest.seconds;
    for (const Racer& m : mixed) {
      const SolverSettings& s = m.prepared.plan().choices[c].solver;
      if (m.seconds >= best || s == fastest.prepared.plan().choices[c].solver) continue;
      best = m.seconds;
      plan.choices[c].solver = s;
      changed = true;
    }
  }
  if (!changed) return std::nullopt;
  Racer all{text_of(plan), Preparation::shared(std::move(best_of_all))};
  if (!enter(all, mode)) return std::nullopt;
  return all;
}

bool faster(const Racer* a, const Racer* b) { return a->seconds < b->seconds; }

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

std::string Question::text() const {
  std::string text = scene;
  if (!without.empty()) text += ", " + without_text();
  if (accuracy > 0) text += ", accuracy " + scientific(accuracy, 0);
  if (!outputs.empty()) text += ", " + std::to_string(outputs.size()) + " outputs";
  if (mode == Mode::throughput) text += ", throughput";
  return text;
}

std::vector<double> paired_medians(const std::vector<std::vector<double>>& seconds) {
  std::vector<double> all, of_last;
  for (const std::vector<double>& pass : seconds) of_last.push_back(pass.back());
  for (std::size_t r = 0; !seconds.empty() && r < seconds[0].size(); ++r) {
    std::vector<double> ratios;
    for (const std::vector<double>& pass : seconds) ratios.push_back(pass[r] / pass.back());
    all.push_back(median(ratios) * median(of_last));
  }
  return all;
}

struct Contest::Impl {
  Question question;
  QuestionOptions options;
  Answer first;               // answer of the first races
  std::vector<Racer> racers;  // of the last race; the last three: the untuned choice, and that of the dispatcher twice
  std::vector<Finalist> finalists;           // of them
  std::vector<std::vector<double>> seconds;  // passes x racers
};

std::optional<Contest> Contest::open(const Question& q, const QuestionOptions& options) {
  const Scene scene = scene_of(q);
  Racer chosen{"", prepare(scene, how(q, options, "auto"))};
  chosen.text = text_of(chosen.prepared.plan());
  if (!enter(chosen, q.mode)) throw Error(Error::Kind::numerical, q.scene + ": " + chosen.text + " fails");

  const measure::RaceRules trial{
      .block = 50e-6, .seconds = options.seconds, .least_rounds = 5, .most_rounds = options.quick ? 5 : 9};
  std::vector<Racer> uniform = uniform_racers(scene, q, options);
  if (q.accuracy > 0) {  // what is exact is accurate enough, too
    Question exact = q;
    exact.accuracy = 0;
    Racer racer{"accuracy 0: ", prepare(scene, how(exact, options, "auto"))};
    racer.text += text_of(racer.prepared.plan());
    if (enter(racer, q.mode)) uniform.push_back(std::move(racer));
  }
  std::vector<Racer*> all = pointers(uniform);
  if (options.instruments.stop()) return std::nullopt;
  if (all.empty()) throw Error(Error::Kind::environment, q.scene + ": no strategy can run");
  compete(all, trial, options.instruments);
  std::sort(all.begin(), all.end(), faster);

  std::vector<Racer> mixed = mixed_racers(*all[0], q, options);
  std::optional<Racer> together;
  if (!mixed.empty()) {
    std::vector<Racer*> entrants = pointers(mixed);
    Racer again{all[0]->text, all[0]->prepared};
    if (enter(again, q.mode)) entrants.push_back(&again);
    compete(entrants, trial, options.instruments);
    together = combined(again, mixed, q.mode);
    for (Racer* m : pointers(mixed)) all.push_back(m);
    std::sort(all.begin(), all.end(), faster);
  }
  if (options.instruments.stop()) return std::nullopt;

  auto impl = std::make_unique<Impl>(Impl{q, options, {}, {}, {}, {}});
  Answer& first = impl->first;
  first.question = q;
  first.best_trial_seconds = all[0]->seconds;
  first.expected_seconds = chosen.prepared.plan().expected_seconds;
  for (const Racer& u : uniform) {
    if (!std::isfinite(u.seconds)) continue;
    first.uniform[u.text] = u.seconds;
    for (const std::string& other : u.others) first.uniform[other] = u.seconds;
  }
  // Leaves out the choice of the dispatcher among the other racers.
  std::vector<Racer>& last = impl->racers;
  const std::string own = essence(chosen.prepared.plan());
  for (Racer* r : all) {
    if (last.size() < 4 && essence(r->prepared.plan()) != own) last.push_back({r->text, r->prepared});
  }
  if (together && essence(together->prepared.plan()) != own) last.push_back({together->text, together->prepared});
  QuestionOptions untuned = options;
  untuned.model = std::make_shared<const PerformanceModel>();
  const Prepared unmeasured = prepare(scene, how(q, untuned, "auto"));
  last.push_back({text_of(unmeasured.plan()), unmeasured});
  for (int twice = 0; twice < 2; ++twice) last.push_back({chosen.text, chosen.prepared});
  for (const Racer& r : last) impl->finalists.push_back({.strategy = r.text});
  return Contest(std::move(impl));
}

bool Contest::race() {
  Impl& of = *impl_;
  std::vector<Racer*> all = pointers(of.racers);
  for (Racer* r : all) {
    if (!enter(*r, of.question.mode)) {
      throw Error(Error::Kind::numerical,
                  of.question.scene + ": " + r->text + " ran before, but fails with a new simulator");
    }
  }
  measure::RaceRules rules{.block = 500e-6,
                           .seconds = of.options.seconds / kPasses,
                           .least_rounds = 5,
                           .most_rounds = of.options.quick ? 5 : 11,
                           .hopeless = 1e9,
                           .seed = of.seconds.size() + 1};
  // The two runs of the choice need a time; others may have none.
  const auto timed = [&] { return std::isfinite(all.back()->seconds) && std::isfinite(all[all.size() - 2]->seconds); };
  compete(all, rules, of.options.instruments);
  // On a busy machine the time may be over before the first turn of all racers.
  for (int more = 0; more < kMoreTime && !timed() && !of.options.instruments.stop(); ++more) {
    rules.seconds *= 4;
    compete(all, rules, of.options.instruments);
  }
  if (!is_right(*all.back())) {
    throw Error(Error::Kind::numerical, of.question.scene + ": " + all.back()->text + " gives wrong results");
  }
  std::vector<double> seconds;
  for (const Racer* r : all) seconds.push_back(r->seconds);
  const bool counts = !of.options.instruments.stop() && timed();
  for (std::size_t i = 0; counts && i < all.size(); ++i) {
    Finalist& f = of.finalists[i];
    f.spread = std::max(f.spread, all[i]->spread);
    f.rounds += all[i]->rounds;
    f.error = std::fmax(f.error, all[i]->report().error.residual());
  }
  for (Racer* r : all) r->work.reset();
  if (counts) of.seconds.push_back(std::move(seconds));
  return counts;
}

Answer Contest::answer() const {
  Answer out = impl_->first;
  std::vector<Finalist> all = impl_->finalists;
  const std::vector<double> seconds = paired_medians(impl_->seconds);
  for (std::size_t i = 0; i < all.size(); ++i) all[i].seconds = seconds[i];
  out.chosen = all.back();
  out.again = all[all.size() - 2];
  out.untuned = all[all.size() - 3];
  all.erase(all.end() - 2);
  out.best = *std::min_element(all.begin(), all.end(),
                               [](const Finalist& a, const Finalist& b) { return a.seconds < b.seconds; });
  return out;
}

const Question& Contest::question() const { return impl_->question; }

Contest::Contest(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Contest::Contest(Contest&&) noexcept = default;
Contest& Contest::operator=(Contest&&) noexcept = default;
Contest::~Contest() = default;

}  // namespace assur::tuning
