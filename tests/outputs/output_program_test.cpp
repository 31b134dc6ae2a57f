// Outputs that are evaluated side by side, and angles against constant directions.
#include "outputs/output_program.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "assur/assur.hpp"
#include "motion/layout.hpp"
#include "numbers.hpp"
#include "plan/preparation.hpp"
#include "source_dir.hpp"

namespace assur {
namespace {

// Rows and single outputs of an arbitrary state, which has lanes as the plan has.
void expect_rows_like_single_outputs(const std::string& scene, const std::string& strategy) {
  SCOPED_TRACE(scene + " " + strategy);
  const Prepared prepared = prepare(sample(scene), {strategy, {}});
  const Layout layout = lay_out(preparation(prepared));
  const System& system = *preparation(prepared).structure->system;
  const OutputProgram single(system, layout.address);
  OutputProgram rows = single;
  rows.find_rows(layout.size);
  EXPECT_GT(rows.rows(), 0u);

  std::mt19937_64 random(3);
  std::normal_distribution<double> number;
  std::array<std::vector<double>, 3> state;
  for (std::vector<double>& of : state) {
    for (std::size_t a = 0; a < layout.size; ++a) of.push_back(number(random));
  }
  const double* const q[3] = {state[0].data(), state[1].data(), state[2].data()};
  const std::size_t columns = column_names(system).size();
  const std::vector<double> turns(single.angles().size(), 1.0);
  const auto evaluate = [&](const OutputProgram& outputs, std::size_t parts) {
    std::vector<double> out(columns, kNan), divisors(outputs.measures());
    for (std::size_t p = 0; p < parts; ++p) outputs.evaluate(q, out.data(), turns.data(), divisors.data(), p, parts);
    outputs.add_up(out.data());
    return out;
  };
  EXPECT_EQ(evaluate(rows, 1), evaluate(single, 1));
  EXPECT_EQ(evaluate(rows, 3), evaluate(single, 1));

  std::vector<double> changes(columns, kNan), expected(columns, kNan);
  const double* const along[3] = {q[1], q[2], q[0]};
  rows.differentiate(q, along, nullptr, changes.data());
  single.differentiate(q, along, nullptr, expected.data());
  EXPECT_EQ(changes, expected);
}

TEST(OutputProgram, RowsAreSingleOutputsBitForBit) {
  for (const std::string strategy : {"groups/lanes:4", "irreducible/lanes:8", "irreducible/klu"}) {
    expect_rows_like_single_outputs("stewart", strategy);
  }
  expect_rows_like_single_outputs("stewart:legs=22", "irreducible/lanes:16");
  expect_rows_like_single_outputs("four_bar:20", "irreducible/lanes:8");
}

// Signed angles of an arbitrary state by the products of their directions. A rounding moves the end of an arm by
// epsilon * (length of the directions); the rate and the acceleration contain the square of such a ratio.
void expect_angles_by_products(const Scene& scene) {
  const Prepared prepared = prepare(scene, {"irreducible/eigen", {}});
  const Layout layout = lay_out(preparation(prepared));
  const System& system = *preparation(prepared).structure->system;
  const OutputProgram outputs(system, layout.address);
  std::mt19937_64 random(4);
  std::normal_distribution<double> number;
  std::array<std::vector<double>, 3> state;
  for (std::vector<double>& of : state) {
    for (std::size_t a = 0; a < layout.size; ++a) of.push_back(number(random));
  }
  const auto one = idx(layout.address[kOne]);
  for (std::size_t d = 0; d < 3; ++d) state[d][one] = d == 0 ? 1 : 0;
  const double* const q[3] = {state[0].data(), state[1].data(), state[2].data()};
  std::vector<double> out(column_names(system).size()), divisors(outputs.measures());
  const std::vector<double> turns(outputs.angles().size(), 0.0);
  outputs.evaluate(q, out.data(), turns.data(), divisors.data());

  const std::vector<std::size_t> columns = outputs.angles();
  ASSERT_EQ(columns.size(), system.measures.size());
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const MeasureForms& measure = system.measures[i];
    SCOPED_TRACE(measure.name);
    std::vector<Jet<double>> forms;
    double size[3] = {1, 1, 1};  // products of the lengths of the directions; the axis is a unit vector
    for (const Index f : measure.forms) {
      Jet<double> sum{0, 0, 0};
      for (const Term& t : system.form(f)) {
        const std::size_t a = idx(layout.address[idx(t.coordinate)]);
        sum += system.constants[idx(t.constant)] * Jet<double>{q[0][a], q[1][a], q[2][a]};
      }
      forms.push_back(sum);
      size[0] += std::abs(sum.value);
      size[1] += std::abs(sum.rate);
      size[2] += std::abs(sum.acceleration);
    }
    const Jet<double> exact = evaluate_measure<double>(measure.kind, forms, system.dimension);
    const double square = divisor_of<double>(measure.kind, forms, system.dimension), r = std::sqrt(square);
    const double s0 = size[0] * size[0] / r, s1 = size[0] * size[1] / r,
                 s2 = size[0] * size[2] / r + size[1] * size[1] / r;
    EXPECT_NEAR(out[columns[i]], exact.value, 16 * kEps * s0);
    EXPECT_NEAR(out[columns[i] + 1], exact.rate, 16 * kEps * s0 * s1);
    EXPECT_NEAR(out[columns[i] + 2], exact.acceleration, 16 * kEps * s0 * (s2 + s1 * s1));
    EXPECT_NEAR(divisors[i], square, 16 * kEps * s0 * r);
  }
}

// An angle against a constant direction is computed by linear forms, an angle between moving directions by products.
TEST(OutputProgram, AnglesAgainstConstantDirections) {
  expect_angles_by_products(parse_scene(R"({"assur": 1, "dimension": 2,
    "points": {"A": {"at": [0, 0], "fixed": true}, "D": {"at": [2, 0.5], "fixed": true}, "B": {"at": [0.8, 0]},
               "C": {"at": [1.6, 1.2]}},
    "constraints": {"coupler": {"distance": ["B", "C"], "value": 1.8},
                    "rocker": {"distance": ["D", "C"], "value": 1.3}},
    "drivers": {"motor": {"angle": ["A", "B"], "law": {"polynomial": [0, 6]}}},
    "measures": {"absolute": {"angle": ["D", "C"]}, "from": {"angle": [["A", "D"], ["D", "C"]]},
                 "to": {"angle": [["D", "C"], ["A", "D"]]}, "between": {"angle": [["A", "B"], ["B", "C"]]}},
    "time": {"start": 0, "end": 1, "step": 0.01}})"));
  std::string text;
  {
    std::ifstream file(std::string(ASSUR_SOURCE_DIR) + "/scenes/stewart.json");
    text.assign(std::istreambuf_iterator<char>(file), {});
  }
  const std::string before = "\"measures\": {";
  text.insert(text.find(before) + before.size(), R"("to": {"angle": ["e1", "inward1"], "axis": "a1"},
    "between": {"angle": ["e1", "r1"], "axis": "a1"}, "about": {"angle": ["e1", "inward1"], "axis": "c1"},)");
  expect_angles_by_products(parse_scene(text));
}

}  // namespace
}  // namespace assur
