#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <set>

#include "measure/pace.hpp"
#include "measure/step_times.hpp"
#include "median.hpp"
#include "output/format.hpp"
#include "pictures/plot.hpp"
#include "report/sections.hpp"
#include "tuning/regret_survey.hpp"

namespace assur::report {
namespace {

using tuning::Answer;
using tuning::Question;

constexpr double kGolden = 0.6180339887498949;
constexpr double kLeastRace = 0.2, kMostRace = 4;  // s for each race of a question
constexpr double kQuestionsAtLeast = 12;           // number of questions that fit into the time
constexpr double kLook = 0.01, kMostLook = 10;     // share of the time, and s, for observing the usual pace
constexpr double kFirstPasses = 0.85;              // share of the time for the first pass of all questions
constexpr double kMostOfTime = 0.2;                // share of the time for one question
constexpr double kFar = 1;                         // regret above which the axis is logarithmic
constexpr std::size_t kWorst = 6;                  // worst cases in the table
constexpr std::size_t kFew = 10;                   // fewer answers say little about a percentile

// Reorders the questions such that the first k are a fair choice for every k; the first one stays the first.
std::vector<Question> spread_out(std::vector<Question> all) {
  std::vector<std::size_t> order(all.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto place = [](std::size_t i) { return std::fmod(static_cast<double>(i) * kGolden, 1.0); };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return place(a) < place(b); });
  std::vector<Question> out;
  for (const std::size_t i : order) out.push_back(std::move(all[i]));
  return out;
}

std::string questions_text(std::size_t count) { return output::counted(count, "question"); }

// A choice in one question, with its time over the fastest, less 1.
struct Choice {
  double regret;
  std::string item, strategy, note = {};
};

// All choices of auto, or of a constant strategy.
struct Choices {
  std::string who;  // name in the diagram and the table
  std::string strategy, quantity;
  std::vector<Choice> all = {};

  [[nodiscard]] std::vector<double> regrets() const {
    std::vector<double> out;
    for (const Choice& c : all) out.push_back(c.regret);
    return out;
  }
};

struct Figure {
  const char *title, *quantity;
  double (*of)(const std::vector<double>&);
};
constexpr std::array kFigures = {Figure{"median", ", median", [](const auto& r) { return quantile(r, 0.5); }},
                                 Figure{"95th percentile", ", p95", [](const auto& r) { return quantile(r, 0.95); }},
                                 Figure{"max", ", max", [](const auto& r) { return quantile(r, 1); }},
                                 Figure{"mean", ", mean", mean}};

HtmlTable summary(const std::vector<Choices>& everybody) {
  std::vector<pictures::ColumnOf<Choices>> columns = {
      {"regret", HtmlTable::Column::words, [](const Choices& c) { return c.who; }}};
  for (const Figure& f : kFigures) {
    columns.push_back(
        {f.title, HtmlTable::Column::number, [&f](const Choices& c) { return percent(f.of(c.regrets())); }});
  }
  return pictures::table_of(everybody, columns);
}

pictures::Series steps(const Choices& choices, double to, int colour, pictures::Series::Mark mark) {
  std::vector<std::pair<double, std::string>> sorted;
  for (const Choice& c : choices.all) sorted.emplace_back(c.regret, c.item + ", " + c.strategy + c.note);
  std::sort(sorted.begin(), sorted.end());
  pictures::Series out{.name = choices.who,
                       .points = {{1, 0, choices.who}},
                       .colour = colour,
                       .mark = mark,
                       .line = pictures::Series::Line::steps};
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    const double share = static_cast<double>(i + 1) / static_cast<double>(sorted.size());
    out.points.push_back({1 + sorted[i].first, 100 * share, sorted[i].second + ": " + percent(sorted[i].first)});
  }
  if (!sorted.empty() && sorted.back().first < to) out.points.push_back({1 + to, 100, choices.who});
  return out;
}

HtmlTable worst(std::vector<Answer> answers) {
  using enum HtmlTable::Column;
  std::stable_sort(answers.begin(), answers.end(),
                   [](const Answer& a, const Answer& b) { return a.regret() > b.regret(); });
  HtmlTable table{
      {"worst cases", "regret", "auto", "step", "fastest", "step"}, {text, number, text, number, text, number}, {}};
  for (const Answer& a : answers) {
    if (table.rows.size() == kWorst || a.regret() <= 0) break;
    table.rows.push_back({{a.question.text(), percent(a.regret()), a.chosen.strategy,
                           output::duration(a.chosen.seconds), a.best.strategy, output::duration(a.best.seconds)}});
  }
  return table;
}

void add_answer(Section& out, const Answer& a) {
  const auto time = [&](const char* quantity, const tuning::Finalist& f) {
    return Measurement{a.question.text(),          f.strategy,           quantity, "s", f.seconds, "measured",
                       static_cast<int>(f.rounds), f.spread / f.seconds, f.error};
  };
  const Measurement chosen = time("seconds per step, auto", a.chosen);
  for (const Measurement& m :
       {chosen, time("seconds per step, auto again", a.again), time("seconds per step, fastest", a.best),
        derived(chosen, "regret", a.regret(), "time of auto over that of the fastest, less 1")}) {
    out.measurements.push_back(m);
  }
}

}  // namespace

Section regret_section(const std::vector<Answer>& answers, std::size_t planned) {
  Section out{"regret", "Regret of auto"};
  if (answers.empty()) {
    out.body = paragraph("No question was answered.", "notice");
    return out;
  }
  Choices ours{"auto", "auto", "regret"}, untuned{"auto without measurements", "auto", "regret without measurements"},
      theirs{"the best constant strategy", "best constant", "regret"},
      itself{"auto against itself", "auto", "regret to itself"};
  std::set<std::string> winners;
  for (const Answer& a : answers) {
    add_answer(out, a);
    const std::string item = a.question.text();
    ours.all.push_back({a.regret(), item, a.chosen.strategy, " (fastest: " + a.best.strategy + ")"});
    untuned.all.push_back({a.untuned.seconds / a.best.seconds - 1, item, a.untuned.strategy});
    itself.all.push_back({a.regret_to_itself(), item, a.chosen.strategy});
    winners.insert(a.best.strategy);
  }
  std::string constants;
  for (const auto& [set, constant] : tuning::constants(answers)) {
    if (constant.regrets.size() < kFew) continue;  // of one question, its regret is 0 by definition
    constants += (constants.empty() ? "" : "; ") + (set.empty() ? "all solvers" : set) + ": " + constant.strategy;
    std::size_t i = 0;
    for (const Answer& a : answers) {
      if (a.question.without_text() != set) continue;
      theirs.all.push_back({constant.regrets[i++], a.question.text(), constant.strategy});
      out.measurements.push_back({a.question.text(), constant.strategy, "regret of the best constant strategy", "1",
                                  theirs.all.back().regret, "time over that of the fastest in the first race, less 1"});
    }
  }
  std::vector<Choices> everybody = {std::move(ours), std::move(untuned)};
  if (!theirs.all.empty()) everybody.push_back(std::move(theirs));
  everybody.push_back(std::move(itself));
  double to = 0;
  for (const Choices& c : everybody) {
    for (const Figure& f : kFigures) {
      out.measurements.push_back({"all questions", c.strategy, c.quantity + f.quantity, "1", f.of(c.regrets()),
                                  "computed from " + questions_text(c.all.size())});
    }
    if (&c != &everybody.back()) to = std::max(to, quantile(c.regrets(), 1));
  }

  out.body =
      paragraph(
          "Whole steps of mechanisms with sizes that the tuner does not measure, and of mechanisms unlike those that "
          "it "
          "measures. The choice of auto is compared with "
          "the "
          "fastest of all strategies that are the same for all classes, and of mixtures of them. Regret is the "
          "relative "
          "excess of the time of the choice over the fastest. The regret of the choice against itself, prepared and "
          "timed "
          "a second time, shows the error of the measurement. Times are corrected to the usual pace of the machine; "
          "several threads are timed while all cores have the same pace. Questions answered: " +
          output::grouped(answers.size()) + " of " + output::grouped(planned) + "; " +
          (winners.size() == 1
               ? "one strategy is the fastest in all."
               : output::grouped(winners.size()) + " different strategies are the fastest in at least one.")) +
      (answers.size() < kFew ? paragraph("So few answers say little about other mechanisms.", "notice") : "") +
      html(summary(everybody));

  everybody.pop_back();
  pictures::Plot plot;
  plot.title = "Share of questions against time of the choice over time of the fastest";
  plot.y = {"questions, %", false, output::number};
  plot.x = {"time of the choice over time of the fastest", to > kFar, output::number};
  using enum pictures::Series::Mark;
  constexpr std::array kMarks = {dot, square, triangle};
  for (std::size_t i = 0; i < everybody.size(); ++i) {
    plot.series.push_back(steps(everybody[i], to, static_cast<int>(i), kMarks[i]));
  }
  out.body += pictures::figure(plot);
  if (!constants.empty()) out.body += paragraph("Best constant strategies: " + constants + ".", "faint");
  if (const HtmlTable cases = worst(answers); !cases.rows.empty()) out.body += html(cases);
  return out;
}

Section regret(const Knowledge& knowledge, const Conditions& conditions) {
  const double begin = measure::StepTimes::steady();
  const auto taken = [&] { return measure::StepTimes::steady() - begin; };
  std::vector<Question> all = tuning::regret_questions(conditions.threads);
  const std::vector<Question> unlike = tuning::unlike_questions(conditions.threads);
  all.insert(all.end(), unlike.begin(), unlike.end());
  all = spread_out(std::move(all));
  std::vector<tuning::Contest> contests;
  std::vector<std::string> too_long;
  double end = 0;  // s, time at which the current race has to end
  tuning::QuestionOptions how;
  how.model = knowledge.known.model;
  how.quick = conditions.quick;
  how.seconds = std::clamp(conditions.seconds / kQuestionsAtLeast / 3, kLeastRace, kMostRace);
  measure::MachinePace pace(conditions.threads, std::min(kLook * conditions.seconds, kMostLook));
  // The first question is small and always answered.
  how.instruments = conditions.instruments();
  pace.attach(how.instruments);
  how.instruments.stop = [&] { return conditions.interrupted() || (!contests.empty() && taken() > end); };
  const double first_passes = kFirstPasses * conditions.seconds;
  for (const Question& q : all) {
    if (conditions.interrupted() || (!contests.empty() && taken() > first_passes)) break;
    end = std::min(first_passes, taken() + kMostOfTime * conditions.seconds);
    auto contest = tuning::Contest::open(q, how);
    if (contest && contest->race()) {
      contests.push_back(std::move(*contest));
    } else if (!conditions.interrupted() && end < first_passes) {
      too_long.push_back(q.text());
    }
  }
  end = conditions.seconds;
  for (int pass = 1; pass < tuning::kPasses; ++pass) {
    for (tuning::Contest& c : contests) {
      if (how.instruments.stop() || !c.race()) break;
    }
  }
  std::vector<Answer> answers;
  for (const tuning::Contest& c : contests) answers.push_back(c.answer());
  Section out = regret_section(answers, all.size());
  if (!too_long.empty()) out.body += paragraph("Skipped for lack of time: " + output::listed(too_long) + ".", "faint");
  if (knowledge.known.model->samples() == 0) {
    out.body = paragraph("There are no samples of this machine: auto used the prior.", "notice") + out.body;
  }
  return out;
}

}  // namespace assur::report
