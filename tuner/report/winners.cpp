#include <algorithm>
#include <cmath>
#include <set>

#include "assur/backend.hpp"
#include "assur/plan.hpp"
#include "assur/scene.hpp"
#include "decimal.hpp"
#include "dispatch/counts.hpp"
#include "output/format.hpp"
#include "pictures/heat_map.hpp"
#include "pictures/plot.hpp"
#include "report/sections.hpp"
#include "structure/grouped_system.hpp"
#include "tuning/mechanisms.hpp"
#include "tuning/tuning_report.hpp"

namespace assur::report {
namespace {

using output::short_text;

constexpr double kSameCount = 1.05;  // numbers of groups up to this ratio are equal: 102 and the tuner's 100

// A column: a class of groups, or matrices, of one size.
struct Column {
  std::string name;
  Shape shape;
};

Shape shape_of_class(const Scene& scene, Formulation formulation, std::int32_t n) {
  StructureOptions options;
  options.formulation = formulation;
  const GroupedSystem structure = group_equations(scene, options);
  const auto at =
      std::find_if(structure.classes.begin(), structure.classes.end(), [n](const GroupClass& c) { return c.n == n; });
  if (at == structure.classes.end())
    throw Error(Error::Kind::numerical, "no groups of " + std::to_string(n) + " unknowns");
  return shape_of(*at);
}

// Sizes that the tuner measures: dyads, legs of a Stewart platform, rings.
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
    shape.rhs = 3;  // for one factorisation: position, velocity, acceleration
    out.push_back({std::to_string(n), shape});
  }
  return out;
}

// The sample that gives the time of the winner; null if the time is predicted.
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

// The data of a heat map: the fastest strategy for each column and row.
struct Atlas {
  std::string title, x_title, y_title;
  std::string what;  // "mechanism"
  std::vector<Column> columns;
  std::vector<int> rows;
  struct Cell {
    Candidate first;
    std::string next = {};  // the second fastest with its time; empty if there is none
    Measurement measurement = {};
    bool measured = false;
  };
  std::vector<Cell> cells = {};  // rows x columns
};

Atlas::Cell cell(const Atlas& atlas, const Column& column, int groups, const Knowledge& knowledge, int threads) {
  Shape shape = column.shape;
  shape.groups = groups;
  const std::vector<Candidate> all =
      candidates(shape, {.model = knowledge.known.model, .budget = ThreadBudget{threads}});
  if (all.empty() || !all[0].why_not.empty()) throw Error(Error::Kind::environment, "no solver can run");
  Atlas::Cell out{all[0]};
  if (all.size() > 1 && all[1].why_not.empty()) {
    out.next = short_text(all[1].strategy) + ", " + output::duration(all[1].expected_seconds);
  }
  const Sample* sample = measured(knowledge, shape, all[0].strategy);
  out.measured = sample != nullptr;
  Measurement& m = out.measurement;
  m = {atlas.what + ", n = " + column.name + ", " +
           (shape.terms > 0 ? output::counted(groups, "group") : std::to_string(groups) + " of them"),
       short_text(all[0].strategy),
       "expected seconds for all groups",
       "s",
       all[0].expected_seconds,
       "predicted, " + std::string(name(all[0].origin)) + ", two times in three within a factor " +
           fixed(all[0].factor, 2)};
  if (out.measured) {
    m.origin = "composed from the measured time of one pack";
    m.repetitions = static_cast<int>(std::min<std::int64_t>(sample->repetitions, 1'000'000'000));
    m.spread = sample->spread / sample->seconds;
    m.error = sample->backward_error;
  }
  return out;
}

void fill(Atlas& atlas, const Knowledge& knowledge, const Conditions& conditions) {
  for (const int groups : atlas.rows) {
    for (const Column& c : atlas.columns) atlas.cells.push_back(cell(atlas, c, groups, knowledge, conditions.threads));
  }
}

// Backends that win at least once, in the order of the table of backends; each has the same colour in all maps.
std::vector<std::string_view> winning_backends(const std::vector<Atlas>& all) {
  std::vector<std::string_view> out;
  for (const Backend& b : backends()) {
    const auto wins = [&b](const Atlas& a) {
      return std::any_of(a.cells.begin(), a.cells.end(),
                         [&b](const Atlas::Cell& c) { return c.first.strategy.solver.backend == b.id; });
    };
    if (std::any_of(all.begin(), all.end(), wins)) out.push_back(b.id);
  }
  return out;
}

// More lanes have a stronger colour.
pictures::HeatMap map_of(const Atlas& atlas, const std::vector<std::string_view>& backends) {
  pictures::HeatMap map{
      .title = atlas.title,
      .x_title = atlas.x_title,
      .y_title = atlas.y_title,
      .columns = {},
      .rows = {},
      .cells = {},
      .kinds = {},
      .mark = "measured with this number of groups; other cells are predicted from samples of other sizes"};
  for (const Column& c : atlas.columns) map.columns.push_back(c.name);
  for (const int groups : atlas.rows) map.rows.push_back(output::grouped(groups));
  std::set<std::pair<std::string, int>> kinds;  // backend, lanes
  for (const Atlas::Cell& c : atlas.cells)
    kinds.emplace(c.first.strategy.solver.backend, c.first.strategy.solver.lanes);
  for (const auto& [backend, lanes] : kinds) {
    const auto hue = std::find(backends.begin(), backends.end(), backend) - backends.begin();
    map.kinds.push_back({backend + (lanes > 1 ? ":" + std::to_string(lanes) : ""),
                         static_cast<int>(hue) % pictures::Series::kColours, (1 + std::log2(lanes)) / 5});
  }
  for (const Atlas::Cell& c : atlas.cells) {
    const auto kind = kinds.find({c.first.strategy.solver.backend, c.first.strategy.solver.lanes});
    map.cells.push_back({static_cast<int>(std::distance(kinds.begin(), kind)), short_text(c.first.strategy),
                         c.measurement.item + ": " + about(c.measurement) + (c.next.empty() ? "" : "; next: " + c.next),
                         c.measured});
  }
  return map;
}

// For each row, the fastest strategies and the n from which each is the fastest.
HtmlTable crossovers(const Atlas& atlas) {
  HtmlTable table{{"groups", "fastest, with n"}, {HtmlTable::Column::number, HtmlTable::Column::words}, {}};
  for (std::size_t r = 0; r < atlas.rows.size(); ++r) {
    std::string line, before;
    for (std::size_t c = 0; c < atlas.columns.size(); ++c) {
      const std::string text = short_text(atlas.cells[r * atlas.columns.size() + c].first.strategy);
      if (text == before) continue;
      line += before.empty() ? text : "; from " + atlas.columns[c].name + ": " + text;
      before = text;
    }
    table.rows.push_back({{output::grouped(atlas.rows[r]), line}});
  }
  return table;
}

// The crossovers of full matrices that the tuner measured.
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
  std::vector<Atlas> all = {{"Fastest strategy over unknowns of a group and number of groups",
                             "unknowns of a group, n",
                             "groups of a level",
                             "mechanism",
                             mechanisms(conditions.quick),
                             {1, 2, 4, 8, 16, 32, 64, 100, 1000, 10'000}},
                            {"Fastest solver over the size and number of full matrices",
                             "size of a matrix, n",
                             "matrices",
                             "full matrix",
                             matrices(),
                             {1, 2, 4, 8, 16, 64}}};
  for (Atlas& atlas : all) fill(atlas, knowledge, conditions);
  const std::vector<std::string_view> backends = winning_backends(all);

  Section out{"winners", "Fastest strategies"};
  out.body = paragraph(
      "The strategy with the shortest expected time for a level of groups of one class, by the number of unknowns of a "
      "group and the number of groups. PxQ: P packs at once, Q threads within each. Dots mark packs that were "
      "measured; "
      "all other cells come from the performance model.");
  if (knowledge.known.model->samples() == 0) {
    out.body += paragraph("There are no samples of this machine: all cells come from the prior.", "notice");
  }
  out.body += figure(map_of(all[0], backends)) +
              paragraph(
                  "n = 2: dyads; 3 and 15: legs of a Stewart platform, irreducible and as groups; others: rings of 3n "
                  "nonzeros.",
                  "faint") +
              html(crossovers(all[0])) +
              paragraph("The same for full matrices, each factorised once and solved with three right-hand sides:") +
              figure(map_of(all[1], backends));
  if (const std::string text = measured_crossovers(knowledge); !text.empty()) out.body += paragraph(text, "faint");
  for (const Atlas& atlas : all) {
    for (const Atlas::Cell& c : atlas.cells) out.measurements.push_back(c.measurement);
  }
  return out;
}

}  // namespace assur::report
