#include "executors/executors.hpp"
#include "executors/step_code.hpp"
#include "fused.hpp"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "numbers.hpp"
#include "program/step_graph.hpp"
#include "properties/small_random_scenes.hpp"

namespace assur {
namespace {

constexpr std::uint32_t kSlots = 6;
constexpr std::array<std::size_t, kMemories> kOnlyWork = [] {
  std::array<std::size_t, kMemories> sizes{};
  sizes[static_cast<std::size_t>(Memory::work)] = kSlots;
  return sizes;
}();

// The operation as step_program.hpp defines it.
double apply(Op op, double a, double b, double c, double d) {
  switch (op) {
    case Op::add:
      return a + b;
    case Op::subtract:
      return a - b;
    case Op::multiply:
      return a * b;
    case Op::divide:
      return a / b;
    case Op::fma:
      return std::fma(a, b, c);
    case Op::fnma:
      return std::fma(-a, b, c);
    case Op::square_root:
      return std::sqrt(a);
    case Op::absolute:
      return std::abs(a);
    case Op::copy_sign:
      return std::copysign(a, b);
    case Op::round:
      return std::nearbyint(a);
    case Op::larger:
      return a > b ? a : b;
    case Op::select:
      return a <= b ? c : d;
    default:
      return kNan;
  }
}

// Bits, but equal ones for all NaN: processors choose their payloads.
std::uint64_t bits_of(double x) { return std::isnan(x) ? ~std::uint64_t{0} : std::bit_cast<std::uint64_t>(x); }

constexpr std::size_t kOperations = static_cast<std::size_t>(kLastOp) - static_cast<std::size_t>(kFirstArithmetic) + 1;
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr std::array kSpecial = {
    0.0, -0.0, 1.0, -1.0, 0.5, -2.5, 3.5, kInf, -kInf, kNan, 4.9e-324, -2.2e-308, 1.7e308, 4503599627370497.5, -0.25};

double any_number(test::Draw& draw) {
  if (draw.below(3) == 0) return kSpecial[draw.below(kSpecial.size())];
  return draw.real(-1, 1) * std::pow(10, draw.real(-12, 12));
}

// Each operation for all special numbers.
TEST(Executors, AgreeWithTheDefinitionOfEachOperation) {
  std::vector<std::array<double, 4>> cases;
  for (const double a : kSpecial) {
    for (const double b : kSpecial) {
      for (const double c : kSpecial) cases.push_back({a, b, c, 2.0});
    }
  }
  for (int op = static_cast<int>(kFirstArithmetic); op <= static_cast<int>(kLastOp); ++op) {
    Phase phase;
    for (std::uint32_t s = 0; s < 4; ++s) phase.code.push_back({Op::load, {}, {Memory::work, s}});
    phase.code.push_back({static_cast<Op>(op), {0, 1, 2, 3}, {}});
    phase.stores.push_back({{Memory::work, 4}, 4});
    for (const test::NamedExecutor& e : test::executors_of({{phase}})) {
      test::StepMemory memory(kOnlyWork, e.lanes);
      for (std::size_t first = 0; first < cases.size(); ++first) {
        const auto lanes = static_cast<std::size_t>(e.lanes);
        const auto in_lane = [&](std::size_t l) { return cases[(first + 7 * l) % cases.size()]; };
        for (std::size_t l = 0; l < lanes; ++l) {
          for (std::uint32_t s = 0; s < 4; ++s) memory({Memory::work, s}, l) = in_lane(l)[s];
        }
        e.executor->run(memory.at);
        for (std::size_t l = 0; l < lanes; ++l) {
          const auto [a, b, c, d] = in_lane(l);
          ASSERT_EQ(bits_of(memory({Memory::work, 4}, l)), bits_of(apply(static_cast<Op>(op), a, b, c, d)))
              << e.name << ", operation " << op << " of " << a << ", " << b << ", " << c;
        }
      }
    }
  }
}

// One phase of random operations on random slots; reference: what a loop over doubles makes of it.
TEST(Executors, GiveTheBitsOfTheDefinition) {
  test::Draw draw(1);
  for (int round = 0; round < 60; ++round) {
    Phase phase;
    for (std::uint32_t s = 0; s < kSlots; ++s) phase.code.push_back({Op::load, {}, {Memory::work, s}});
    phase.constants = {any_number(draw), 0.25};
    phase.code.push_back({Op::constant, {0}, {}});
    phase.code.push_back({Op::constant, {1}, {}});
    for (int i = 0; i < 60; ++i) {
      Instruction n{static_cast<Op>(static_cast<std::size_t>(kFirstArithmetic) + draw.below(kOperations)), {}, {}};
      if (n.op == Op::copy_sign) n.op = Op::absolute;  // the sign of NaN depends on the processor
      for (std::size_t k = 0; k < static_cast<std::size_t>(operands_of(n.op)); ++k) {
        n.operand[k] = static_cast<std::uint32_t>(draw.below(phase.code.size()));
      }
      phase.code.push_back(n);
    }
    const auto last = static_cast<std::uint32_t>(phase.code.size());
    for (std::uint32_t s = 0; s < kSlots; ++s) phase.stores.push_back({{Memory::work, s}, last - 1 - 9 * s});
    phase.stores.back().value = 0;  // a number as it was loaded, from a slot that was written before

    constexpr std::size_t kCases = 16;
    std::array<std::array<double, kSlots>, kCases> given;
    for (auto& numbers : given) {
      for (double& x : numbers) x = any_number(draw);
    }
    std::array<std::array<double, kSlots>, kCases> expected;
    for (std::size_t i = 0; i < kCases; ++i) {
      std::vector<double> values;
      for (const Instruction& n : phase.code) {
        const auto of = [&](std::size_t k) { return values.empty() ? 0 : values[n.operand[k] % values.size()]; };
        if (n.op == Op::load) {
          values.push_back(given[i][n.slot.index]);
        } else if (n.op == Op::constant) {
          values.push_back(phase.constants[n.operand[0]]);
        } else {
          values.push_back(apply(n.op, of(0), of(1), of(2), of(3)));
        }
      }
      for (const Phase::Store& s : phase.stores) expected[i][s.to.index] = values[s.value];
    }
    for (const test::NamedExecutor& e : test::executors_of({{phase}})) {
      SCOPED_TRACE(e.name + ", round " + std::to_string(round));
      const auto lanes = static_cast<std::size_t>(e.lanes);
      for (std::size_t first = 0; first < kCases; first += lanes) {
        test::StepMemory memory(kOnlyWork, e.lanes);
        for (std::size_t l = 0; l < lanes; ++l) {
          for (std::uint32_t s = 0; s < kSlots; ++s) memory({Memory::work, s}, l) = given[first + l][s];
        }
        e.executor->run(memory.at);
        for (std::size_t l = 0; l < lanes; ++l) {
          for (std::uint32_t s = 0; s < kSlots; ++s) {
            ASSERT_EQ(bits_of(memory({Memory::work, s}, l)), bits_of(expected[first + l][s])) << "slot " << s;
          }
        }
      }
    }
  }
}

// Heron's method: each lane repeats as often as it needs, whatever its neighbours do.
TEST(Executors, RepeatAPhaseForEachLane) {
  Graph g;
  const Slot root{Memory::work, 0}, square{Memory::work, 1}, active{Memory::work, 2}, count{Memory::work, 3};
  const Value x = g.load(root), zero = Value::set(0), one = Value::set(1);
  const Value next = (x + g.load(square) / x) * Value::set(0.5);
  const Value moved = abs(next - x) - Value::set(1e-15) * next;
  g.store(root, if_at_most(g.load(active), zero, x, next));
  g.store(count, g.load(count) + g.load(active));
  g.store(active, if_at_most(g.load(active), zero, zero, if_at_most(moved, zero, zero, one)));
  Phase phase = g.phase();
  phase.repeat_while = active;
  std::vector<double> alone;
  for (const test::NamedExecutor& e : test::executors_of({{phase}})) {
    SCOPED_TRACE(e.name);
    for (std::size_t first = 0; first < 16; first += static_cast<std::size_t>(e.lanes)) {
      test::StepMemory memory(kOnlyWork, e.lanes);
      for (std::size_t l = 0; l < static_cast<std::size_t>(e.lanes); ++l) {
        memory({Memory::work, 0}, l) = 1;
        memory({Memory::work, 1}, l) = std::pow(10, static_cast<double>(first + l));
        memory({Memory::work, 2}, l) = first + l == 5 ? 0 : 1;
      }
      e.executor->run(memory.at);
      for (std::size_t l = 0; l < static_cast<std::size_t>(e.lanes); ++l) {
        const std::size_t i = first + l;
        EXPECT_DOUBLE_EQ(memory({Memory::work, 0}, l), i == 5 ? 1 : std::sqrt(memory({Memory::work, 1}, l)));
        if (alone.size() == i) alone.push_back(memory({Memory::work, 3}, l));
        EXPECT_EQ(memory({Memory::work, 3}, l), alone[i]);
      }
    }
  }
  EXPECT_EQ(alone[5], 0);
  EXPECT_GT(alone[15], alone[1]);
}

// Each reach of a load and of a store, in two groups.
TEST(Executors, FindNumbersByTheirReach) {
  constexpr std::uint32_t kFrom = 3, kOne = 5, kTo = 40;
  for (const int lanes : {1, 2, 4, 8, 16}) {
    const auto w = static_cast<std::size_t>(lanes);
    StepProgram program;
    for (std::size_t l = 0; l < w; ++l) program.addresses.push_back(static_cast<std::int32_t>(l * 7 % 16));
    Graph g;
    const Value row = g.load({Memory::state, 1, Reach::row, 1}), from = g.load({Memory::state, kFrom, Reach::from, 1});
    const Value one = g.load({Memory::state, kOne, Reach::one, 1});
    const Value apart = g.load({Memory::state, 0, Reach::scattered, 1});
    g.store({Memory::outputs, 0, Reach::row}, row + apart);
    g.store({Memory::outputs, 17, Reach::from}, from);
    g.store({Memory::outputs, 35, Reach::one}, one + from);
    g.store({Memory::outputs, kTo, Reach::from}, apart * one);
    program.phases.push_back(g.phase());
    std::vector<double> given(48), taken(64);
    for (std::size_t i = 0; i < given.size(); ++i) given[i] = 1 + static_cast<double>(i * i);
    std::vector<double*> memory(2 * kMemories, nullptr);
    memory[memory_of({Memory::state, 0, Reach::row, 1})] = given.data();
    memory[memory_of({Memory::outputs})] = taken.data();
    std::vector<double> expected(taken.size(), -1);
    for (std::size_t l = 0; l < w; ++l) {
      const double of_lane = given[static_cast<std::size_t>(program.addresses[l])];
      expected[l] = given[w + l] + of_lane;
      expected[17 + l] = given[kFrom + l];
      expected[kTo + l] = of_lane * given[kOne];
    }
    expected[35] = given[kOne] + given[kFrom];
    for (const test::NamedExecutor& e : test::executors_of(program, {lanes})) {
      SCOPED_TRACE(e.name);
      std::fill(taken.begin(), taken.end(), -1);
      e.executor->run(memory);
      EXPECT_EQ(taken, expected);
    }
  }
}

// What processors without fused products do: close to cancellation, where bits of the product decide, and everywhere.
TEST(Fused, IsRoundedOnce) {
  std::mt19937_64 random(5);
  const auto bits = [](double x) { return std::isnan(x) ? ~std::uint64_t{0} : std::bit_cast<std::uint64_t>(x); };
  const auto number = [&](int kind) {
    if (kind == 0) return std::bit_cast<double>(random());
    const double digits = static_cast<double>(static_cast<std::int64_t>(random())) * 0x1p-63;
    return std::ldexp(digits, static_cast<int>(random() % 200) - 100);
  };
  for (int k = 0; k < 2'000'000; ++k) {
    const double a = k % 13 == 0 ? 0 : number(k % 2), b = number(k % 3);
    double c = number(k % 5);
    if (k % 7 == 0) c = -a * b;
    if (k % 11 == 0) c = -a * b * (1 + std::ldexp(1.0, -static_cast<int>(random() % 60)));
    ASSERT_EQ(bits(fused_number(a, b, c)), bits(std::fma(a, b, c))) << a << " " << b << " " << c;
  }
}

// Each lane picks its own number of a table that all share.
TEST(Executors, PickNumbersByTheirPlace) {
  constexpr std::uint32_t kFirst = 2;
  for (const int lanes : {1, 2, 4, 8, 16}) {
    Graph g;
    const Value place = g.load({Memory::work, 0}), next = place + Value::set(1);
    const Value taken = g.pick({Memory::factors, kFirst, Reach::one}, place);
    const Value far = g.pick({Memory::factors, kFirst, Reach::one}, taken);
    g.store({Memory::work, 1}, far + g.pick({Memory::factors, kFirst, Reach::one}, next) * place);
    g.store({Memory::work, 2}, if_at_most(taken, place, taken, place));
    const StepProgram program{{g.phase()}};
    std::vector<double> table = {-1, -1};  // and then, from kFirst on: k -> 3 k mod 20
    for (int k = 0; k < 20; ++k) table.push_back(3 * k % 20);
    const auto at = [&](std::size_t k) { return table[kFirst + k]; };
    for (const test::NamedExecutor& e : test::executors_of(program, {lanes})) {
      SCOPED_TRACE(e.name);
      test::StepMemory memory(kOnlyWork, lanes);
      memory.at[static_cast<std::size_t>(Memory::factors)] = table.data();
      const auto place_in = [](std::size_t lane) { return (5 * lane + 3) % 19; };
      for (std::size_t l = 0; l < static_cast<std::size_t>(lanes); ++l) {
        memory({Memory::work, 0}, l) = static_cast<double>(place_in(l));
      }
      e.executor->run(memory.at);
      for (std::size_t l = 0; l < static_cast<std::size_t>(lanes); ++l) {
        const std::size_t k = place_in(l);
        const auto there = static_cast<std::size_t>(at(k));
        EXPECT_EQ(memory({Memory::work, 1}, l), at(there) + at(k + 1) * static_cast<double>(k));
        EXPECT_EQ(memory({Memory::work, 2}, l), std::min(at(k), static_cast<double>(k)));
      }
    }
  }
}

// More lanes than vectors are written for, one after the other.
TEST(Executors, LoopOverManyLanes) {
  for (const int lanes : {40, 72, 1000}) {
    const auto w = static_cast<std::size_t>(lanes);
    Graph g;
    const Value row = g.load({Memory::state, 1}), from = g.load({Memory::state, 5, Reach::from});
    const Value one = g.load({Memory::factors, 1, Reach::one});
    g.store({Memory::outputs, 0}, row * one + from);
    g.store({Memory::outputs, 2 * static_cast<std::uint32_t>(lanes) + 3, Reach::from}, row - from);
    StepProgram program{{g.phase()}};
    program.phases[0].lanes = lanes;
    Graph next;  // reads what the first phase stored, and is no loop
    next.store({Memory::work, 0, Reach::one}, next.load({Memory::outputs, 7, Reach::one}) + Value::set(1));
    program.phases.push_back(next.phase());
    program.phases[1].lanes = 1;
    std::vector<double> given(2 * w), taken(3 * w + 3, -1), expected = taken, factors = {0, 3}, work(1);
    for (std::size_t i = 0; i < given.size(); ++i) given[i] = 1 + static_cast<double>(i * i);
    std::array<double*, kMemories> memory{};
    memory[static_cast<std::size_t>(Memory::state)] = given.data();
    memory[static_cast<std::size_t>(Memory::factors)] = factors.data();
    memory[static_cast<std::size_t>(Memory::outputs)] = taken.data();
    memory[static_cast<std::size_t>(Memory::work)] = work.data();
    for (std::size_t l = 0; l < w; ++l) {
      expected[l] = given[w + l] * 3 + given[5 + l];
      expected[2 * w + 3 + l] = given[w + l] - given[5 + l];
    }
    const auto executors = test::executors_of(program, {8});
    const bool has_code = (hwy::SupportedTargets() & HWY_AVX2) != 0 && step_code() != nullptr;
    EXPECT_GE(executors.size(), has_code ? 2 : 1);
    for (const test::NamedExecutor& e : executors) {
      SCOPED_TRACE(e.name + ", " + std::to_string(lanes));
      std::fill(taken.begin(), taken.end(), -1);
      e.executor->run(memory);
      EXPECT_EQ(taken, expected);
      EXPECT_EQ(work[0], expected[7] + 1);
    }
  }
}

// The number k, `length` times added to a number in memory.
StepProgram sum_program(double k, std::uint32_t length) {
  Phase phase;
  phase.constants = {k};
  phase.code = {{Op::load, {}, {Memory::work, 0}}, {Op::constant, {0}, {}}};
  for (std::uint32_t i = 0; i < length; ++i) phase.code.push_back({Op::add, {i == 0 ? 0 : i + 1, 1}, {}});
  phase.stores = {{{Memory::work, 1}, length + 1}};
  return {{phase}, {}};
}

// Machine code is not made for ever, but what there is serves all.
TEST(StepCode, EndsWithTheTimeForIt) {
  const auto code = step_code();
  if (!code) GTEST_SKIP() << "this processor or this build has no machine code";
  constexpr std::uint32_t kLength = 4'000;
  constexpr std::size_t kFit = kMostOfAll / (kLength + 2);
  for (std::size_t k = 0; k < kFit; ++k) EXPECT_NE(code->of(sum_program(1.0 + double(k), kLength), 1), nullptr);
  EXPECT_EQ(code->of(sum_program(100, kLength), 1), nullptr);
  EXPECT_EQ(code->of(sum_program(101, 1), 1), nullptr);
  EXPECT_NE(code->of(sum_program(1, kLength), 1), nullptr);
  EXPECT_NE(step_code()->of(sum_program(100, kLength), 1), nullptr);
  EXPECT_NE(code->of(sum_program(100, kLength), 1), nullptr);
}

TEST(Executors, DeclineOperationsThatTheyLack) {
  Graph g;
  g.store({Memory::work, 0}, abs(g.load({Memory::work, 1})));
  StepProgram program{{g.phase()}};
  ASSERT_NE(make_interpreter(program, 4), nullptr);
  program.phases[0].code.back().op = static_cast<Op>(200);
  EXPECT_EQ(make_interpreter(program, 4), nullptr);
  EXPECT_EQ(make_machine_code(program, 4, VectorCode::avx2), nullptr);
}

TEST(Executors, GoWithoutCodeWhereTheSystemRefusesIt) {
  Graph g;
  g.store({Memory::work, 0}, abs(g.load({Memory::work, 1})));
  EXPECT_EQ(make_machine_code({{g.phase()}}, 4, VectorCode::avx2, [](void*, std::size_t) { return false; }), nullptr);
}

}  // namespace
}  // namespace assur
