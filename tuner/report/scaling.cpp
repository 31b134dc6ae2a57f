#include <algorithm>
#include <cmath>
#include <memory>

#include "assur/backend.hpp"
#include "assur/ensemble.hpp"
#include "assur/machine.hpp"
#include "assur/plan.hpp"
#include "measure/motion.hpp"
#include "measure/race.hpp"
#include "output/format.hpp"
#include "pictures/plot.hpp"
#include "report/sections.hpp"

namespace assur::report {
namespace {

constexpr double kShort = 5;      // s; a shorter budget only suffices for small mechanisms
constexpr double kWrong = 1e-12;  // residual above which a time is not used; good runs have a few eps

// A call runs all members over all times.
class EnsembleRun final : public measure::Workload {
 public:
  EnsembleRun(const std::vector<Scene>& members, const PrepareOptions& how)
      : ensemble_(members.size(), [&](std::size_t i) { return prepare(members[i], how); }) {}
  bool run(int calls) override {
    for (int i = 0; i < calls; ++i) {
      (void)ensemble_.run();
      if (!ensemble_.report().status.arrived()) return false;
    }
    return true;
  }
  [[nodiscard]] const Report& report() const { return ensemble_.report(); }

 private:
  Ensemble ensemble_;
};

class Contest {
 public:
  Contest(Section& out, const Conditions& conditions)
      : out_(out), conditions_(conditions), cores_(this_machine().cores) {}

  // Enters steps of a mechanism. item: name in the CSV.
  void enter(const std::string& item, const std::string& scene, const std::string& strategy) {
    try {
      enter<measure::StepWorkload>(item, strategy, 1, prepare(sample(scene), how(strategy)), cores_);
    } catch (const Error&) {
      // this strategy cannot run here; `assur backends` explains why
    }
  }

  void enter_all(const std::string& item, const std::vector<Scene>& members, const std::string& strategy) {
    PrepareOptions options = how(strategy);
    options.mode = Mode::throughput;
    enter<EnsembleRun>(item, strategy,
                       static_cast<double>(members.size()) * static_cast<double>(members.front().time().steps()),
                       members, options);
  }

  // Runs the race; returns the candidates with a time, in their order.
  std::vector<Measurement> hold(double seconds) {
    std::vector<measure::Runner> runners;
    for (RaceCandidate& e : entries_) runners.push_back({.work = e.work.get()});
    (void)measure::race(runners, {.seconds = seconds, .least_rounds = 9, .most_rounds = 31, .hopeless = 1e9},
                        conditions_.instruments());
    std::vector<Measurement> times;
    for (std::size_t i = 0; i < runners.size(); ++i) {
      const measure::Runner& r = runners[i];
      const RaceCandidate& e = entries_[i];
      if (r.failed || r.seconds.empty() || !(e.error() < kWrong)) continue;
      times.push_back({e.item, e.strategy, "seconds per step", "s", r.median() / e.steps, "measured",
                       static_cast<int>(r.seconds.size()), r.spread() / r.median(), e.error()});
    }
    entries_.clear();
    out_.measurements.insert(out_.measurements.end(), times.begin(), times.end());
    return times;
  }

 private:
  // A candidate of a race; steps: in one call.
  struct RaceCandidate {
    std::string item, strategy;
    double steps;
    std::unique_ptr<measure::Workload> work;
    std::function<double()> error;
  };

  template <class Work, class... Arguments>
  void enter(const std::string& item, const std::string& strategy, double steps, const Arguments&... arguments) {
    auto work = std::make_unique<Work>(arguments...);
    auto error = [w = work.get()] { return w->report().error.residual(); };
    entries_.push_back({item, strategy, steps, std::move(work), error});
  }
  [[nodiscard]] PrepareOptions how(const std::string& strategy) const {
    return {.strategy = strategy, .budget = ThreadBudget{conditions_.threads}};
  }

  Section& out_;
  const Conditions& conditions_;
  std::vector<int> cores_;
  std::vector<RaceCandidate> entries_;
};

// Speed-ups over the first time of the same scene and solver.
HtmlTable table_of_speed_ups(Section& out, const std::vector<Measurement>& times,
                             const std::function<bool(const Measurement&)>& is_first) {
  using enum HtmlTable::Column;
  HtmlTable table{{"what", "strategy", "step", "repetitions", "spread", "error", "speed-up"},
                  {text, text, number, number, number, number, number},
                  {}};
  const auto solver = [](const Measurement& m) { return parse_strategy(m.strategy).solver.backend; };
  for (const Measurement& m : times) {
    const auto first = std::find_if(times.begin(), times.end(), [&](const Measurement& f) {
      return is_first(f) && f.item == m.item && solver(f) == solver(m);
    });
    const double speed_up = first != times.end() ? first->value / m.value : kNan;
    table.rows.push_back({{m.item, m.strategy, value_text(m), std::to_string(m.repetitions), percent(m.spread),
                           output::error_figure(m.error), std::isnan(speed_up) ? "-" : output::fixed(speed_up)}});
    if (!std::isnan(speed_up)) out.measurements.push_back(derived(m, "speed-up", speed_up, "ratio of the times above"));
  }
  return table;
}

bool alone(const Measurement& m) {
  const Strategy s = parse_strategy(m.strategy);
  return s.run.threads == 1 && s.solver.threads == 1;
}

void splits(Section& out, Contest& contest, const std::string& rings, const Conditions& conditions, double seconds) {
  const std::string threads = std::to_string(conditions.threads);
  for (const Backend& solver : backends()) {
    if (!solver.threads && !solver.keeps_pivots) continue;  // the other solvers gain less or nothing
    const std::string strategy = "groups/" + std::string(solver.id) + (solver.fills_lanes ? ":8" : "");
    contest.enter("threads, " + rings, rings, strategy);
    if (conditions.threads == 1) continue;
    contest.enter("threads, " + rings, rings, strategy + " " + threads + "x1");
    if (solver.threads) contest.enter("threads, " + rings, rings, strategy + " 1x" + threads);
  }
  out.body += "<h4>Threads</h4>\n" +
              paragraph(
                  "One mechanism, step by step. Px1: P packs at once; 1xQ: Q threads in the solver of each pack; "
                  "speed-up over the same solver on one thread.");
  if (conditions.threads == 1) out.body += paragraph("Only one thread may be used here.", "notice");
  out.body += html(table_of_speed_ups(out, contest.hold(seconds), alone));
}

void lanes(Section& out, Contest& contest, const std::string& rings, double seconds) {
  const std::vector<std::pair<std::string, std::string>> sweeps = {{rings, "groups/lanes"},
                                                                   {"stewart:legs=64", "irreducible/lanes"}};
  for (const auto& [scene, solver] : sweeps) {
    for (const int w : {1, 2, 4, 8, 16})
      contest.enter("lanes, " + scene, scene, solver + (w > 1 ? ":" + std::to_string(w) : ""));
  }
  const std::vector<Measurement> times = contest.hold(seconds);
  pictures::Plot plot;
  plot.title = "Speed-up over one lane";
  plot.x = {"lanes, W", false, [](double v) { return v == std::floor(v) ? output::number(std::exp2(v)) : ""; }};
  plot.y = {"speed-up over one lane", false, output::number};
  for (std::size_t k = 0; k < sweeps.size(); ++k) {
    pictures::Series series{.name = sweeps[k].first + ", " + sweeps[k].second,
                            .points = {},
                            .colour = static_cast<int>(k),
                            .mark = k == 0 ? pictures::Series::Mark::dot : pictures::Series::Mark::square,
                            .line = pictures::Series::Line::straight};
    double first = 0;
    for (const Measurement& m : times) {
      if (m.item != "lanes, " + sweeps[k].first) continue;
      const int w = parse_strategy(m.strategy).solver.lanes;
      if (w == 1) first = m.value;
      if (first > 0) series.points.push_back({std::log2(w), first / m.value, m.item + ", " + about(m)});
    }
    plot.series.push_back(std::move(series));
  }
  out.body += "<h4>Lanes</h4>\n" + paragraph("One thread, W groups in lanes.") + pictures::figure(plot) +
              html(table_of_speed_ups(
                  out, times, [](const Measurement& m) { return parse_strategy(m.strategy).solver.lanes == 1; }));
}

void ensemble(Section& out, Contest& contest, const Conditions& conditions, bool small, double seconds) {
  const int members = small ? 32 : 256, steps = 50;
  std::vector<Scene> scenes;
  for (int i = 0; i < members; ++i) {
    scenes.push_back(sample("stewart", {{"omega", 0.5 + static_cast<double>(i) / members}, {"steps", steps}}));
  }
  const std::string name = std::to_string(members) + " stewart, " + std::to_string(steps) + " steps each";
  const std::string threads = " " + std::to_string(conditions.threads) + "x1";
  for (const char* solver : {"irreducible/lanes", "irreducible/lanes:8", "irreducible/lanes:16"})
    contest.enter_all(name, scenes, solver);
  if (conditions.threads > 1) {
    for (const char* solver : {"irreducible/lanes:8", "irreducible/lanes:16"})
      contest.enter_all(name, scenes, solver + threads);
  }
  out.body +=
      "<h4>Many variants at once</h4>\n" +
      paragraph(
          "An ensemble of Stewart platforms with different speeds, all outputs, including the start; speed-up over "
          "one lane on one thread.") +
      html(table_of_speed_ups(out, contest.hold(seconds), [](const Measurement& m) {
        return alone(m) && parse_strategy(m.strategy).solver.lanes == 1;
      }));
}

}  // namespace

Section scaling(const Knowledge&, const Conditions& conditions) {
  Section out{"scaling", "Scaling: threads, lanes, variants"};
  const bool small = conditions.seconds < kShort;
  const std::string rings = small ? "rings:legs=16,n=24" : "rings:legs=64,n=120";
  const auto seconds = [&](double share) { return std::clamp(share * conditions.seconds, 0.3, 20.0); };
  Contest contest(out, conditions);
  splits(out, contest, rings, conditions, seconds(0.4));
  if (!conditions.interrupted()) lanes(out, contest, rings, seconds(0.2));
  if (!conditions.interrupted()) ensemble(out, contest, conditions, small, seconds(0.2));
  return out;
}

}  // namespace assur::report
