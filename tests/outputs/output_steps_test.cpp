// Outputs of mechanisms side by side have the bits of each mechanism alone.
#include "outputs/output_steps.hpp"

#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "assur/assur.hpp"
#include "executors/step_code.hpp"
#include "motion/layout.hpp"
#include "numbers.hpp"
#include "outputs/angle_kernels.hpp"
#include "plan/preparation.hpp"
#include "source_dir.hpp"

namespace assur {
namespace {

// Mechanisms of one structure at an arbitrary state, one in each lane.
struct SideBySide {
  SideBySide(const std::vector<Scene>& scenes, int lanes) : w(idx(lanes)) {
    for (const Scene& scene : scenes) prepared.push_back(prepare(scene, {"irreducible/eigen", {}}));
    const Layout layout = lay_out_side_by_side(preparation(prepared[0]), lanes);
    for (std::size_t l = 0; l < w; ++l) {
      outputs.emplace_back(*preparation(prepared[l % prepared.size()]).structure->system, layout.address);
    }
    std::mt19937_64 random(5);
    std::normal_distribution<double> number;
    for (auto* arrays : {&state, &change}) {
      for (std::vector<double>& of : *arrays) {
        for (std::size_t a = 0; a < layout.size; ++a) of.push_back(number(random));
      }
      for (std::size_t d = 0; d < 3; ++d) {
        std::fill_n((*arrays)[d].begin() + layout.address[kOne], w, arrays == &state && d == 0 ? 1.0 : 0.0);
      }
    }
  }

  using Arrays = std::array<std::vector<double>, 3>;
  std::size_t w;
  std::vector<Prepared> prepared;
  std::vector<OutputProgram> outputs;
  Arrays state, change;
};

void expect_bits_of_each_alone(const std::vector<Scene>& scenes, int lanes, const std::shared_ptr<StepCode>& code) {
  SCOPED_TRACE(scenes[0].name() + " in " + std::to_string(lanes) + (code != nullptr ? " lanes by code" : " lanes"));
  SideBySide s(scenes, lanes);
  const std::size_t w = s.w, columns = s.outputs[0].columns(), angles = s.outputs[0].angles().size(),
                    measures = s.outputs[0].measures();
  OutputSteps steps(s.outputs, code);
  steps.bind(w);
  std::vector<double> turns, rows(columns * w), divisors(measures * w), changes(columns * w);
  for (std::size_t i = 0; i < angles * w; ++i) turns.push_back(static_cast<double>(i % 7) - 3);
  const double* const q[3] = {s.state[0].data(), s.state[1].data(), s.state[2].data()};
  const double* const by[3] = {s.change[0].data(), s.change[1].data(), s.change[2].data()};
  steps.evaluate(q, rows.data(), turns.data(), divisors.data());
  for (int k = 0; k < 250; ++k) steps.differentiate(q, by, nullptr, changes.data());  // by code in the end
  LaneArray vectors(2 * padded(angles * w));
  const bool has_arms = steps.arms(q[0], vectors.data());
  for (std::size_t l = 0; l < w; ++l) {
    SCOPED_TRACE(l);
    const OutputProgram& alone = s.outputs[l];
    const double* const of[3] = {q[0] + l, q[1] + l, q[2] + l};
    const double* const along[3] = {by[0] + l, by[1] + l, by[2] + l};
    std::vector<double> row(columns), own_turns(angles), own_divisors(measures), slopes(columns);
    for (std::size_t i = 0; i < angles; ++i) own_turns[i] = turns[i * w + l];
    alone.evaluate(of, row.data(), own_turns.data(), own_divisors.data());
    alone.differentiate(of, along, nullptr, slopes.data());
    alone.add_up(row.data());
    std::vector<double> lane(columns);
    for (std::size_t c = 0; c < columns; ++c) lane[c] = rows[c * w + l];
    alone.add_up(lane.data());
    EXPECT_EQ(lane, row);
    for (std::size_t i = 0; i < measures; ++i) EXPECT_EQ(divisors[i * w + l], own_divisors[i]) << i;
    for (std::size_t c = 0; c < columns; ++c) EXPECT_EQ(changes[c * w + l], slopes[c]) << c;
    for (std::size_t i = 0; i < angles && has_arms; ++i) {
      double x = 0, y = 0;
      alone.arm(i, of[0], x, y);
      EXPECT_EQ(vectors[i * w + l], x) << i;
      EXPECT_EQ(vectors[padded(angles * w) + i * w + l], y) << i;
    }
  }
}

void expect_bits_of_each_alone(const std::vector<Scene>& scenes) {
  const auto code = step_code();
  for (const int lanes : {1, 2, 4, 8, 16}) {
    expect_bits_of_each_alone(scenes, lanes, nullptr);
    if (code) expect_bits_of_each_alone(scenes, lanes, code);
  }
}

std::vector<Scene> members(const Scene& scene, const std::string& parameter, const std::vector<double>& values) {
  std::vector<Scene> out;
  for (const double value : values) out.push_back(scene.with_values({{parameter, value}}));
  return out;
}

Scene stewart() { return read_scene(std::string(ASSUR_SOURCE_DIR) + "/scenes/stewart.json").with_outputs({"all"}); }

TEST(OutputSteps, HaveTheBitsOfEachMechanismAlone) {
  expect_bits_of_each_alone(members(stewart(), "rod", {0.55, 0.552, 0.548}));
  const Scene four_bar = read_scene(std::string(ASSUR_SOURCE_DIR) + "/scenes/four_bar.json");
  expect_bits_of_each_alone(members(four_bar, "coupler_length", {1.8, 1.79}));
  expect_bits_of_each_alone({sample("double_wishbone")});  // with distances
  expect_bits_of_each_alone({sample("delta")});
  expect_bits_of_each_alone({sample("slider_crank")});
}

std::vector<double> numbers(const OutputProgram& program) {
  std::vector<double> all;
  program.each_number([&](double x) { all.push_back(x); });
  EXPECT_EQ(all.size(), program.numbers());
  return all;
}

TEST(OutputSteps, ARenewedProgramIsTheBoundOne) {
  const Scene four_bar = read_scene(std::string(ASSUR_SOURCE_DIR) + "/scenes/four_bar.json");
  for (const auto& scenes : {members(stewart(), "toe", {0.2, 0.21}), members(four_bar, "crank_length", {0.8, 0.79})}) {
    const SideBySide s(scenes, 2);
    OutputProgram renewed = s.outputs[0];
    ASSERT_TRUE(renewed.renew(*preparation(s.prepared[1]).structure->system));
    EXPECT_TRUE(renewed.same_shape(s.outputs[1]));
    EXPECT_EQ(numbers(renewed), numbers(s.outputs[1]));
  }
}

// The constant direction of one member lies along an axis, so that terms of its angle vanish.
TEST(OutputSteps, MechanismsMayHaveProgramsOfAnotherShape) {
  const Scene straight = parse_scene(R"({"assur": 1, "dimension": 2, "parameters": {"rise": 0},
    "points": {"A": {"at": [0, 0], "fixed": true}, "D": {"at": [2, "=rise"], "fixed": true}, "B": {"at": [0.8, 0]},
               "C": {"at": [1.6, 1.2]}},
    "constraints": {"coupler": {"distance": ["B", "C"], "value": 1.8},
                    "rocker": {"distance": ["D", "C"], "value": 1.3}},
    "drivers": {"motor": {"angle": ["A", "B"], "law": {"polynomial": [0, 6]}}},
    "measures": {"from": {"angle": [["A", "D"], ["D", "C"]]}, "between": {"angle": [["A", "B"], ["B", "C"]]}},
    "time": {"start": 0, "end": 1, "step": 0.01}})");
  const Scene tilted = straight.with_values({{"rise", 0.2}});
  const SideBySide s({straight, tilted}, 2);
  EXPECT_FALSE(s.outputs[0].same_shape(s.outputs[1]));
  EXPECT_TRUE(s.outputs[0].same_shape(s.outputs[0]));
  OutputProgram renewed = s.outputs[0];
  EXPECT_FALSE(renewed.renew(*preparation(s.prepared[1]).structure->system));
  expect_bits_of_each_alone({straight, tilted});
}

}  // namespace
}  // namespace assur
