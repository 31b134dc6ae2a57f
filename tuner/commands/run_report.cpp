#include "commands/run_report.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "commands/left_out.hpp"
#include "output/format.hpp"
#include "output/notes.hpp"
#include "plan/preparation.hpp"
#include "status_text.hpp"

namespace assur::output {
namespace {

constexpr std::size_t kMostRows = 12;  // further classes are summarised

// Empty if nothing was solved.
std::optional<double> mean_iterations(const Counters& c) {
  if (c.group_solutions == 0) return std::nullopt;
  return static_cast<double>(c.newton_iterations) / static_cast<double>(c.group_solutions);
}

// The strategy of a class. Lanes hold mechanisms if these run side by side, and else groups of the class.
Strategy strategy_of(const Plan::Choice& choice, const RunSummary& s) {
  Strategy strategy = s.prepared.plan().strategy(choice);
  if (s.mode == Mode::throughput) strategy.solver.lanes = s.prepared.plan().lanes;
  return strategy;
}

// Classes with the same strategy for the same reason.
struct PlanLine {
  std::vector<std::int32_t> classes;
  std::int64_t groups = 0;
  std::int32_t least = 0, most = 0;  // unknowns
  std::string strategy, reason;
};

std::vector<PlanLine> plan_lines(const RunSummary& s) {
  const Plan& plan = s.prepared.plan();
  std::vector<PlanLine> lines;
  std::map<std::pair<std::string, std::string>, std::size_t> place;
  const bool one_each = plan.choices.size() <= kMostRows;
  for (const Plan::Choice& c : plan.choices) {
    const std::string strategy = to_string(strategy_of(c, s));
    const auto [at, is_new] = place.try_emplace({strategy, c.reason}, lines.size());
    if (is_new || one_each) {
      at->second = lines.size();
      lines.push_back({{}, 0, c.shape.n, c.shape.n, strategy, c.reason});
    }
    PlanLine& line = lines[at->second];
    line.classes.push_back(c.group_class);
    line.groups += c.shape.groups;
    line.least = std::min(line.least, c.shape.n);
    line.most = std::max(line.most, c.shape.n);
  }
  return lines;
}

void print_plan(Page& page, const RunSummary& s) {
  using enum Table::Align;
  const std::vector<PlanLine> lines = plan_lines(s);
  page.gap();
  if (lines.empty()) {
    page.fact("plan", "nothing has to be solved");
    return;
  }
  Table table({left, right, right, left});
  table.row({"class", "groups", "unknowns", "strategy"});
  for (const PlanLine& line : lines) {
    table.row(
        {line.classes.size() == 1 ? std::to_string(line.classes.front()) : grouped(line.classes.size()) + " classes",
         grouped(line.groups),
         line.least == line.most ? grouped(line.most) : grouped(line.least) + "-" + grouped(line.most), line.strategy});
  }
  page.table(table);
  page.gap();
  std::map<std::string, std::vector<std::string>> by_reason;
  for (const PlanLine& line : lines) {
    for (const std::int32_t c : line.classes) by_reason[line.reason].push_back(std::to_string(c));
  }
  std::string_view label = "reason";
  for (const auto& [reason, classes] : by_reason) {
    page.fact(label, by_reason.size() == 1 ? reason : "class " + listed(classes, kMostRows) + ": " + reason);
    label = "";
  }
}

void print_times(Page& page, const RunSummary& s) {
  if (s.members != nullptr) page.fact("prepared", "in " + duration(s.prepare_seconds));
  page.fact("time", duration(s.seconds) + " for " +
                        (s.members != nullptr ? grouped(s.steps) + " steps of members" : counted(s.steps, "step")));
  if (s.mode == Mode::throughput && s.steps > 0) {
    page.fact("step",
              duration(s.mean_step()) + (s.members != nullptr ? " of one member" : "") + ", the mean of the whole run");
  }
  if (!s.step_seconds) return;
  const auto& f = *s.step_seconds;
  page.fact("step", duration(f.median) + " median, " + duration(f.p99) + " p99, " + duration(f.max) + " max" +
                        (f.block > 1 ? " (means of " + std::to_string(f.block) + " steps)" : ""));
}

void print_work(Page& page, const Counters& c) {
  const std::optional<double> mean = mean_iterations(c);
  page.fact("Newton", mean ? fixed(*mean) + " iterations mean, " + grouped(c.most_iterations) + " max" : "-");
  page.fact("factorizations", grouped(c.factorizations));
  if (c.rejected > 0) page.fact("substeps", grouped(c.substeps) + " accepted, " + grouped(c.rejected) + " halved");
}

void print_errors(Page& page, const ErrorFigures& e) {
  using enum Table::Align;
  Table table({left, right, right, right});
  const auto label = [](std::string text) { return text.append(16 - text.size(), ' '); };
  table.row({label("error"), "position", "velocity", "acceleration"});
  table.row({label("  residual"), error_figure(e.position), error_figure(e.velocity), error_figure(e.acceleration)});
  const auto row = [&](const char* what, const auto& position, const auto& velocity, const auto& acceleration) {
    if (!position && !velocity && !acceleration) return;
    table.row({label(what), error_figure(position), error_figure(velocity), error_figure(acceleration)});
  };
  row("  estimated", e.estimated_position, e.estimated_velocity, e.estimated_acceleration);
  row("  forward", e.forward_position, e.forward_velocity, e.forward_acceleration);
  page.gap();
  page.table(table);
  page.gap();
}

void print_certificate(Page& page, const Certificate& c) {
  if (c.why_not.empty() && c.group.empty()) {
    page.fact("certified", "nothing has to be solved");
    return page.gap();
  }
  const std::string where = "at t = " + number(c.time) + " s" + (c.group.empty() ? "" : ", group " + c.group);
  if (c.why_not.empty()) {
    page.fact("certified",
              "error at most " + error_figure(c.radius) + " characteristic lengths, " + where +
                  (std::isfinite(c.uniqueness) ? "; no other posture within " + error_figure(c.uniqueness) : ""));
  } else {
    page.fact("certified", "no, " + where + ": " + c.why_not);
  }
  page.gap();
}

std::string status_of(const RunSummary& s) {
  const Code code = s.report.status.code;
  if (code == Code::ok) return "done";
  if (s.members != nullptr && code != Code::interrupted) {
    return s.members->failures();
  }
  if (code == Code::inaccurate && s.members == nullptr) {
    const double asked = s.prepared.plan().accuracy;
    return "done, but inaccurate: estimated errors are " +
           (asked > 0 ? "above the required " + number(asked) : std::string("large"));
  }
  return std::string(name(code)) + " after " + counted(s.steps, "step") +
         (s.members != nullptr ? " of members" : ", at t = " + number(s.report.reached) + " s");
}

Json to_json(const Event& e) {
  Json out = {{"time", e.time},       {"until", e.until},   {"group", e.group},
              {"kind", name(e.kind)}, {"figure", e.figure}, {"unit", e.unit}};
  if (!e.detail.empty()) out["detail"] = e.detail;
  return out;
}

// Infinite numbers and NaN become null.
Json to_json(const Certificate& c) {
  return {
      {"radius", c.radius}, {"uniqueness", c.uniqueness}, {"time", c.time}, {"group", c.group}, {"why_not", c.why_not}};
}

// Adds the keys of an ensemble; its events name their members.
void add_members(Json& out, const RunSummary& s) {
  out["members"] = s.members->all;
  out["alone"] = s.members->alone;
  out["failed"] = to_json(s.members->failed);
  out["prepare_seconds"] = s.prepare_seconds;
  for (const auto& [member, event, is_told] : s.members->events) {
    Json item = to_json(event);
    item["member"] = member;
    out["events"].push_back(std::move(item));
  }
}

void print_events(Page& page, const Report& report) {
  std::vector<std::string> events;
  for (const Event& e : report.events) {
    events.push_back(time_of(e) + place_of(e) + ": " + explained(e.kind) + (e.detail.empty() ? "" : ": " + e.detail));
  }
  page.list("events", events);
  page.list("fallbacks", report.fallbacks);
}

}  // namespace

Json to_json(const RunSummary& s) {
  Json plan = Json::array();
  for (const Plan::Choice& c : s.prepared.plan().choices) {
    plan.push_back({{"class", c.group_class},
                    {"n", c.shape.n},
                    {"groups", c.shape.groups},
                    {"strategy", to_string(strategy_of(c, s))},
                    {"reason", c.reason}});
  }
  Json step_seconds = {{"median", nullptr}, {"p99", nullptr}, {"max", nullptr}, {"block", 1}};
  if (s.mode == Mode::throughput) step_seconds["mean"] = or_null(s.steps > 0, s.mean_step());
  if (s.step_seconds) {
    const auto& f = *s.step_seconds;
    step_seconds = {{"median", f.median}, {"p99", f.p99}, {"max", f.max}, {"block", f.block}};
  }
  Json events = Json::array();
  for (const Event& e : s.report.events) {
    events.push_back(to_json(e));
  }
  const Counters& c = s.report.counters;
  const ErrorFigures& e = s.report.error;
  Json out = {{"scene", s.prepared.scene()->name()},
              {"mode", s.mode == Mode::throughput ? "throughput" : "latency"},
              {"strategy", s.strategy},
              {"plan", std::move(plan)},
              {"steps", s.steps},
              {"seconds", s.seconds},
              {"step_seconds", std::move(step_seconds)},
              {"newton_iterations",
               {{"mean", or_null(mean_iterations(c))}, {"max", or_null(c.group_solutions > 0, c.most_iterations)}}},
              {"factorizations", c.factorizations},
              {"substeps", c.substeps},
              {"rejected", c.rejected},
              {"error",
               {{"position", e.position},  // NaN is null
                {"velocity", e.velocity},
                {"acceleration", e.acceleration},
                {"estimated_position", or_null(e.estimated_position)},
                {"estimated_velocity", or_null(e.estimated_velocity)},
                {"estimated_acceleration", or_null(e.estimated_acceleration)},
                {"forward_position", or_null(e.forward_position)},
                {"forward_velocity", or_null(e.forward_velocity)},
                {"forward_acceleration", or_null(e.forward_acceleration)},
                {"certified_radius", or_null(e.certified_radius)}}},
              {"certificate", s.certificate ? to_json(*s.certificate) : Json(nullptr)},
              {"left_out",
               to_json(preparation(s.prepared).structure->left_out, preparation(s.prepared).structure->formulation)},
              {"status", name(s.report.status.code)},
              {"reached", s.report.reached},
              {"notes", to_json(notes(*s.prepared.scene(), *preparation(s.prepared).structure))},
              {"events", std::move(events)},
              {"fallbacks", s.report.fallbacks}};
  if (s.members != nullptr) add_members(out, s);
  return out;
}

void print(Page& page, const RunSummary& s) {
  const TimeGrid& time = s.prepared.scene()->time();
  page.title(s.prepared.scene()->name() + ": " +
             (s.members != nullptr ? counted(s.members->all, "member") + ", " : std::string()) +
             counted(s.steps_wanted, "step") + " of " + number(time.step) + " s from t = " + number(time.start) + " s");
  print_plan(page, s);
  if (s.members != nullptr) print_counts(page, *s.members);
  print_times(page, s);
  print_work(page, s.report.counters);
  print_errors(page, s.report.error);
  if (s.certificate) print_certificate(page, *s.certificate);
  print(page, preparation(s.prepared).structure->left_out, preparation(s.prepared).structure->formulation);
  print_notes(page, *s.prepared.scene(), *preparation(s.prepared).structure);
  if (s.members != nullptr) print_outcomes(page, *s.members);
  print_events(page, s.report);
  page.fact("status", status_of(s));
}

}  // namespace assur::output
