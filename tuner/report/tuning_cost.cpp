#include "output/format.hpp"
#include "pictures/plot.hpp"
#include "report/measurement.hpp"
#include "report/sections.hpp"
#include "tuning/replay.hpp"

namespace assur::report {
namespace {

constexpr int kStages = 20;

std::string percent_text(double value) { return output::number(value) + " %"; }

}  // namespace

Section tuning_cost(const Knowledge& knowledge, const Conditions&) {
  Section out{"tuning-cost", "What tuning costs, and what it saves", "", {}};
  if (!knowledge.tuning) {
    out.body = paragraph("There is no finished tuning run of this machine to look at.", "notice");
    return out;
  }
  const db::Run& run = knowledge.tuning->run;
  const std::vector<tuning::Stage> stages = tuning::replay(tuning::cells_of(knowledge.tuning->samples), kStages);
  if (stages.empty() || stages.back().regret.questions == 0) {
    out.body = paragraph("The tuning run held nothing out by which its choices could be judged.", "notice");
    return out;
  }
  using pictures::Series;
  Series average{.name = "mean", .points = {}, .colour = 0, .mark = Series::Mark::dot, .line = Series::Line::straight};
  Series worse{
      .name = "95 of 100", .points = {}, .colour = 1, .mark = Series::Mark::square, .line = Series::Line::straight};
  Series worst{
      .name = "most", .points = {}, .colour = 4, .mark = Series::Mark::triangle, .line = Series::Line::straight};
  for (const tuning::Stage& s : stages) {
    const double seconds = s.share * run.seconds;
    const std::string item =
        "after " + output::duration(seconds) + ", " + output::counted(static_cast<std::int64_t>(s.samples), "sample");
    const auto add = [&](Series& series, const char* quantity, double regret) {
      out.measurements.push_back({out.id, item, "auto", quantity, "1", regret, 0, 0, std::nan(""),
                                  "replayed from run " + std::to_string(run.id) + " of " + knowledge.tuning->file +
                                      ", " +
                                      output::counted(static_cast<std::int64_t>(s.regret.questions), "question")});
      series.points.push_back({seconds, 100 * regret, item + ": " + quantity + " " + percent(regret)});
    };
    add(average, "held-out regret, mean", s.regret.mean);
    add(worse, "held-out regret, p95", s.regret.p95);
    add(worst, "held-out regret, max", s.regret.max);
    out.measurements.push_back({out.id, item, "auto", "seconds of tuning", "s", seconds, 0, 0, std::nan(""),
                                "share of the timed calls, of the " + output::duration(run.seconds) + " of the run"});
  }
  pictures::Plot plot;
  plot.title = "Held-out regret over seconds of tuning";
  plot.x = {"tuning so far", false, [](double s) { return output::number(s) + " s"; }};
  plot.y = {"regret of auto on what was held out, %", true, percent_text};
  plot.series = {average, worse, worst};
  const tuning::Regret& last = stages.back().regret;
  out.body = paragraph("The tuning run (" + run.profile + ", " + output::duration(run.seconds) +
                       ") again, in its order: a model from the samples so far chooses for " +
                       output::counted(static_cast<std::int64_t>(last.questions), "cell") +
                       " that were measured but that it has not seen. With all samples it loses " + percent(last.mean) +
                       " of the time of the best on average, " + percent(last.p95) + " in 95 of 100, " +
                       percent(last.max) + " at most.");
  out.body += pictures::figure(plot);
  return out;
}

}  // namespace assur::report
