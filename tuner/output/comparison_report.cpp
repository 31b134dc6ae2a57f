#include "output/comparison_report.hpp"

#include <algorithm>
#include <cmath>

#include "output/format.hpp"

namespace assur::output {
namespace {

using measure::WorkPrecision;
using measure::WorkPrecisionRow;

constexpr double kSmallShare = 0.005;  // times with a smaller relative difference are equal

Json to_json(const WorkPrecision& result, const WorkPrecisionRow& row, double accuracy) {
  const bool picked = std::find(row.picked.begin(), row.picked.end(), accuracy) != row.picked.end();
  const auto error = [&](double ForwardError::*which) { return row.error ? Json((*row.error).*which) : Json(nullptr); };
  return {{"strategy", row.strategy},
          {"iterations", or_null(row.iterations > 0, row.iterations)},
          {"knob", row.knob ? Json(measure::name(*row.knob)) : Json(nullptr)},
          {"accuracy", or_null(accuracy > 0, accuracy)},
          {"seconds_per_step", or_null(row.seconds)},
          {"spread", or_null(row.seconds && row.rounds > 1, row.spread)},
          {"rounds", row.rounds},
          {"forward_position", error(&ForwardError::position)},
          {"forward_velocity", error(&ForwardError::velocity)},
          {"forward_acceleration", error(&ForwardError::acceleration)},
          {"estimated", or_null(row.estimated)},
          {"on_front", row.on_front},
          {"picked", picked},
          {"behind", picked ? or_null(result.behind(accuracy)) : Json(nullptr)},
          {"status", row.status}};
}

void print_rows(Page& page, const WorkPrecision& result) {
  using enum Table::Align;
  Table table({right, right, right, right, right, left, left});
  table.row({"step", "position", "velocity", "acceleration", "estimate", "", "strategy"});
  for (const WorkPrecisionRow& row : result.rows) {
    if (!row.seconds) continue;
    const auto error = [&](double ForwardError::*which) { return row.error ? error_figure((*row.error).*which) : "-"; };
    table.row({duration(*row.seconds), error(&ForwardError::position), error(&ForwardError::velocity),
               error(&ForwardError::acceleration), error_figure(row.estimated), row.on_front ? "front" : "",
               way_text(row) + (row.picked.empty() ? "" : "  <- auto " + accuracies_text(row.picked))});
  }
  page.table(table);
}

void print_failures(Page& page, const WorkPrecision& result) {
  std::vector<std::string> failures;
  for (const WorkPrecisionRow& row : result.rows) {
    if (!row.seconds) failures.push_back(way_text(row) + ": " + row.status);
  }
  if (failures.empty()) return;
  page.gap();
  page.list(result.interrupted ? "not timed" : "failed", failures);
}

void print_verdicts(Page& page, const ComparisonSummary& s) {
  using enum Table::Align;
  if (s.accuracies.empty()) return;
  Table table({left, right, right, left});
  table.row({"auto, required", "reached", "step", ""});
  for (const double a : s.accuracies) {
    const Verdict v = verdict(s.result, a);
    table.row({number(a), v.reached, v.step, v.words});
  }
  page.gap();
  page.table(table);
}

}  // namespace

std::string accuracies_text(const std::vector<double>& accuracies) {
  std::string text;
  for (const double a : accuracies) text += (text.empty() ? "" : ",") + number(a);
  return text;
}

std::string way_text(const WorkPrecisionRow& row) {
  const bool as_exact_as_can_be = std::find(row.accuracies.begin(), row.accuracies.end(), 0.0) != row.accuracies.end();
  return row.strategy + (row.iterations > 0 ? " --iterations " + std::to_string(row.iterations) : "") +
         (as_exact_as_can_be ? "" : " --accuracy " + accuracies_text(row.accuracies));
}

Verdict verdict(const WorkPrecision& result, double accuracy) {
  const WorkPrecisionRow* const row = result.pick(accuracy);
  if (row == nullptr) return {"-", "-", "-", "not examined"};
  Verdict v{row->strategy, "-", "-", ""};
  if (row->error) v.reached = error_figure(row->worst_error());
  if (!row->seconds) {
    v.words = row->status == "ok" ? "not timed" : row->status;
    return v;
  }
  v.step = duration(*row->seconds);
  if (!row->error) {
    v.words = "true error unknown";
  } else if (const std::optional<double> behind = result.behind(accuracy); !behind) {
    v.words = "misses the accuracy";
  } else if (*behind < kSmallShare) {
    v.words = "fastest that reaches it";
  } else {
    v.words = number(std::round(100 * *behind)) + " % slower than " + way_text(*result.fastest_within(accuracy));
  }
  return v;
}

Json to_json(const ComparisonSummary& s) {
  Json rows = Json::array();
  for (const WorkPrecisionRow& row : s.result.rows) {
    for (const double a : row.accuracies) rows.push_back(to_json(s.result, row, a));
  }
  return {{"scene", s.scene},
          {"steps", s.result.steps},
          {"dt", s.step},
          {"accuracies", s.accuracies},
          {"no_yardstick", or_null(s.result.no_yardstick)},
          {"interrupted", s.result.interrupted},
          {"rows", std::move(rows)}};
}

void print(Page& page, const ComparisonSummary& s) {
  page.title(s.scene + ": true error against time, " + counted(s.result.steps, "step") + " of " + number(s.step) +
             " s");
  page.gap();
  print_rows(page, s.result);
  print_failures(page, s.result);
  print_verdicts(page, s);
  if (!s.result.no_yardstick.empty()) {
    page.gap();
    page.fact("true error", "unknown: " + s.result.no_yardstick);
  }
  if (s.result.interrupted) page.fact("interrupted", "the results so far are shown");
}

}  // namespace assur::output
