#include "dispatch/candidates.hpp"

#include <algorithm>
#include <cmath>

#include "backends/backends.hpp"
#include "backends/cuda.hpp"
#include "decimal.hpp"
#include "dispatch/counts.hpp"
#include "dispatch/strategies.hpp"
#include "parallel/machine.hpp"

namespace assur {
namespace {

constexpr double kLeastMeetings = 4;  // meetings of threads within a solver: a factorisation and three solutions
constexpr double kAccurate = 1e-12;   // backward error of a solution in double, with a margin for growth

std::string too_inaccurate(const Shape& shape, const Strategy& s, const Scales& scales) {
  const double error = scales.model.backward_error(shape, s);
  return error > kAccurate ? "its solutions had a backward error of " + scientific(error, 1) : "";
}

// Reason why a GPU is not considered; "" if it is, or if the backend needs none. Asking a GPU takes 0.1 s at the first
// time, and no prior knows how fast it is. Without a driver, the backend answers at once.
std::string not_worth_asking(const Backend& backend, const Shape& shape, const PerformanceModel& model) {
  if (!backend.device || !cuda::why_no_driver().empty()) return "";
  if (shape.n < kWorthDevice) {
    return "a GPU is considered from " + std::to_string(kWorthDevice) + " unknowns on";
  }
  const Strategy plain{.run = {}, .solver = {.backend = std::string(backend.id)}};
  const bool unknown = model.kernel(Kernel::factor, shape, plain).origin == Origin::prior;
  return unknown ? "it was not measured on this machine; assur tune measures it where there is a GPU" : "";
}

// Reason why a backend cannot be used; "" if it can.
std::string refused(const Backend& backend, const Shape& shape, const Scales& scales) {
  if (std::find(scales.without.begin(), scales.without.end(), backend.id) != scales.without.end()) return "left out";
  if (std::string why_not = not_worth_asking(backend, shape, scales.model); !why_not.empty()) return why_not;
  if (std::string why_not = backend.why_not(shape, ThreadBudget{1}); !why_not.empty()) return why_not;
  return too_inaccurate(shape, {.run = {}, .solver = {.backend = std::string(backend.id)}}, scales);
}

// Time of one call for W groups: a step of a pack, or a matrix factorised and solved.
std::vector<Prediction> predict(const Shape& shape, std::span<const Strategy> ways, const PerformanceModel& model) {
  if (shape.terms > 0) return model.packs(shape, ways);
  std::vector<Prediction> all;
  for (const Strategy& s : ways) {
    const Prediction factor = model.kernel(Kernel::factor, shape, s), solve = model.kernel(Kernel::solve, shape, s);
    all.push_back({factor.seconds + shape.rhs * solve.seconds, std::max(factor.factor, solve.factor),
                   std::max(factor.origin, solve.origin)});
  }
  return all;
}

// Threads within a solver meet in the factorisation and in every solution of a step. Their times were measured in large
// groups, so they do not hold for groups that one thread solves before the threads could meet.
bool cannot_gain(const Strategy& s, const std::vector<Candidate>& weighed, const Scales& scales) {
  Strategy alone = s;
  alone.solver.threads = 1;
  const auto at = std::find_if(weighed.begin(), weighed.end(), [&](const Candidate& c) { return c.strategy == alone; });
  return at != weighed.end() && at->why_not.empty() &&
         at->expected_seconds <= kLeastMeetings * scales.model.meeting(s.solver.threads).seconds;
}

// The strategies of a backend that are worth weighing.
StrategySpace space_of(const Shape& shape, std::int32_t most_lanes, std::int32_t most_q) {
  StrategySpace space;
  space.lanes = powers_of_two(std::min(most_lanes, kMostLanes));
  space.threads = powers_of_two(most_q);
  space.policies = {{}, {.single = true}};
  if (shape.terms > 0) space.policies.insert(space.policies.end(), {{.once = true}, {.single = true, .once = true}});
  return space;
}

}  // namespace

double together(double makespan, double work, std::int32_t p, double contention) {
  return p < 2 ? makespan : makespan + (contention - 1) * (work - makespan) / (p - 1);
}

std::vector<Candidate> offers(const Shape& shape, std::int32_t most_lanes, std::int32_t most_q, const Scales& scales) {
  std::vector<Candidate> all;
  std::vector<std::string> without;
  for (const Backend& backend : scales.table) {
    std::string why_not = refused(backend, shape, scales);
    if (why_not.empty()) continue;
    all.push_back({.strategy = {.run = {}, .solver = {.backend = without.emplace_back(backend.id)}},
                   .why_not = std::move(why_not)});
  }
  std::vector<Strategy> ways = strategies(space_of(shape, most_lanes, most_q), {scales.table, shape, without});
  std::erase_if(ways, [&](const Strategy& s) {
    std::string why_not = too_inaccurate(shape, s, scales);
    const bool out = !why_not.empty();
    if (out) all.push_back({.strategy = s, .why_not = std::move(why_not)});
    return out;
  });
  const std::vector<Prediction> expected = predict(shape, ways, scales.model);
  for (std::size_t i = 0; i < ways.size(); ++i) {
    if (ways[i].solver.threads > 1 && cannot_gain(ways[i], all, scales)) continue;
    const Prediction& one = expected[i];
    all.push_back({.strategy = ways[i],
                   .expected_seconds = one.seconds,
                   .factor = one.factor,
                   .origin = one.origin,
                   .why_not = ""});
  }
  return all;
}

std::vector<Candidate> weigh(const std::vector<Candidate>& offers, std::span<const Load> loads, std::int32_t most_q,
                             const Scales& scales) {
  std::vector<Candidate> all;
  for (const Candidate& offer : offers) {
    const Strategy& s = offer.strategy;
    if (s.solver.threads > most_q) continue;
    double sum = 0;
    for (const Load& load : loads) {
      const std::int32_t threads = properties_of(s.solver.backend).takes_turns ? 1 : load.threads;
      const std::int32_t packs = (load.groups + s.solver.lanes - 1) / s.solver.lanes;
      const std::int32_t calls = (packs + threads - 1) / threads;
      sum += offer.expected_seconds *
             together(calls, packs, threads, scales.model.contention(threads * s.solver.threads, load.unknowns));
    }
    all.push_back(offer);
    all.back().expected_seconds = sum;
  }
  return all;
}

bool can_run(const Strategy& strategy, const Shape& shape, const Scales& scales) {
  const auto backend = std::find_if(scales.table.begin(), scales.table.end(),
                                    [&](const Backend& b) { return b.id == strategy.solver.backend; });
  return backend != scales.table.end() && refused(*backend, shape, scales).empty() &&
         backend->why_not(shape, ThreadBudget{strategy.solver.threads}).empty() &&
         too_inaccurate(shape, strategy, scales).empty();
}

void rank(std::vector<Candidate>& candidates, double tie) {
  std::stable_sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    if (a.why_not.empty() != b.why_not.empty()) return a.why_not.empty();
    return a.expected_seconds < b.expected_seconds;
  });
  if (candidates.empty() || !candidates[0].why_not.empty()) return;
  const double within = candidates[0].expected_seconds * (1 + tie);
  const auto end = std::find_if(candidates.begin(), candidates.end(),
                                [&](const Candidate& c) { return !c.why_not.empty() || c.expected_seconds > within; });
  const auto modesty = [](const Candidate& c) {
    return std::tuple(c.strategy.run.threads * c.strategy.solver.threads, c.strategy.solver.single,
                      c.strategy.solver.once);
  };
  const auto best = std::min_element(candidates.begin(), end,
                                     [&](const Candidate& a, const Candidate& b) { return modesty(a) < modesty(b); });
  std::rotate(candidates.begin(), best, best + 1);
}

void check_names(std::span<const std::string> without, std::span<const Backend> table) {
  for (const std::string& id : without) (void)find_backend(table, id);
}

std::vector<Candidate> candidates(const Shape& shape, const CandidateOptions& options) {
  check_names(options.without, backends());
  const std::shared_ptr<const PerformanceModel> model = options.model ? options.model : machine_model().model;
  const std::int32_t budget = std::max(1, (options.budget ? *options.budget : available_budget()).threads);
  const Scales scales{*model, backends(), options.without};
  const std::vector<Candidate> offered = offers(shape, 2 * shape.groups - 1, budget, scales);
  std::vector<Candidate> all;
  for (std::int32_t p = 1; p <= std::min(budget, shape.groups); p *= 2) {
    const Load load{shape.groups, p, shape.n};
    for (Candidate& c : weigh(offered, {&load, 1}, budget / p, scales)) {
      if (p > 1 && !c.why_not.empty()) continue;  // reported once
      if (p > 1 && properties_of(c.strategy.solver.backend).takes_turns) continue;
      c.strategy.run.threads = p;
      c.strategy.run.formulation = Formulation::irreducible;
      if (c.why_not.empty()) c.expected_seconds += model->meeting(p).seconds;
      all.push_back(std::move(c));
    }
  }
  rank(all, scales.tie);
  return all;
}

Candidate choose_solver(const Pattern& pattern, std::int32_t count, std::int32_t rhs, const CandidateOptions& options) {
  if (count < 1 || rhs < 0) {
    throw Error(Error::Kind::input, "choose_solver needs at least one matrix and 0 or more right-hand sides, not " +
                                        std::to_string(count) + " and " + std::to_string(rhs));
  }
  Shape shape = shape_of(pattern, count);
  shape.rhs = rhs;
  std::vector<Candidate> all = candidates(shape, options);
  std::erase_if(all, [](const Candidate& c) { return c.strategy.solver.single; });  // Backend::make() would not refine
  if (all.empty() || !all[0].why_not.empty()) {
    std::string reasons;
    for (const Candidate& c : all) reasons += "; " + c.strategy.solver.backend + ": " + c.why_not;
    throw Error(Error::Kind::environment, "no backend can solve these systems" + reasons);
  }
  return std::move(all[0]);
}

}  // namespace assur
