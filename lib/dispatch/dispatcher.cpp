#include "dispatch/dispatcher.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "backends/backends.hpp"
#include "decimal.hpp"
#include "dispatch/counts.hpp"
#include "dispatch/throughput.hpp"
#include "dispatch/together_rules.hpp"
#include "equations/system.hpp"
#include "index.hpp"
#include "median.hpp"
#include "numbers.hpp"
#include "parallel/longest_first.hpp"
#include "parallel/team.hpp"

namespace assur {
namespace {

constexpr double kWait = 0.3;  // cost of a level relative to a meeting; a barrier alone takes a tenth (barriers_bench)
// margin for measured meetings: the same meeting takes once or twice as long from minute to minute, depending on the
// cores that the system assigns (regret_bench)
constexpr double kMeetings = 1.5;
constexpr double kHandedOver = 4;  // doubles handed over for each unknown: its prediction and its result
// s for each stored value, if its page exists; measured: 0.23 to 0.39 ns for 393 to 8,640 values, as the time of `assur
// run` minus that of `assur compare`
constexpr double kStoring = 0.3e-9;

// Groups of one class on one level.
struct Batch {
  std::int32_t group_class = 0, level = 0, groups = 0;
};

std::vector<Batch> batches_of(const GroupedSystem& s) {
  std::vector<Batch> batches;
  std::vector<std::int32_t> last(s.classes.size(), -1);  // batch of each class
  for (const SolvedGroup& g : s.groups) {                // level after level
    std::int32_t& at = last[idx(g.group_class)];
    if (at < 0 || batches[idx(at)].level != g.level) {
      at = static_cast<std::int32_t>(batches.size());
      batches.push_back({g.group_class, g.level, 0});
    }
    ++batches[idx(at)].groups;
  }
  return batches;
}

struct ClassLoad {
  std::vector<Batch> batches;
  std::int32_t most = 0;                                            // largest number of groups in a batch
  bool alone = true;                                                // no other class on its levels
  [[nodiscard]] bool single() const { return most == 1 && alone; }  // never two packs at the same time
};

std::vector<ClassLoad> loads_of(const GroupedSystem& s, const std::vector<Batch>& batches) {
  std::vector<std::int32_t> classes_on(idx(s.levels), 0);
  for (const Batch& b : batches) ++classes_on[idx(b.level)];
  std::vector<ClassLoad> loads(s.classes.size());
  for (const Batch& b : batches) {
    ClassLoad& load = loads[idx(b.group_class)];
    load.batches.push_back(b);
    load.most = std::max(load.most, b.groups);
    load.alone = load.alone && classes_on[idx(b.level)] == 1;
  }
  return loads;
}

std::int32_t packs_of(std::int32_t groups, std::int32_t lanes) { return (groups + lanes - 1) / lanes; }

// The solver of a class, and its advantage over the second best.
std::string reason_of(const std::vector<Candidate>& ranked) {
  const Candidate& best = ranked[0];
  std::string text(best.origin == Origin::prior ? "not measured" : name(best.origin));
  for (const Candidate& c : ranked) {
    if (!c.why_not.empty() || c.strategy.solver.backend == best.strategy.solver.backend) continue;
    const double ratio = c.expected_seconds / best.expected_seconds;
    text += ": expected " + fixed(ratio, ratio < 10 ? 1 : 0) + " times as fast as " + c.strategy.solver.backend;
    break;
  }
  return text;
}

Plan::Choice choice_of(std::int32_t group_class, const Shape& shape, std::vector<Candidate> weighed,
                       const Scales& scales) {
  rank(weighed, scales.tie);
  if (weighed.empty() || !weighed[0].why_not.empty()) {
    std::string reasons;
    for (const Candidate& c : weighed) {
      reasons += (reasons.empty() ? "" : "; ") + c.strategy.solver.backend + ": " + c.why_not;
    }
    throw Error(Error::Kind::environment,
                "no backend can solve groups of " + std::to_string(shape.n) + " unknowns here: " + reasons);
  }
  return {
      .group_class = group_class, .shape = shape, .solver = weighed[0].strategy.solver, .reason = reason_of(weighed)};
}

// Time of a step besides its packs. If threads run for the levels and outputs are many, the threads share the outputs.
class Around {
 public:
  Around(const GroupedSystem& s, const PerformanceModel& model) : model_(model), counts_(around_counts(s)) {}

  [[nodiscard]] const AroundCounts& counts() const { return counts_; }

  [[nodiscard]] double seconds(std::int32_t threads) const {
    const auto& [unknowns, columns, pieces] = counts_;
    const bool shared = threads > 1 && columns >= static_cast<std::int64_t>(kWorthSharing);
    return model_.around(unknowns, shared ? pieces / threads : pieces).seconds +
           (shared ? kWait * model_.meeting(threads).seconds : 0);
  }

 private:
  const PerformanceModel& model_;
  AroundCounts counts_;
};

// Number of known coordinates, and of unknowns of earlier levels, that each level reads.
std::vector<std::int64_t> read_by_levels(const GroupedSystem& s) {
  std::vector<std::int64_t> read(idx(s.levels), 0);
  std::vector<std::int32_t> last(s.system->coordinates.size(), -1);  // level that reads a coordinate
  for (const SolvedGroup& g : s.groups) {
    for (const std::int32_t c : g.inputs) {
      if (std::exchange(last[idx(c)], g.level) != g.level) ++read[idx(g.level)];
    }
  }
  return read;
}

// Chooses the threads of each level and computes the time of all levels. A level is shared only if that saves time; one
// level is also shared if the outputs then save time. The threads start together once a step; their waits between
// levels are the smaller part of a meeting.
void share_levels(Plan& plan, const GroupedSystem& s, const std::vector<Batch>& batches, std::int32_t budget,
                  const Around& around, const PerformanceModel& model) {
  const std::int32_t p = plan.run.threads;
  plan.meeting_seconds = kMeetings * model.meeting(p).seconds;
  const std::vector<std::int64_t> read = p > 1 ? read_by_levels(s) : std::vector<std::int64_t>(idx(s.levels), 0);
  struct {
    double seconds = kInfinity;
    std::int32_t level = 0;
  } least_loss;
  double all_alone = 0;
  plan.level_threads.assign(idx(s.levels), 1);
  plan.expected_seconds = 0;
  std::vector<double> costs;
  for (std::size_t begin = 0, end = 0; begin < batches.size(); begin = end) {
    const std::int32_t level = batches[begin].level;
    costs.clear();
    std::int32_t most_q = 1;
    double doubles = 3.0 * static_cast<double>(read[idx(level)]), contended = 0, in_turns = 0;
    for (; end < batches.size() && batches[end].level == level; ++end) {
      const Plan::Choice& choice = plan.choices[idx(batches[end].group_class)];
      const std::int32_t packs = packs_of(batches[end].groups, choice.solver.lanes);
      const std::int32_t n = s.classes[idx(choice.group_class)].n;
      costs.insert(costs.end(), idx(packs), choice.expected_seconds);
      contended += packs * choice.expected_seconds * model.contention(p, n);
      if (properties_of(choice.solver.backend).takes_turns) in_turns += packs * choice.expected_seconds;
      most_q = std::max(most_q, choice.solver.threads);
      doubles += batches[end].groups * kHandedOver * n;
    }
    const double alone = std::accumulate(costs.begin(), costs.end(), 0.0);
    double best = alone;
    const double handover = kMeetings * model.meeting(p, doubles * (p - 1) / p).seconds - plan.meeting_seconds;
    if (p > 1 && costs.size() > 1 && std::int64_t{p} * most_q <= budget) {
      const double makespan = std::max(longest_first(costs, p).makespan, in_turns);
      const double shared = together(makespan, alone, p, contended / alone) + kWait * plan.meeting_seconds + handover;
      if (shared < alone) {
        best = shared;
        plan.level_threads[idx(level)] = p;
      } else if (shared - alone < least_loss.seconds) {
        least_loss = {shared - alone, level};
      }
    }
    plan.expected_seconds += best;
    all_alone += alone;
  }
  const bool any = std::any_of(plan.level_threads.begin(), plan.level_threads.end(), [](auto n) { return n > 1; });
  if (!any && std::isfinite(least_loss.seconds)) {
    plan.level_threads[idx(least_loss.level)] = p;
    plan.expected_seconds += least_loss.seconds;
  }
  plan.expected_seconds += plan.meeting_seconds + around.seconds(p);
  all_alone += around.seconds(1);
  const bool can = any || std::isfinite(least_loss.seconds);
  if (can && plan.expected_seconds < all_alone) return;
  plan.level_threads.assign(idx(s.levels), 1);
  plan.expected_seconds = all_alone;
}

// Mechanisms that run side by side fill the lanes of each pack.
void expect_packs(Plan& plan, Mode mode, const PerformanceModel& model) {
  for (Plan::Choice& c : plan.choices) {
    Strategy strategy = plan.strategy(c);
    if (mode == Mode::throughput) strategy.solver.lanes = plan.lanes;
    const Prediction one = model.pack(c.shape, strategy);
    c.expected_seconds = one.seconds;
    c.origin = one.origin;
  }
}

// Of a step of one mechanism among those that fill the lanes.
double throughput_seconds(const Plan& plan, const Around& around) {
  double sum = around.seconds(1);
  for (const Plan::Choice& c : plan.choices) sum += c.expected_seconds / plan.lanes * c.shape.groups;
  return sum;
}

// Of a step with +together.
double together_seconds(const Plan& plan, const Around& around) {
  double sum = around.seconds(1);
  for (const Plan::Choice& c : plan.choices) sum += packs_of(c.shape.groups, c.solver.lanes) * c.expected_seconds;
  return sum;
}

using Offers = std::vector<std::vector<Candidate>>;  // by class

// Classes of the same shape get the same offers.
template <class MostLanes>
Offers offers_of(const std::vector<Shape>& shapes, const MostLanes& most_lanes, std::int32_t most_q,
                 const Scales& scales) {
  Offers all;
  for (std::size_t c = 0; c < shapes.size(); ++c) {
    std::size_t same = 0;
    while (same < c && !(shapes[same] == shapes[c] && most_lanes(same) == most_lanes(c))) ++same;
    all.push_back(same < c ? all[same] : offers(shapes[c], most_lanes(c), most_q, scales));
  }
  return all;
}

// Groups of one mechanism side by side, p packs at the same time.
Plan latency_plan(const std::vector<Shape>& shapes, const std::vector<ClassLoad>& classes, const Offers& offers,
                  std::int32_t p, std::int32_t budget, const Scales& scales) {
  Plan plan;
  plan.run.threads = p;
  plan.lanes = kThroughputLanes;  // used if mechanisms run side by side later
  for (std::size_t c = 0; c < classes.size(); ++c) {
    std::vector<Load> loads;
    for (const Batch& b : classes[c].batches) loads.push_back({b.groups, classes[c].alone ? p : 1, shapes[c].n});
    const std::int32_t most_q = classes[c].single() ? budget : budget / p;
    plan.choices.push_back(
        choice_of(static_cast<std::int32_t>(c), shapes[c], weigh(offers[c], loads, most_q, scales), scales));
    Plan::Choice& choice = plan.choices.back();
    choice.threads = choice.solver.threads > budget / p ? 1 : p;
  }
  return plan;
}

// Mechanisms side by side: every group is a pack of W mechanisms.
Plan throughput_plan(const std::vector<Shape>& shapes, const Offers& offers, std::int32_t lanes, std::int32_t p,
                     const Scales& scales) {
  Plan plan;
  plan.run.threads = p;
  plan.lanes = lanes;
  for (std::size_t c = 0; c < shapes.size(); ++c) {
    const Load load{lanes * shapes[c].groups, 1, shapes[c].n};
    std::vector<Candidate> weighed = weigh(offers[c], {&load, 1}, 1, scales);
    std::erase_if(weighed, [&](const Candidate& x) { return x.why_not.empty() && x.strategy.solver.lanes != lanes; });
    plan.choices.push_back(choice_of(static_cast<std::int32_t>(c), shapes[c], std::move(weighed), scales));
    plan.choices.back().threads = p;
  }
  return plan;
}

// The fastest choice for a class whose groups are solved together with those of all other levels.
Plan::Choice choice_together(std::int32_t group_class, const Shape& shape, const PerformanceModel& model) {
  std::vector<Strategy> ways;
  for (std::int32_t lanes = kLeastTogetherLanes; lanes <= kMostLanes; lanes *= 2) {
    ways.push_back({.run = {.together = true}, .solver = {.backend = std::string(kLanes.id), .lanes = lanes}});
  }
  const std::vector<Prediction> packs = model.packs(shape, ways);
  Plan::Choice best;
  best.group_class = group_class;
  best.shape = shape;
  best.reason = "groups of all levels side by side";
  double least = kInfinity;
  for (std::size_t i = 0; i < ways.size(); ++i) {
    const double all = packs_of(shape.groups, ways[i].solver.lanes) * packs[i].seconds;
    if (all >= least) continue;
    least = all;
    best.solver = ways[i].solver;
    best.expected_seconds = packs[i].seconds;
    best.origin = packs[i].origin;
  }
  return best;
}

// The groups of all levels at once, if they are small.
std::optional<Plan> together_plan(const GroupedSystem& s, const std::vector<Shape>& shapes, const Around& around,
                                  const Scales& scales) {
  const bool left_out = std::find(scales.without.begin(), scales.without.end(), kLanes.id) != scales.without.end();
  const auto is_large = [](const Shape& shape) { return shape.n > kMostChosenTogether; };
  if (left_out || std::any_of(shapes.begin(), shapes.end(), is_large) || !why_not_together(s).empty())
    return std::nullopt;
  Plan plan;
  plan.run.together = true;
  plan.lanes = kThroughputLanes;
  plan.level_threads.assign(idx(s.levels), 1);
  for (std::size_t c = 0; c < shapes.size(); ++c) {
    plan.choices.push_back(choice_together(static_cast<std::int32_t>(c), shapes[c], scales.model));
  }
  plan.expected_seconds = together_seconds(plan, around);
  return plan;
}

bool threads_were_measured(const PerformanceModel& model) { return model.meeting(2).origin != Origin::prior; }

// True if the machine was measured, but not with several threads: their gain would be a guess.
bool tuned_for_one_thread(const PerformanceModel& model) {
  return model.samples() > 0 && !threads_were_measured(model);
}

std::string threads_reason(const Plan& best, std::int32_t budget, double alone, const PerformanceModel& model) {
  if (budget == 1) return "one thread: the budget has only one";
  if (tuned_for_one_thread(model)) {
    return "one thread: several threads were not measured; `assur tune` with two threads or more measures them";
  }
  if (best.run.threads == 1) return "one thread: more threads would not help";
  return std::to_string(best.run.threads) + " threads: expected " + fixed(alone / best.expected_seconds, 1) +
         " times as fast as one" + (threads_were_measured(model) ? "" : ", not measured");
}

// Halves the lanes of each class as long as one pack still holds all groups of a level.
void narrow(Plan& plan, const GroupedSystem& s) {
  const std::vector<ClassSize> sizes = class_sizes(s);
  for (Plan::Choice& c : plan.choices) {
    while (c.solver.lanes / 2 >= sizes[idx(c.group_class)].side_by_side) c.solver.lanes /= 2;
  }
}

// Chooses the W with the least time for each mechanism. Single steps still take no more lanes than they fill.
Plan best_throughput(const GroupedSystem& s, const std::vector<Shape>& shapes, std::int32_t threads,
                     const Scales& scales) {
  std::optional<Plan> best;
  const Around around(s, scales.model);
  const Offers offered = offers_of(
      shapes, [](std::size_t) { return kMostLanes; }, 1, scales);
  for (std::int32_t lanes = 1; lanes <= kMostLanes; lanes *= 2) {
    Plan plan = throughput_plan(shapes, offered, lanes, threads, scales);
    expect_packs(plan, Mode::throughput, scales.model);
    plan.expected_seconds = throughput_seconds(plan, around);
    plan.reason = std::to_string(lanes) + " mechanisms side by side in each thread";
    if (threads > 1 && tuned_for_one_thread(scales.model)) plan.reason += "; several threads were not measured";
    if (!best || plan.expected_seconds < best->expected_seconds * (1 - scales.tie)) best = std::move(plan);
  }
  narrow(*best, s);
  return std::move(*best);
}

// Chooses the p with the least time for a step.
Plan best_latency(const GroupedSystem& s, const std::vector<Shape>& shapes, std::int32_t allowed,
                  const Scales& scales) {
  const std::int32_t budget = tuned_for_one_thread(scales.model) ? 1 : allowed;
  const std::vector<Batch> batches = batches_of(s);
  const std::vector<ClassLoad> classes = loads_of(s, batches);
  // W goes up to the first power of two that holds all groups; further lanes would stay empty.
  const Offers offered = offers_of(
      shapes, [&](std::size_t c) { return 2 * classes[c].most - 1; }, budget, scales);
  const Around around(s, scales.model);
  std::optional<Plan> best;
  double alone = 0;
  for (std::int32_t p = 1; p <= budget; p = p < budget ? std::min(2 * p, budget) : p + 1) {
    Plan plan = latency_plan(shapes, classes, offered, p, budget, scales);
    expect_packs(plan, Mode::latency, scales.model);
    share_levels(plan, s, batches, budget, around, scales.model);
    if (p == 1) alone = plan.expected_seconds;
    if (!best || plan.expected_seconds < best->expected_seconds * (1 - scales.tie)) best = std::move(plan);
  }
  best->reason = threads_reason(*best, allowed, alone, scales.model);
  std::optional<Plan> other = together_plan(s, shapes, around, scales);
  if (!other) return std::move(*best);
  const double gain = best->expected_seconds / other->expected_seconds;
  if (gain * (1 - scales.tie) > 1) {
    other->reason = "all levels together: expected " + fixed(gain, 1) + " times as fast as level after level";
    return std::move(*other);
  }
  if (s.levels > 1) best->reason += "; all levels together would take " + fixed(1 / gain, 1) + " times as long";
  return std::move(*best);
}

// A measured strategy of this mechanism, as a plan with the times that the model expects of its parts.
struct MeasuredPlan {
  Plan plan;
  double seconds;  // measured
};

std::vector<MeasuredPlan> measured_plans(const GroupedSystem& s, const std::vector<Shape>& shapes, std::int32_t threads,
                                         const Scales& scales) {
  std::vector<MeasuredPlan> all;
  for (const PerformanceModel::MeasuredStep& step : scales.model.steps(shape_of_step(s, shapes))) {
    const Strategy& strategy = step.strategy;
    const bool fits =
        strategy.run.threads * strategy.solver.threads <= threads && strategy.run.formulation == s.formulation;
    const bool runs =
        std::all_of(shapes.begin(), shapes.end(), [&](const Shape& shape) { return can_run(strategy, shape, scales); });
    if (!fits || !runs || (strategy.run.together && !why_not_together(s, strategy).empty())) continue;
    Plan plan = uniform_plan(strategy, s, shapes);
    expect(plan, s, Mode::latency, scales.model);
    all.push_back({std::move(plan), step.time.seconds});
  }
  return all;
}

bool run_alike(const Plan& a, const Plan& b) {
  return a.run.together == b.run.together && a.level_threads == b.level_threads &&
         std::equal(a.choices.begin(), a.choices.end(), b.choices.begin(), b.choices.end(),
                    [](const Plan::Choice& x, const Plan::Choice& y) { return x.solver == y.solver; });
}

// If whole steps of this mechanism were measured, they decide between their strategies, and show how far off the model
// is for others.
void correct_by_whole_steps(Dispatched& choice, const GroupedSystem& s, const std::vector<Shape>& shapes,
                            std::int32_t threads, const Scales& scales) {
  std::vector<MeasuredPlan> measured = measured_plans(s, shapes, threads, scales);
  if (measured.empty()) return;
  const auto fastest = std::min_element(measured.begin(), measured.end(),
                                        [](const auto& a, const auto& b) { return a.seconds < b.seconds; });
  std::vector<double> ratios;
  for (const MeasuredPlan& m : measured) ratios.push_back(m.seconds / m.plan.expected_seconds);
  const auto own = std::find_if(measured.begin(), measured.end(),
                                [&](const MeasuredPlan& m) { return run_alike(m.plan, choice.plan); });
  const double seconds = own != measured.end() ? own->seconds : choice.modelled_seconds * median(std::move(ratios));
  choice.is_measured = true;
  choice.plan.expected_seconds = seconds;
  if (fastest->seconds >= seconds * (1 - scales.tie)) return;
  choice.modelled_seconds = fastest->plan.expected_seconds;
  choice.plan = std::move(fastest->plan);
  choice.plan.lanes = kThroughputLanes;
  choice.plan.expected_seconds = fastest->seconds;
  choice.plan.reason = "whole steps were measured: " + fixed(seconds / fastest->seconds, 1) +
                       " times as fast as the choice by the times of their parts";
  for (Plan::Choice& c : choice.plan.choices) c.reason = "whole steps were measured";
}

}  // namespace

void expect(Plan& plan, const GroupedSystem& structure, Mode mode, const PerformanceModel& model) {
  expect_packs(plan, mode, model);
  const Around around(structure, model);
  std::int32_t most_q = 1;
  for (const Plan::Choice& c : plan.choices) most_q = std::max(most_q, c.solver.threads);
  share_levels(plan, structure, batches_of(structure), plan.run.threads * most_q, around, model);
  if (mode == Mode::throughput) {
    plan.expected_seconds = throughput_seconds(plan, around);
  } else if (plan.run.together) {
    plan.expected_seconds = together_seconds(plan, around);
  }
}

BesideGroups beside_groups(const GroupedSystem& structure, const PerformanceModel& model, std::int32_t threads) {
  const Around around(structure, model);
  const AroundCounts& counts = around.counts();
  return {.around = around.seconds(threads),
          .storing = kStoring * static_cast<double>(counts.columns),
          .outputs = counts.columns};
}

Plan uniform_plan(const Strategy& strategy, const GroupedSystem& s, const std::vector<Shape>& shapes) {
  Plan plan;
  plan.run = strategy.run;
  plan.lanes = strategy.solver.lanes;
  for (std::size_t c = 0; c < shapes.size(); ++c) {
    Plan::Choice& choice = plan.choices.emplace_back();
    choice.group_class = static_cast<std::int32_t>(c);
    choice.shape = shapes[c];
    choice.solver = strategy.solver;
    choice.threads = strategy.run.threads;
  }
  if (!strategy.run.together) narrow(plan, s);
  return plan;
}

Dispatched dispatch(const GroupedSystem& s, const Task& task, const Scales& scales) {
  const std::vector<Shape> shapes = class_shapes(s);
  Dispatched out;
  out.plan = task.mode == Mode::throughput ? best_throughput(s, shapes, task.threads, scales)
                                           : best_latency(s, shapes, task.threads, scales);
  out.modelled_seconds = out.plan.expected_seconds;
  if (task.mode == Mode::latency) correct_by_whole_steps(out, s, shapes, task.threads, scales);
  out.plan.run.formulation = s.formulation;
  return out;
}

}  // namespace assur
