#include "commands/plan_report.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "dispatch/dispatcher.hpp"
#include "index.hpp"
#include "output/format.hpp"
#include "plan/preparation.hpp"

namespace assur::output {
namespace {

constexpr std::size_t kMostClasses = 12;  // further ones are only counted
constexpr std::size_t kMostCandidates = 6;
constexpr std::size_t kMostOfBest = 3;  // candidates of the best backend

// The levels with groups of each class.
std::vector<std::set<std::int32_t>> levels_of_classes(const GroupedSystem& s) {
  std::vector<std::set<std::int32_t>> levels(s.classes.size());
  for (const SolvedGroup& g : s.groups) levels[idx(g.group_class)].insert(g.level);
  return levels;
}

std::string range_text(const std::set<std::int32_t>& levels) {
  if (levels.empty()) return "-";
  if (levels.size() == 1) return std::to_string(*levels.begin());
  return std::to_string(*levels.begin()) + "-" + std::to_string(*levels.rbegin());
}

std::int32_t threads_of(const Plan& plan, std::int32_t level) {
  return plan.level_threads.empty() ? plan.run.threads : plan.level_threads[idx(level)];
}

// "2 on 3 of 5 levels"
std::string threads_text(const Plan& plan, const GroupedSystem& s) {
  if (plan.run.threads == 1) return "1";
  std::int32_t shared = 0;
  for (std::int32_t level = 0; level < s.levels; ++level) shared += threads_of(plan, level) > 1 ? 1 : 0;
  return std::to_string(plan.run.threads) + " on " + grouped(shared) + " of " + counted(s.levels, "level");
}

// In mode throughput, the lanes of a class are those of mechanisms side by side.
Strategy strategy_of(const PlanSummary& s, const Plan::Choice& c) {
  Strategy strategy = s.prepared.plan().strategy(c);
  if (s.mode == Mode::throughput) strategy.solver.lanes = s.prepared.plan().lanes;
  return strategy;
}

BesideGroups beside_groups_of(const PlanSummary& s) {
  const Plan& plan = s.prepared.plan();
  const auto& p = plan.level_threads;
  const bool alone = !p.empty() && std::all_of(p.begin(), p.end(), [](std::int32_t threads) { return threads == 1; });
  return beside_groups(*preparation(s.prepared).structure, s.model,
                       alone || s.mode == Mode::throughput ? 1 : plan.run.threads);
}

void print_expected(Page& page, const PlanSummary& s) {
  const BesideGroups beside = beside_groups_of(s);
  const double groups = std::max(s.prepared.plan().expected_seconds - beside.around, 0.0);
  page.fact("expected", duration(s.prepared.plan().expected_seconds) +
                            (s.mode == Mode::throughput ? " for a step of one mechanism" : " for a step"));
  // Measured whole steps may be faster than the sum of their parts.
  const std::string others = "laws, predictions, " + counted(beside.outputs, "output");
  page.fact("",
            groups > 0 ? duration(groups) + " groups; " + duration(beside.around) + " " + others : "groups, " + others);
  page.fact("", "a run that stores its rows takes " + duration(beside.storing) + " more for each");
}

void print_classes(Page& page, const PlanSummary& s) {
  using enum Table::Align;
  const Plan& plan = s.prepared.plan();
  const auto levels = levels_of_classes(*preparation(s.prepared).structure);
  Table table({left, right, right, right, left, right, left});
  table.row({"class", "level", "groups", "unknowns", "strategy", "pack", "origin"});
  for (const Plan::Choice& c : plan.choices) {
    if (idx(c.group_class) == kMostClasses) break;
    const Strategy shown{
        {.formulation = plan.run.formulation, .together = plan.run.together, .chunks = plan.run.chunks},
        strategy_of(s, c).solver};  // the rest is the same for all
    table.row({std::to_string(c.group_class), range_text(levels[idx(c.group_class)]), grouped(c.shape.groups),
               grouped(c.shape.n), to_string(shown), duration(c.expected_seconds), std::string(name(c.origin))});
  }
  page.table(table);
  if (plan.choices.size() > kMostClasses) {
    page.fact("", "and " + grouped(plan.choices.size() - kMostClasses) + " more classes");
  }
}

// The best candidate of each backend, also those with the next best lanes or threads of the best backend, and why
// others cannot run.
void print_candidates(Page& page, std::int32_t group_class, bool one_level, const std::vector<Candidate>& candidates) {
  using enum Table::Align;
  page.gap();
  page.fact("class " + std::to_string(group_class),
            std::string("all candidates, time for all its groups") + (one_level ? "" : " as if on one level"));
  Table table({left, right, right, left});
  std::map<std::string, std::size_t> seen;
  for (const Candidate& c : candidates) {
    const std::string& backend = c.strategy.solver.backend;
    const std::size_t before = seen[backend + (c.why_not.empty() ? "" : "!")]++;
    const bool is_best = backend == candidates.front().strategy.solver.backend;
    if (before >= (is_best ? kMostOfBest : 1) || seen.size() > kMostCandidates) continue;
    if (c.why_not.empty()) {
      table.row({to_string(c.strategy), duration(c.expected_seconds),
                 fixed(c.expected_seconds / candidates.front().expected_seconds) + "x",
                 std::string(name(c.origin)) + ", within a factor of " + fixed(c.factor)});
    } else {
      table.row({c.strategy.solver.backend, "-", "-", c.why_not});
    }
  }
  page.table(table);
}

Json json_of(const Candidate& c, std::size_t group_class) {
  const bool runs = c.why_not.empty();
  return {{"class", group_class},
          {"strategy", to_string(c.strategy)},
          {"expected_seconds", or_null(runs, c.expected_seconds)},
          {"factor", or_null(runs, c.factor)},
          {"origin", or_null(runs, name(c.origin))},
          {"why_not", c.why_not}};
}

}  // namespace

Json to_json(const PlanSummary& s) {
  const Plan& plan = s.prepared.plan();
  const GroupedSystem& structure = *preparation(s.prepared).structure;
  Json levels = Json::array();
  for (std::int32_t level = 0; level < structure.levels; ++level) {
    levels.push_back({{"level", level}, {"p", threads_of(plan, level)}});
  }
  const auto levels_of = levels_of_classes(structure);
  Json classes = Json::array(), candidates = Json::array();
  for (const Plan::Choice& c : plan.choices) {
    const auto& on = levels_of[idx(c.group_class)];
    classes.push_back({{"class", c.group_class},
                       {"level", on.empty() ? Json(nullptr) : Json(*on.begin())},
                       {"levels", on},
                       {"groups", c.shape.groups},
                       {"n", c.shape.n},
                       {"nnz", c.shape.nnz},
                       {"fill", c.shape.fill},
                       {"strategy", to_string(strategy_of(s, c))},
                       {"expected_seconds", c.expected_seconds},
                       {"origin", name(c.origin)},
                       {"reason", c.reason}});
  }
  for (std::size_t k = 0; k < s.candidates.size(); ++k) {
    for (const Candidate& c : s.candidates[k]) candidates.push_back(json_of(c, k));
  }
  const BesideGroups beside = beside_groups_of(s);
  return {{"scene", s.prepared.scene()->name()},
          {"mode", s.mode == Mode::latency ? "latency" : "throughput"},
          {"accuracy", plan.accuracy},
          {"formulation", name(plan.run.formulation)},
          {"budget", s.budget.threads},
          {"threads", plan.run.threads},
          {"lanes", plan.lanes},
          {"chunks", plan.run.chunks},
          {"expected_seconds", plan.expected_seconds},
          {"expected_around_seconds", beside.around},
          {"expected_storing_seconds", beside.storing},
          {"outputs", beside.outputs},
          {"reason", plan.reason},
          {"machine_code", or_null(s.machine_code)},
          {"samples", s.model.samples()},
          {"source", s.model.source()},
          {"messages", s.messages},
          {"levels", std::move(levels)},
          {"classes", std::move(classes)},
          {"candidates", std::move(candidates)}};
}

void print(Page& page, const PlanSummary& s) {
  const Plan& plan = s.prepared.plan();
  page.title(s.prepared.scene()->name());
  page.fact("known", s.model.samples() == 0 ? "no samples of this machine; run assur tune"
                                            : counted(s.model.samples(), "sample") + ", " + s.model.source());
  for (const std::string& message : s.messages) page.fact("", message);
  page.gap();
  page.fact("formulation", name(plan.run.formulation));
  page.fact("threads", threads_text(plan, *preparation(s.prepared).structure) + "; " + plan.reason);
  if (s.mode == Mode::throughput) page.fact("chunks", grouped(plan.run.chunks) + " of the time grid");
  if (s.machine_code) page.fact("machine code", s.machine_code->empty() ? "none" : *s.machine_code);
  print_expected(page, s);
  page.gap();
  if (plan.choices.empty()) {
    page.fact("classes", "nothing has to be solved");
    return;
  }
  print_classes(page, s);
  page.gap();
  for (const Plan::Choice& c : plan.choices) {
    if (idx(c.group_class) == kMostClasses) break;
    page.fact(c.group_class == 0 ? "reason" : "", "class " + std::to_string(c.group_class) + ": " + c.reason);
  }
  const auto levels = levels_of_classes(*preparation(s.prepared).structure);
  for (std::size_t k = 0; k < std::min(s.candidates.size(), kMostClasses); ++k) {
    print_candidates(page, static_cast<std::int32_t>(k), levels[k].size() == 1, s.candidates[k]);
  }
}

}  // namespace assur::output
