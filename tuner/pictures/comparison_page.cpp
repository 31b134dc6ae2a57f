#include "pictures/comparison_page.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "numbers.hpp"
#include "output/format.hpp"
#include "pictures/plot.hpp"
#include "pictures/ticks.hpp"

namespace assur::pictures {
namespace {

using measure::Knob;
using measure::WorkPrecisionRow;
using output::ComparisonSummary;
using output::error_figure;

// Errors of 0 are drawn at half the precision of a double.
constexpr double kLeastError = kEps / 2;

struct Kind {
  Knob knob;
  const char* name;
  Series::Mark mark;
};
constexpr std::array kKinds = {Kind{Knob::solver, "solver, threads", Series::Mark::dot},
                               Kind{Knob::predictor, "predictor", Series::Mark::triangle},
                               Kind{Knob::iterations, "fixed iterations", Series::Mark::cross},
                               Kind{Knob::precision, "float, refinement", Series::Mark::square},
                               Kind{Knob::policy, "factorisations", Series::Mark::plus}};

bool is_shown(const WorkPrecisionRow& row) { return row.seconds && row.error; }

double error_shown(const WorkPrecisionRow& row) { return std::max(row.worst_error(), kLeastError); }

Point point(const WorkPrecisionRow& row) {
  return {error_shown(row), *row.seconds,
          output::way_text(row) + ": " + output::duration(*row.seconds) + ", " + error_figure(row.worst_error())};
}

// The Pareto front, from the smallest error on.
std::vector<const WorkPrecisionRow*> front_of(const ComparisonSummary& s) {
  std::vector<const WorkPrecisionRow*> front;
  for (const WorkPrecisionRow& row : s.result.rows) {
    if (row.on_front) front.push_back(&row);
  }
  std::reverse(front.begin(), front.end());  // the rows begin with the fastest strategy
  return front;
}

// Curves through the points of one strategy, over accuracies or numbers of iterations.
std::vector<Series> curves(const ComparisonSummary& s, Knob knob, int colour) {
  std::map<std::string, Series> by_strategy;
  for (const WorkPrecisionRow& row : s.result.rows) {
    if (is_shown(row) && row.knob == knob) by_strategy[row.strategy].points.push_back(point(row));
  }
  std::vector<Series> all;
  for (auto& [strategy, curve] : by_strategy) {
    if (curve.points.size() < 2) continue;
    std::sort(curve.points.begin(), curve.points.end(), [](const Point& a, const Point& b) { return a.x < b.x; });
    curve.colour = colour;
    curve.mark = Series::Mark::none;
    curve.line = Series::Line::straight;
    all.push_back(std::move(curve));
  }
  return all;
}

HtmlTable table_of_rows(const ComparisonSummary& s) {
  using enum HtmlTable::Column;
  HtmlTable table{{"front", "strategy", "auto for", "step", "spread", "rounds", "position", "velocity", "acceleration",
                   "estimate", "status"},
                  {number, text, words, number, number, number, number, number, number, number, words},
                  {}};
  const std::vector<const WorkPrecisionRow*> front = front_of(s);
  for (const WorkPrecisionRow& row : s.result.rows) {
    const auto at = std::find(front.begin(), front.end(), &row);
    const auto error = [&](double ForwardError::*which) { return row.error ? error_figure((*row.error).*which) : "-"; };
    std::string asked;
    for (const double a : row.picked) asked += (asked.empty() ? "" : ", ") + power_of_ten(a);
    table.rows.push_back(
        {{at == front.end() ? "" : std::to_string(at - front.begin() + 1), output::way_text(row), asked,
          row.seconds ? output::duration(*row.seconds) : "-", row.seconds ? output::duration(row.spread) : "-",
          std::to_string(row.rounds), error(&ForwardError::position), error(&ForwardError::velocity),
          error(&ForwardError::acceleration), error_figure(row.estimated), row.status},
         row.on_front ? "strong" : ""});
  }
  return table;
}

Plot work_precision_plot(const ComparisonSummary& s) {
  Plot plot;
  plot.title = s.scene + ": time of a step against true error";
  plot.x = {"largest of the three true errors", true, power_of_ten};
  plot.y = {"time of one step", true, time_text};
  for (const double a : s.accuracies) plot.guides.push_back({a, power_of_ten(a)});

  Series front{.name = "Pareto front",
               .points = {},
               .colour = Series::kInk,
               .mark = Series::Mark::none,
               .line = Series::Line::steps};
  for (const WorkPrecisionRow* row : front_of(s)) {
    front.points.push_back(point(*row));
    front.points.back().label = std::to_string(front.points.size());
  }
  plot.series.push_back(std::move(front));
  for (std::size_t k = 0; k < kKinds.size(); ++k) {
    Series series{.name = kKinds[k].name, .points = {}, .colour = static_cast<int>(k), .mark = kKinds[k].mark};
    for (const WorkPrecisionRow& row : s.result.rows) {
      if (is_shown(row) && row.knob == kKinds[k].knob) series.points.push_back(point(row));
    }
    if (series.points.empty()) continue;
    for (Series& curve : curves(s, kKinds[k].knob, series.colour)) plot.series.push_back(std::move(curve));
    plot.series.push_back(std::move(series));
  }
  Series picks{.name = "choices of auto", .points = {}, .colour = Series::kInk, .mark = Series::Mark::diamond};
  for (const WorkPrecisionRow& row : s.result.rows) {
    if (is_shown(row) && !row.picked.empty()) picks.points.push_back(point(row));
  }
  if (!picks.points.empty()) plot.series.push_back(std::move(picks));
  return plot;
}

}  // namespace

std::string work_precision_figure(const ComparisonSummary& s) {
  if (s.result.no_yardstick.empty()) return figure(work_precision_plot(s));
  return paragraph("There is no picture, because true errors are unknown: " + s.result.no_yardstick, "notice");
}

HtmlTable table_of_verdicts(const ComparisonSummary& s) {
  using enum HtmlTable::Column;
  HtmlTable table{{"required", "reached", "step", "auto", "strategy"}, {number, number, number, words, text}, {}};
  for (const double a : s.accuracies) {
    const output::Verdict v = output::verdict(s.result, a);
    table.rows.push_back({{power_of_ten(a), v.reached, v.step, v.words, v.strategy}});
  }
  return table;
}

std::string comparison_page(const ComparisonSummary& s, const std::vector<std::string>& origin) {
  const std::string title = s.scene + ": error against run time";
  std::vector<std::string> lines = {output::counted(s.result.steps, "step") + " of " + output::number(s.step) + " s."};
  lines.insert(lines.end(), origin.begin(), origin.end());
  std::string body = "<h1>" + escaped(title) + "</h1>\n" + paragraph(lines, "faint") + work_precision_figure(s);
  if (s.result.no_yardstick.empty()) {
    body += paragraph("Dotted lines: accuracies required of auto. Numbers: the Pareto front, as in the last table.",
                      "faint");
  }
  if (!s.accuracies.empty()) body += "<h2>Choices of auto for each accuracy</h2>\n" + html(table_of_verdicts(s));
  body += "<h2>All strategies, the fastest first</h2>\n" + html(table_of_rows(s));
  body += paragraph(
      "Errors: largest of the run against a solution in quadruple precision, as defined in docs/accuracy.md. "
      "Estimate: largest estimated error of the run. Times: medians over rounds, in each of which all strategies are "
      "timed in turn; spread: their median absolute deviation.",
      "faint");
  return html_page(title, plot_style(), body);
}

}  // namespace assur::pictures
