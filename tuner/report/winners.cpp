#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include "assur/plan.hpp"
#include "assur/scene.hpp"
#include "assur/structure.hpp"
#include "decimal.hpp"
#include "output/format.hpp"
#include "pictures/heat_map.hpp"
#include "planning/counts.hpp"
#include "report/measurement.hpp"
#include "report/sections.hpp"
#include "tuning/mechanisms.hpp"

namespace assur::report {
namespace {

constexpr double kSameCount = 1.05;  // of groups: 102 are the 100 of the tuner

// A class of groups, or matrices, of one size.
struct Column {
  std::string name;
  Shape shape;
};

Shape shape_of_class(const Scene& scene, Formulation formulation, std::int32_t n) {
  StructureOptions options;
  options.formulation = formulation;
  const Structure structure = analyze(scene, options);
  const auto at =
      std::find_if(structure.classes.begin(), structure.classes.end(), [n](const GroupClass& c) { return c.n == n; });
  if (at == structure.classes.end())
    throw Error(Error::Kind::numerical, "no groups of " + std::to_string(n) + " unknowns");
  return shape_of(*at);
}

// The tuner's own sizes: dyads, legs of a Stewart platform, rings.
std::vector<Column> mechanisms(bool quick) {
  std::vector<Column> out = {{"2", shape_of_class(tuning::dyads(1), Formulation::irreducible, 2)},
                             {"3", shape_of_class(sample("stewart"), Formulation::irreducible, 3)},
                             {"15", shape_of_class(sample("stewart"), Formulation::groups, 15)}};
  for (const int n : {12, 24, 60, 120, 240, 720, 2000}) {
    if (quick && n > 720) continue;
    const std::string text = std::to_string(n);
    out.push_back({text, shape_of_class(sample("rings:legs=1,terminal=12,n=" + text), Formulation::groups, n)});
  }
  std::sort(out.begin(), out.end(), [](const Column& a, const Column& b) { return a.shape.n < b.shape.n; });
  return out;
}

Pattern full(std::int32_t n) {
  Pattern out;
  out.n = n;
  for (std::int32_t c = 0; c <= n; ++c) out.column_start.push_back(c * n);
  for (std::int32_t k = 0; k < n * n; ++k) out.row.push_back(k % n);
  return out;
}

std::vector<Column> matrices() {
  std::vector<Column> out;
  for (const std::int32_t n : {2, 4, 8, 16, 32, 64, 125, 250, 500, 800}) {
    Shape shape = shape_of(full(n));
    shape.rhs = 3;  // of a factorisation: position, velocity, acceleration
    out.push_back({std::to_string(n), shape});
  }
  return out;
}

// Without its formulation, which does not matter here.
std::string short_text(const Strategy& strategy) {
  const std::string text = to_string(strategy);
  return text.substr(text.find('/') + 1);
}

std::string kind_of(const Strategy& s) {
  return s.solver.backend + (s.solver.lanes > 1 ? ":" + std::to_string(s.solver.lanes) : "");
}

// The sample that the winner's time comes from; null if it was predicted.
const Sample* measured(const Knowledge& knowledge, const Shape& shape, const Strategy& s) {
  if (!knowledge.tuning) return nullptr;
  const Kernel kernel = shape.terms > 0 ? Kernel::pack : Kernel::factor;
  for (const Sample& sample : knowledge.tuning->samples) {
    if (sample.kernel != kernel || sample.shape.n != shape.n || sample.shape.pattern != shape.pattern) continue;
    const Strategy& o = sample.strategy;
    if (o.solver.backend != s.solver.backend || o.solver.lanes != s.solver.lanes ||
        o.solver.single != s.solver.single || o.solver.once != s.solver.once || o.solver.threads != s.solver.threads ||
        o.run.threads != 1)
      continue;
    const double ratio = static_cast<double>(sample.shape.groups) / shape.groups;
    if (shape.terms == 0 || (ratio <= kSameCount && ratio >= 1 / kSameCount)) return &sample;
  }
  return nullptr;
}

// One for each backend, the same in all maps; the more lanes, the stronger it is.
int colour_of(const std::string& backend) {
  constexpr std::array<std::string_view, 6> kInOrder = {"lanes", "klu", "eigen", "lapack", "team", "umfpack"};
  return static_cast<int>(std::find(kInOrder.begin(), kInOrder.end() - 1, backend) - kInOrder.begin());
}

struct Atlas {
  pictures::HeatMap map;
  std::vector<Measurement> measurements;
  std::vector<std::vector<Candidate>> winners;  // rows, columns
};

Measurement measurement(const Candidate& winner, const Sample* sample, const std::string& item) {
  Measurement m{"winners",
                item,
                short_text(winner.strategy),
                "expected seconds for all groups",
                "s",
                winner.expected_seconds,
                0,
                0,
                std::nan(""),
                ""};
  if (sample != nullptr) {
    m.repetitions = static_cast<int>(std::min<std::int64_t>(sample->repetitions, 1'000'000'000));
    m.spread = sample->spread / sample->seconds;
    m.error = sample->backward_error;
    m.origin = "composed from the measured time of one pack";
  } else {
    m.origin = "predicted, " + std::string(name(winner.origin)) + ", two times in three within a factor " +
               fixed(winner.factor, 2);
  }
  return m;
}

Atlas atlas(const std::vector<Column>& columns, const std::vector<int>& rows, const std::string& what,
            const Knowledge& knowledge, const Conditions& conditions) {
  Atlas out;
  for (const Column& c : columns) out.map.columns.push_back(c.name);
  std::set<std::pair<std::string, int>> kinds;  // backend, lanes
  for (const int groups : rows) {
    out.map.rows.push_back(output::grouped(groups));
    std::vector<Candidate>& row = out.winners.emplace_back();
    for (const Column& c : columns) {
      Shape shape = c.shape;
      shape.groups = groups;
      const std::vector<Candidate> all =
          candidates(shape, {.model = knowledge.known.model, .budget = ThreadBudget{conditions.threads}});
      if (all.empty() || !all[0].why_not.empty()) throw Error(Error::Kind::environment, "no solver can run");
      const Sample* sample = measured(knowledge, shape, all[0].strategy);
      const std::string item =
          what + ", n = " + c.name + ", " +
          (shape.terms > 0 ? output::counted(groups, "group") : std::to_string(groups) + " of them");
      out.measurements.push_back(measurement(all[0], sample, item));
      pictures::HeatMap::Cell cell{0, short_text(all[0].strategy), item + ": " + about(out.measurements.back()),
                                   sample != nullptr};
      if (all.size() > 1 && all[1].why_not.empty()) {
        cell.about += "; next: " + short_text(all[1].strategy) + ", " + output::duration(all[1].expected_seconds);
      }
      out.map.cells.push_back(std::move(cell));
      kinds.emplace(all[0].strategy.solver.backend, all[0].strategy.solver.lanes);
      row.push_back(all[0]);
    }
  }
  std::map<std::string, int> place;
  for (const auto& [backend, lanes] : kinds) {
    const std::string name = backend + (lanes > 1 ? ":" + std::to_string(lanes) : "");
    place[name] = static_cast<int>(out.map.kinds.size());
    out.map.kinds.push_back({name, colour_of(backend), (1 + std::log2(lanes)) / 5});
  }
  for (std::size_t r = 0; r < out.winners.size(); ++r) {
    for (std::size_t c = 0; c < columns.size(); ++c) {
      out.map.cells[r * columns.size() + c].kind = place[kind_of(out.winners[r][c].strategy)];
    }
  }
  out.map.mark = "measured with so many groups; the others are predicted from samples of other sizes";
  return out;
}

// Along each row: up to which n one strategy is the fastest, and from which on the next.
pictures::HtmlTable crossovers(const Atlas& atlas) {
  using enum pictures::HtmlTable::Column;
  pictures::HtmlTable table{{"groups", "fastest, with n"}, {number, words}, {}};
  for (std::size_t r = 0; r < atlas.winners.size(); ++r) {
    std::string line, before;
    for (std::size_t c = 0; c < atlas.map.columns.size(); ++c) {
      const std::string text = short_text(atlas.winners[r][c].strategy);
      if (text == before) continue;
      line += before.empty() ? text : "; from " + atlas.map.columns[c] + ": " + text;
      before = text;
    }
    table.rows.push_back({{atlas.map.rows[r], line}});
  }
  return table;
}

// Of full matrices, as the tuner met them one size after the other.
std::string measured_crossovers(const Knowledge& knowledge) {
  if (!knowledge.tuning) return "";
  const db::Answer& all = knowledge.tuning->crossovers;
  const auto place = [&](const char* column) {
    return static_cast<std::size_t>(std::find(all.columns.begin(), all.columns.end(), column) - all.columns.begin());
  };
  const std::size_t kernel = place("kernel"), dense = place("dense"), from = place("n_before"), to = place("n"),
                    before = place("strategy_before"), after = place("strategy");
  const auto number = [](const db::Value& v) { return output::grouped(std::get<std::int64_t>(v)); };
  const auto strategy = [](const db::Value& v) { return short_text(parse_strategy(std::get<std::string>(v))); };
  std::string text;
  for (const auto& row : all.rows) {
    if (std::get<std::string>(row[kernel]) != "factor+3solve" || std::get<std::int64_t>(row[dense]) != 1) continue;
    text += (text.empty() ? "" : "; ") + strategy(row[before]) + " up to " + number(row[from]) + ", " +
            strategy(row[after]) + " from " + number(row[to]);
  }
  return text.empty() ? "" : "Measured crossovers of full matrices, with all lanes filled: " + text + ".";
}

}  // namespace

Section winners(const Knowledge& knowledge, const Conditions& conditions) {
  Section out{"winners", "Which strategy wins", "", {}};
  const std::vector<int> rows = {1, 2, 4, 8, 16, 32, 64, 100, 1000, 10'000};
  out.body = paragraph(
      "The strategy that is expected to be the fastest for a level of groups of one class: for how many unknowns each "
      "and how many of them. PxQ: P packs at once, Q threads within each. Dots: that very pack was measured; elsewhere "
      "the "
      "performance model says so.");
  if (knowledge.known.model->samples() == 0) {
    out.body += paragraph("Nothing was measured on this machine: these are the answers of the prior.", "notice");
  }

  Atlas groups = atlas(mechanisms(conditions.quick), rows, "mechanism", knowledge, conditions);
  groups.map.title = "Fastest strategy over unknowns of a group and number of groups";
  groups.map.x_title = "unknowns of a group, n";
  groups.map.y_title = "groups of a level";
  out.body += pictures::figure(groups.map);
  out.body += paragraph(
      "n = 2: dyads; 3 and 15: legs of a Stewart platform, irreducible and whole; others: rings of 3n "
      "nonzeros.",
      "faint");
  out.body += html(crossovers(groups));

  Atlas full_ones = atlas(matrices(), {1, 2, 4, 8, 16, 64}, "full matrix", knowledge, conditions);
  full_ones.map.title = "Fastest solver over the size and number of full matrices";
  full_ones.map.x_title = "size of a matrix, n";
  full_ones.map.y_title = "matrices";
  out.body += paragraph("The same for full matrices, each factorised once and solved with three right-hand sides:");
  out.body += pictures::figure(full_ones.map);
  if (const std::string text = measured_crossovers(knowledge); !text.empty()) out.body += paragraph(text, "faint");

  out.measurements = std::move(groups.measurements);
  std::move(full_ones.measurements.begin(), full_ones.measurements.end(), std::back_inserter(out.measurements));
  return out;
}

}  // namespace assur::report
