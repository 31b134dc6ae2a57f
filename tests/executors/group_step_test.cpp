#include "program/group_step.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <bit>
#include <cmath>
#include <vector>

#include "assur/plan.hpp"
#include "assur/scene.hpp"
#include "equations/system.hpp"
#include "evaluation/evaluator.hpp"
#include "executors/executors.hpp"
#include "files/shipped_files.hpp"
#include "groups/branch.hpp"
#include "index.hpp"
#include "plan/preparation.hpp"
#include "program/step_rules.hpp"
#include "properties/small_random_scenes.hpp"

namespace assur {
namespace {

constexpr std::size_t kCases = 16;

// A class of groups with random predictions near the start, one in each case.
struct Setting {
  // off: how far predictions are from the solution
  Setting(const GroupedSystem& structure, std::int32_t c, test::Draw& draw, double off = 1e-5)
      : s(structure),
        group_class(s.classes[idx(c)]),
        blocks(group_class, 1),
        reads(blocks.reads(0).begin(), blocks.reads(0).end()) {
    std::vector<const SolvedGroup*> groups;
    for (const SolvedGroup& g : s.groups) {
      if (g.group_class == c) groups.push_back(&g);
    }
    for (std::size_t i = 0; i < kCases; ++i) {
      const SolvedGroup& g = *groups[i % groups.size()];
      Case& at = cases[i];
      std::vector<double> constants;
      for (const std::int32_t k : g.constants) constants.push_back(s.system->constants[idx(k)]);
      at.coefficients.resize(group_class.coefficients.size());
      bind_coefficients(group_class, constants.data(), at.coefficients.data(), 1);
      for (std::int32_t k = 0; k < group_class.inputs; ++k) {
        const bool moves = group_class.input_moves[idx(k)] != 0;
        at.inputs.push_back(s.start[idx(g.inputs[idx(k)])] + (moves ? draw.real(-off, off) : 0));
        at.input_rates.push_back(moves ? draw.real(-1, 1) : 0);
        at.input_accelerations.push_back(moves ? draw.real(-1, 1) : 0);
      }
      for (const Index u : g.unknowns) at.unknowns.push_back(s.start[idx(u)] + draw.real(-off, off));
      at.omega = 0.1;
    }
  }

  struct Case {
    std::vector<double> coefficients, inputs, input_rates, input_accelerations, unknowns;
    double omega;
  };

  [[nodiscard]] test::StepMemory memory(std::size_t first, int lanes, std::size_t work) const {
    const auto n = idx(group_class.n), inputs = idx(group_class.inputs);
    std::array<std::size_t, kMemories> sizes{};
    const auto size = [&](Memory memory) -> std::size_t& { return sizes[static_cast<std::size_t>(memory)]; };
    size(Memory::coefficients) = group_class.coefficients.size();
    for (const Memory of : {Memory::inputs, Memory::input_rates, Memory::input_accelerations}) size(of) = inputs;
    for (const Memory of : {Memory::unknowns, Memory::rates, Memory::accelerations, Memory::lipschitz}) size(of) = n;
    size(Memory::anchor) = size(Memory::anchor_rates) = reads.size();
    size(Memory::settings) = kGroupSettings;
    size(Memory::work) = work;
    size(Memory::figures) = kGroupFigures;
    test::StepMemory m(sizes, lanes);
    for (std::size_t l = 0; l < idx(lanes); ++l) {
      const Case& c = cases[first + l];
      const auto put = [&](Memory memory, const std::vector<double>& numbers) {
        for (std::size_t k = 0; k < numbers.size(); ++k) m({memory, static_cast<std::uint32_t>(k)}, l) = numbers[k];
      };
      put(Memory::coefficients, c.coefficients);
      put(Memory::inputs, c.inputs);
      put(Memory::input_rates, c.input_rates);
      put(Memory::input_accelerations, c.input_accelerations);
      put(Memory::unknowns, c.unknowns);
      for (std::size_t k = 0; k < reads.size(); ++k) {
        const auto reg = idx(reads[k]);
        m({Memory::anchor, static_cast<std::uint32_t>(k)}, l) = reg < n ? c.unknowns[reg] : c.inputs[reg - n];
      }
      for (std::size_t i = 0; i < n; ++i) m({Memory::lipschitz, static_cast<std::uint32_t>(i)}, l) = c.omega;
      m({Memory::omega, 0}, l) = c.omega;
      m({Memory::ball_used, 0}, l) = 0;
    }
    double* const settings = m.at[static_cast<std::size_t>(Memory::settings)];
    settings[slot_of(GroupSetting::converged_at).index] = kConverged;
    settings[slot_of(GroupSetting::most_iterations).index] = 10;
    settings[slot_of(GroupSetting::time).index] = 3;
    return m;
  }

  const GroupedSystem& s;
  const GroupClass& group_class;
  BlockConditions blocks;
  std::vector<std::int32_t> reads;
  std::array<Case, kCases> cases;
};

// Bits, but equal ones for all NaN: processors choose their payloads.
std::uint64_t bits(double x) { return std::isnan(x) ? ~std::uint64_t{0} : std::bit_cast<std::uint64_t>(x); }

// All that a lane leaves behind.
std::vector<std::uint64_t> bits_of(test::StepMemory& m, const Setting& at, std::size_t lane) {
  std::vector<std::uint64_t> all;
  for (std::size_t j = 0; j < idx(at.group_class.n); ++j) {
    for (const Memory memory : {Memory::unknowns, Memory::rates, Memory::accelerations}) {
      all.push_back(bits(m({memory, static_cast<std::uint32_t>(j)}, lane)));
    }
  }
  for (std::size_t f = 0; f < kGroupFigures; ++f)
    all.push_back(bits(m({Memory::figures, static_cast<std::uint32_t>(f)}, lane)));
  for (const Memory memory : {Memory::omega, Memory::ball_used, Memory::anchor_time}) {
    all.push_back(bits(m({memory, 0}, lane)));
  }
  for (std::size_t k = 0; k < at.reads.size(); ++k) {
    for (const Memory memory : {Memory::anchor, Memory::anchor_rates}) {
      all.push_back(bits(m({memory, static_cast<std::uint32_t>(k)}, lane)));
    }
  }
  return all;
}

// Against the evaluator of equations, and Eigen's LU.
void expect_solved(test::StepMemory& m, const Setting& at) {
  const auto n = static_cast<Eigen::Index>(at.group_class.n);
  const auto evaluator = make_evaluator(*at.s.system, at.group_class, 1);
  const std::span<const double> x(m.at[static_cast<std::size_t>(Memory::unknowns)], idx(at.group_class.n));
  const Setting::Case& c = at.cases[0];
  std::vector<double> coefficients = c.coefficients;
  Eigen::VectorXd phi(n), scale(n), rhs(n), values(at.group_class.pattern.nnz());
  evaluator->set_inputs(coefficients.data(), c.inputs.data());
  evaluator->evaluate(x.data(), phi.data(), values.data());
  evaluator->scale(scale.data());
  for (Eigen::Index i = 0; i < n; ++i) EXPECT_LE(std::abs(phi[i]), 2 * kConverged * scale[i]);
  Eigen::MatrixXd j = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index column = 0; column < n; ++column) {
    const auto& start = at.group_class.pattern.column_start;
    for (std::int32_t k = start[static_cast<std::size_t>(column)]; k < start[static_cast<std::size_t>(column) + 1];
         ++k) {
      j(at.group_class.pattern.row[idx(k)], column) = values[k];
    }
  }
  const Eigen::FullPivLU<Eigen::MatrixXd> lu(j);
  const double condition = 1 / std::max(lu.rcond(), kEps);
  const auto expect_near = [&](Memory memory, const Eigen::VectorXd& expected) {
    for (Eigen::Index i = 0; i < n; ++i) {
      EXPECT_NEAR(m({memory, static_cast<std::uint32_t>(i)}, 0), expected[i],
                  1e-14 * condition * (1 + expected.lpNorm<Eigen::Infinity>()));
    }
  };
  if (at.group_class.derivatives < 1) return;
  evaluator->velocity_rhs(c.input_rates.data(), rhs.data());
  const Eigen::VectorXd rates = lu.solve(rhs);
  expect_near(Memory::rates, rates);
  if (at.group_class.derivatives < 2) return;
  evaluator->acceleration_rhs(rates.data(), c.input_accelerations.data(), rhs.data());
  expect_near(Memory::accelerations, lu.solve(rhs));
}

// Against BlockConditions, which measure one group after the other.
void expect_anchor(test::StepMemory& m, const Setting& at) {
  const auto n = idx(at.group_class.n);
  const auto evaluator = make_evaluator(*at.s.system, at.group_class, 1);
  const Setting::Case& c = at.cases[0];
  std::vector<double> phi(n), scale(n), jacobian(at.group_class.pattern.nnz()), lipschitz(n, c.omega);
  evaluator->set_inputs(c.coefficients.data(), c.inputs.data());
  evaluator->evaluate(m.at[static_cast<std::size_t>(Memory::unknowns)], phi.data(), jacobian.data());
  evaluator->scale(scale.data());
  BlockConditions blocks(at.group_class, 1);
  double omega = 0, left = 0;
  blocks.measure(0, jacobian.data(), {lipschitz.data(), scale.data()}, nullptr, {&omega, &left});
  const bool renews = omega * kConverged * left <= kRoundingRoom;
  EXPECT_EQ(m(slot_of(GroupFigure::failed), 0), renews ? 0 : 1);
  if (!renews) return;
  EXPECT_NEAR(m({Memory::omega, 0}, 0), omega, 1e-9 * omega);
  EXPECT_EQ(m({Memory::ball_used, 0}, 0), 0);
  for (std::size_t k = 0; k < at.reads.size(); ++k) {
    const auto reg = static_cast<std::uint32_t>(at.reads[k]);
    const bool unknown = reg < n;
    const auto input = static_cast<std::uint32_t>(reg - n);
    EXPECT_EQ(m({Memory::anchor, static_cast<std::uint32_t>(k)}, 0),
              unknown ? m({Memory::unknowns, reg}, 0) : c.inputs[input]);
  }
}

// Every class of two or three unknowns of the shipped mechanisms: a step, and then a new anchor in every lane.
TEST(GroupStep, HasTheSameBitsForEveryExecutorAndNumberOfLanes) {
  test::Draw draw(2);
  int classes = 0, solved = 0;
  for (const auto& file : test::shipped_files()) {
    const Prepared prepared = prepare(read_scene(file), {.strategy = "irreducible/lanes"});
    const GroupedSystem& structure = *preparation(prepared).structure;
    for (std::int32_t c = 0; c < static_cast<std::int32_t>(structure.classes.size()); ++c) {
      const GroupClass& of = structure.classes[idx(c)];
      if (!has_group_step(of)) continue;
      SCOPED_TRACE(file.string() + ", class " + std::to_string(c));
      ++classes;
      const Setting at(structure, c, draw);
      const GroupProgram step = group_step(of, at.reads);
      const auto anchors = test::executors_of(anchor_program(of, at.reads));
      std::vector<std::vector<std::uint64_t>> expected;
      std::size_t number = 0;
      for (const test::NamedExecutor& e : test::executors_of(step.program)) {
        SCOPED_TRACE(e.name);
        const Executor& of_anchors = *anchors[number++].executor;
        for (std::size_t first = 0; first < kCases; first += idx(e.lanes)) {
          test::StepMemory m = at.memory(first, e.lanes, step.work);
          e.executor->run(m.at);
          for (std::size_t l = 0; l < idx(e.lanes); ++l) {
            const bool is_solved = m(slot_of(GroupFigure::failed), l) == 0;
            if (expected.size() > first + l) continue;
            solved += is_solved ? 1 : 0;
            if (is_solved && first + l == 0) expect_solved(m, at);
          }
          const bool is_solved = m(slot_of(GroupFigure::failed), 0) == 0;
          for (std::size_t l = 0; l < idx(e.lanes); ++l) {
            m(slot_of(GroupFigure::needs_anchor), l) = 1;
            m(slot_of(GroupFigure::ball_used), l) = 0.5;
          }
          of_anchors.run(m.at);
          for (std::size_t l = 0; l < idx(e.lanes); ++l) {
            const auto left = bits_of(m, at, l);
            if (expected.size() == first + l) {
              expected.push_back(left);
              if (is_solved && first + l == 0) expect_anchor(m, at);
            }
            ASSERT_EQ(left, expected[first + l]) << "case " << first + l;
          }
        }
      }
    }
  }
  EXPECT_GT(classes, 10);
  EXPECT_GT(solved, 8 * classes);  // the others are too close to a singular posture
}

// A point at given distances from three others, which are close together: cofactors alone leave large residuals.
TEST(GroupStep, RefinesLinearSolutionsWhereResidualsAreLarge) {
  test::Draw draw(3);
  for (const double apart : {1e-2, 1e-3, 3e-4}) {
    SCOPED_TRACE(apart);
    SceneBuilder b("steep", 3);
    b.fixed_point("P", {apart, 0, 0}).fixed_point("Q", {0, apart, 0}).point("C", {0, 0, 0}).point("T", {0.3, 0.2, 1});
    for (const std::string axis : {"x", "y", "z"}) {
      b.drive(axis, DrivenCoordinate{"C." + axis, Law::harmonics({{0.1 * apart, 3, 0}})});
    }
    for (const std::string of : {"P", "Q", "C"}) b.constrain("leg" + of, Distance{of, "T", std::nullopt});
    const Prepared prepared = prepare(b.time(0, 1, 0.01).build(), {.strategy = "irreducible/lanes"});
    ASSERT_EQ(preparation(prepared).structure->classes.size(), 1U);
    const Setting at(*preparation(prepared).structure, 0, draw, 1e-4 * apart * apart);
    ASSERT_TRUE(has_group_step(at.group_class));
    const GroupProgram step = group_step(at.group_class, at.reads);
    std::vector<std::vector<std::uint64_t>> expected;
    for (const test::NamedExecutor& e : test::executors_of(step.program)) {
      SCOPED_TRACE(e.name);
      for (std::size_t first = 0; first < kCases; first += idx(e.lanes)) {
        test::StepMemory m = at.memory(first, e.lanes, step.work);
        e.executor->run(m.at);
        if (first == 0 && e.lanes == 1) expect_solved(m, at);
        for (std::size_t l = 0; l < idx(e.lanes); ++l) {
          ASSERT_EQ(m(slot_of(GroupFigure::failed), l), 0);
          EXPECT_LE(m(slot_of(GroupFigure::velocity), l), kLinear);
          EXPECT_LE(m(slot_of(GroupFigure::acceleration), l), kLinear);
          if (expected.size() == first + l) expected.push_back(bits_of(m, at, l));
          ASSERT_EQ(bits_of(m, at, l), expected[first + l]) << "case " << first + l;
        }
      }
    }
  }
}

}  // namespace
}  // namespace assur
