#include "report/regret.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "measure/pace.hpp"
#include "measure/regret_survey.hpp"
#include "measure/step_times.hpp"
#include "output/format.hpp"
#include "pictures/plot.hpp"
#include "report/measurement.hpp"
#include "report/sections.hpp"

namespace assur::report {
namespace {

using measure::Answer;
using measure::Question;

constexpr double kGolden = 0.6180339887498949;
constexpr double kLeastRace = 0.2, kMostRace = 4;  // s for each race of a question
constexpr double kQuestionsAtLeast = 12;           // that the time is meant for
constexpr double kLook = 0.01, kMostLook = 10;     // of the time, and s: at the usual pace, without a way to end it
constexpr double kFirstPasses = 0.85;              // of the time: for the questions with one pass each
constexpr double kMostOfTime = 0.2;                // of the time: for one question
constexpr double kFar = 1;                         // regret from which on the axis is logarithmic
constexpr std::size_t kWorst = 6;                  // that are named

// In an order of which every beginning is a fair choice; the first one stays the first.
std::vector<Question> spread_out(std::vector<Question> all) {
  std::vector<std::size_t> order(all.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto place = [](std::size_t i) { return std::fmod(static_cast<double>(i) * kGolden, 1.0); };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return place(a) < place(b); });
  std::vector<Question> out;
  for (const std::size_t i : order) out.push_back(std::move(all[i]));
  return out;
}

std::string item_of(const Question& q) {
  const std::string without = q.without_text();
  return q.scene + (without.empty() ? "" : ", " + without);
}

pictures::Series steps(const std::string& name, const std::vector<std::pair<double, std::string>>& regrets, double to,
                       int colour, pictures::Series::Mark mark) {
  pictures::Series out{
      .name = name, .points = {}, .colour = colour, .mark = mark, .line = pictures::Series::Line::steps};
  auto sorted = regrets;
  std::sort(sorted.begin(), sorted.end());
  out.points.push_back({1, 0, name});
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    const double share = static_cast<double>(i + 1) / static_cast<double>(sorted.size());
    out.points.push_back({1 + sorted[i].first, 100 * share, sorted[i].second + ": " + percent(sorted[i].first)});
  }
  if (!sorted.empty() && sorted.back().first < to) out.points.push_back({1 + to, 100, name});
  return out;
}

pictures::HtmlTable summary(const std::vector<std::pair<std::string, std::vector<double>>>& all) {
  using enum pictures::HtmlTable::Column;
  pictures::HtmlTable table{
      {"regret", "median", "95 of 100", "most", "mean"}, {words, number, number, number, number}, {}};
  for (const auto& [who, regrets] : all) {
    table.rows.push_back({{who, percent(quantile(regrets, 0.5)), percent(quantile(regrets, 0.95)),
                           percent(quantile(regrets, 1)), percent(mean(regrets))}});
  }
  return table;
}

pictures::HtmlTable worst(std::vector<Answer> answers) {
  using enum pictures::HtmlTable::Column;
  std::stable_sort(answers.begin(), answers.end(),
                   [](const Answer& a, const Answer& b) { return a.regret() > b.regret(); });
  pictures::HtmlTable table{
      {"worst cases", "regret", "auto", "step", "fastest", "step"}, {text, number, text, number, text, number}, {}};
  for (const Answer& a : answers) {
    if (table.rows.size() == kWorst || a.regret() <= 0) break;
    table.rows.push_back({{item_of(a.question), percent(a.regret()), a.chosen.strategy,
                           output::duration(a.chosen.seconds), a.best.strategy, output::duration(a.best.seconds)}});
  }
  return table;
}

void add_answer(Section& out, const Answer& a) {
  const std::string item = item_of(a.question);
  const auto add = [&](const char* quantity, const measure::Finalist& f) {
    out.measurements.push_back({out.id, item, f.strategy, quantity, "s", f.seconds, static_cast<int>(f.rounds),
                                f.spread / f.seconds, f.error, "measured"});
  };
  add("seconds per step, auto", a.chosen);
  add("seconds per step, auto again", a.again);
  add("seconds per step, fastest", a.best);
  out.measurements.push_back({out.id, item, a.chosen.strategy, "regret", "1", a.regret(),
                              static_cast<int>(a.chosen.rounds), a.chosen.spread / a.chosen.seconds, a.chosen.error,
                              "time of auto over that of the fastest, less 1"});
}

}  // namespace

Section regret_section(const std::vector<Answer>& answers, std::size_t planned) {
  Section out{"regret", "What auto loses", "", {}};
  if (answers.empty()) {
    out.body = paragraph("No question was answered.", "notice");
    return out;
  }
  std::vector<double> ours, theirs, itself;
  std::vector<std::pair<double, std::string>> of_auto, of_constants;
  std::set<std::string> winners;
  for (const Answer& a : answers) {
    add_answer(out, a);
    ours.push_back(a.regret());
    itself.push_back(a.regret_to_itself());
    of_auto.emplace_back(a.regret(),
                         item_of(a.question) + ", " + a.chosen.strategy + " (fastest: " + a.best.strategy + ")");
    winners.insert(a.best.strategy);
  }
  std::string constants;
  for (const auto& [set, constant] : measure::constants(answers)) {
    constants += (constants.empty() ? "" : "; ") + (set.empty() ? "all solvers" : set) + ": " + constant.strategy;
    std::size_t i = 0;
    for (const Answer& a : answers) {
      if (a.question.without_text() != set) continue;
      const double r = constant.regrets[i++];
      theirs.push_back(r);
      of_constants.emplace_back(r, item_of(a.question) + ", " + constant.strategy);
      out.measurements.push_back({out.id, item_of(a.question), constant.strategy,
                                  "regret of the best constant strategy", "1", r, 0, 0, std::nan(""),
                                  "first race of the question, over the fastest in it, less 1"});
    }
  }
  const auto add_all = [&](const std::string& who, const std::string& what, const std::vector<double>& r) {
    const auto add = [&](const char* quantity, double value) {
      out.measurements.push_back({out.id, "all questions", who, what + quantity, "1", value, 0, 0, std::nan(""),
                                  "computed from " + output::counted(static_cast<std::int64_t>(r.size()), "question")});
    };
    add(", median", quantile(r, 0.5));
    add(", p95", quantile(r, 0.95));
    add(", max", quantile(r, 1));
    add(", mean", mean(r));
  };
  add_all("auto", "regret", ours);
  if (!theirs.empty()) add_all("best constant", "regret", theirs);
  add_all("auto", "regret to itself", itself);

  const auto count = [](std::size_t n) { return static_cast<std::int64_t>(n); };
  out.body = paragraph(
      "Whole steps of mechanisms and sizes that the tuner does not measure: what auto chose against the "
      "fastest of every strategy that is the same for all classes, and of mixtures of them. Regret is how "
      "much longer the choice takes than the fastest; that of the choice to itself, prepared and raced a second time, "
      "is the measurement's alone. Times are those of the machine's usual pace, of several threads while the cores are "
      "alike. " +
      output::counted(count(answers.size()), "question") + " of " + output::grouped(count(planned)) + "; " +
      (winners.size() == 1
           ? "the same strategy is the fastest in all."
           : output::grouped(count(winners.size())) + " different strategies are the fastest somewhere."));
  std::vector<std::pair<std::string, std::vector<double>>> rows = {{"auto", ours}};
  if (!theirs.empty()) rows.emplace_back("the best constant strategy", theirs);
  rows.emplace_back("auto to itself", itself);
  out.body += html(summary(rows));

  pictures::Plot plot;
  plot.title = "Share of the questions over the time of the choice over that of the fastest";
  plot.y = {"questions, %", false, [](double v) { return output::number(v); }};
  const double to = std::max(quantile(ours, 1), theirs.empty() ? 0 : quantile(theirs, 1));
  plot.x = {"time of the choice over that of the fastest", to > kFar, [](double v) { return output::number(v); }};
  plot.series.push_back(steps("auto", of_auto, to, 0, pictures::Series::Mark::dot));
  if (!theirs.empty())
    plot.series.push_back(steps("the best constant strategy", of_constants, to, 1, pictures::Series::Mark::square));
  out.body += pictures::figure(plot);
  if (!constants.empty()) out.body += paragraph("Best constant strategies: " + constants + ".", "faint");
  const pictures::HtmlTable cases = worst(answers);
  if (!cases.rows.empty()) out.body += html(cases);
  return out;
}

Section regret(const Knowledge& knowledge, const Conditions& conditions) {
  const double begin = measure::StepTimes::steady();
  const auto taken = [&] { return measure::StepTimes::steady() - begin; };
  const std::vector<Question> all = spread_out(measure::regret_questions(conditions.threads));
  std::vector<measure::Contest> contests;
  std::vector<std::string> too_long;
  double end = 0;  // s: until when what is under way has to end
  measure::QuestionOptions how;
  how.model = knowledge.known.model;
  how.quick = conditions.quick;
  how.seconds = std::clamp(conditions.seconds / kQuestionsAtLeast / 3, kLeastRace, kMostRace);
  measure::MachinePace pace(conditions.threads, std::min(kLook * conditions.seconds, kMostLook));
  // The first question, which is small, is always answered.
  how.instruments = conditions.instruments();
  pace.attach(how.instruments);
  how.instruments.stop = [&] { return conditions.interrupted() || (!contests.empty() && taken() > end); };
  const double first_passes = kFirstPasses * conditions.seconds;
  for (const Question& q : all) {
    if (conditions.interrupted() || (!contests.empty() && taken() > first_passes)) break;
    conditions.progress(taken() / conditions.seconds, q.scene);
    end = std::min(first_passes, taken() + kMostOfTime * conditions.seconds);
    auto contest = measure::Contest::open(q, how);
    if (contest && contest->race()) {
      contests.push_back(std::move(*contest));
    } else if (!conditions.interrupted() && end < first_passes) {
      too_long.push_back(item_of(q));
    }
  }
  end = conditions.seconds;
  for (int pass = 1; pass < measure::kPasses; ++pass) {
    for (measure::Contest& c : contests) {
      conditions.progress(taken() / conditions.seconds, c.question().scene);
      if (how.instruments.stop() || !c.race()) break;
    }
  }
  std::vector<Answer> answers;
  for (const measure::Contest& c : contests) answers.push_back(c.answer());
  Section out = regret_section(answers, all.size());
  if (!too_long.empty())
    out.body += paragraph("Given up, for want of time: " + output::listed(too_long) + ".", "faint");
  if (knowledge.known.model->samples() == 0) {
    out.body = paragraph("Nothing was measured on this machine: auto went by the prior.", "notice") + out.body;
  }
  return out;
}

}  // namespace assur::report
