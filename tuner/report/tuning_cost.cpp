#include <array>

#include "output/format.hpp"
#include "pictures/plot.hpp"
#include "report/sections.hpp"
#include "tuning/replay.hpp"

namespace assur::report {
namespace {

constexpr int kStages = 20;  // points of the curve: the model after each twentieth of the samples

}  // namespace

Section tuning_cost(const Knowledge& knowledge, const Conditions&) {
  Section out{"tuning-cost", "Cost and benefit of tuning"};
  if (!knowledge.tuning) {
    out.body = paragraph("There is no finished tuning run of this machine.", "notice");
    return out;
  }
  const db::Run& run = knowledge.tuning->run;
  const std::vector<tuning::Stage> stages = tuning::replay(tuning::cells_of(knowledge.tuning->samples), kStages);
  if (stages.empty() || stages.back().regret.questions == 0) {
    out.body = paragraph("The tuning run has no held-out cells to judge its choices.", "notice");
    return out;
  }
  pictures::Plot plot;
  plot.title = "Held-out regret over seconds of tuning";
  plot.x = {"tuning so far", false, [](double s) { return output::number(s) + " s"; }};
  plot.y = {"regret of auto on held-out cells, %", true, [](double value) { return output::number(value) + " %"; }};
  using pictures::Series;
  struct Line {
    const char *name, *quantity;
    double tuning::Regret::*regret;
    int colour;
    Series::Mark mark;
  };
  constexpr std::array kLines = {
      Line{"mean", "held-out regret, mean", &tuning::Regret::mean, 0, Series::Mark::dot},
      Line{"95th percentile", "held-out regret, p95", &tuning::Regret::p95, 1, Series::Mark::square},
      Line{"max", "held-out regret, max", &tuning::Regret::max, 4, Series::Mark::triangle}};
  for (const Line& l : kLines) plot.series.push_back({l.name, {}, l.colour, l.mark, Series::Line::straight});
  for (const tuning::Stage& s : stages) {
    const double seconds = s.share * run.seconds;
    const std::string item = "after " + output::duration(seconds) + ", " + output::counted(s.samples, "sample");
    for (std::size_t i = 0; i < kLines.size(); ++i) {
      const double regret = s.regret.*kLines[i].regret;
      out.measurements.push_back({item, "auto", kLines[i].quantity, "1", regret,
                                  "replayed from run " + std::to_string(run.id) + " of " + knowledge.tuning->file +
                                      ", " + output::counted(s.regret.questions, "question")});
      plot.series[i].points.push_back(
          {seconds, 100 * regret, item + ": " + kLines[i].quantity + " " + percent(regret)});
    }
    out.measurements.push_back({item, "auto", "seconds of tuning", "s", seconds,
                                "share of the timed calls, of the " + output::duration(run.seconds) + " of the run"});
  }
  const tuning::Regret& last = stages.back().regret;
  out.body = paragraph("The tuning run (" + run.profile + ", " + output::duration(run.seconds) +
                       ") is replayed in its order: a model of the samples so far chooses for " +
                       output::counted(last.questions, "cell") +
                       " that were measured but held out. With all samples, its choices are slower than the best by " +
                       percent(last.mean) + " on average, " + percent(last.p95) + " (95th percentile) and " +
                       percent(last.max) + " (max).");
  out.body += pictures::figure(plot);
  return out;
}

}  // namespace assur::report
