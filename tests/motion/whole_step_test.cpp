// Steps of small mechanisms are one call of machine code; what it declines is solved without it, with the same bits.
#include "motion/whole_step.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "assur/simulator.hpp"
#include "drivers/drive_program.hpp"
#include "equations/lowering.hpp"
#include "equations/system.hpp"
#include "executors/step_code.hpp"
#include "files/shipped_files.hpp"
#include "numbers.hpp"
#include "plan/preparation.hpp"
#include "properties/small_random_scenes.hpp"
#include "simulation/same_run.hpp"

namespace assur {
namespace {

// Machine code whose calls are counted: of steps of single groups, of mechanisms, and of other programs.
class CountingCode final : public StepCode {
 public:
  explicit CountingCode(std::shared_ptr<StepCode> code) : code_(std::move(code)) {}

  [[nodiscard]] std::string vectors() const override { return code_->vectors(); }
  CodeOfStep of(const GroupClass& group_class, std::span<const std::int32_t> reads, int lanes) override {
    CodeOfStep out = code_->of(group_class, reads, lanes);
    if (out.executor) out.executor = std::make_shared<Counting>(out.executor, calls_of_groups);
    return out;
  }
  CodeOfClass of(const GroupClass& group_class, const lanes::Elimination& elimination,
                 std::span<const std::int32_t> reads, int lanes, bool makes) override {
    CodeOfClass out = code_->of(group_class, elimination, reads, lanes, makes);
    if (out.step) out.step = std::make_shared<Counting>(out.step, calls_of_classes);
    if (out.changes) out.changes = std::make_shared<Counting>(out.changes, changes);
    return out;
  }
  std::shared_ptr<const Executor> of(const StepProgram& program, int lanes) override {
    auto out = code_->of(program, lanes);
    const bool has_groups = std::any_of(program.phases.begin(), program.phases.end(),
                                        [](const Phase& phase) { return phase.repeat_while.has_value(); });
    if (out) out = std::make_shared<Counting>(out, has_groups ? calls_of_mechanisms : other_calls);
    return out;
  }

  int calls_of_groups = 0, calls_of_mechanisms = 0, calls_of_classes = 0, changes = 0, other_calls = 0;

 private:
  class Counting final : public Executor {
   public:
    Counting(std::shared_ptr<const Executor> executor, int& calls) : executor_(std::move(executor)), calls_(calls) {}
    void run(std::span<double* const> memory) const override {
      ++calls_;
      executor_->run(memory);
    }

   private:
    std::shared_ptr<const Executor> executor_;
    int& calls_;
  };
  std::shared_ptr<StepCode> code_;
};

class WholeStepTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!step_code()) GTEST_SKIP() << "no machine code here";
    code_ = std::make_shared<CountingCode>(step_code());
  }
  Simulator simulator(const Scene& scene, const std::string& strategy, const StepSettings& settings = {}) {
    Preparation prepared = preparation(prepare(scene, {.strategy = strategy}));
    prepared.code = code_;
    return Simulator(Preparation::shared(std::move(prepared)), settings);
  }
  std::shared_ptr<CountingCode> code_;
};

TEST_F(WholeStepTest, IsOneCallForASmallMechanism) {
  const std::pair<const char*, const char*> cases[] = {
      {"four_bar", "lanes"}, {"slider_crank", "lanes"}, {"jansen", "lanes"},    {"klann", "lanes"},
      {"watt", "lanes"},     {"four_bar:10", "lanes"},  {"stewart", "lanes:8"}, {"jansen", "lanes:8"}};
  for (const auto& [name, solver] : cases) {
    SCOPED_TRACE(std::string(name) + " " + solver);
    const Scene scene = sample(name);
    Simulator s = simulator(scene, std::string("irreducible/") + solver);
    code_->calls_of_groups = code_->calls_of_mechanisms = 0;
    for (int k = 1; k <= 50; ++k) ASSERT_TRUE(s.step(scene.time().time(k)).ok());
    EXPECT_EQ(code_->calls_of_groups, 0);
    EXPECT_GE(code_->calls_of_mechanisms, 50);
  }
}

TEST_F(WholeStepTest, LeavesLongMechanismsToSingleGroups) {
  const Scene chain = sample("four_bar:100");
  Simulator s = simulator(chain, "irreducible/lanes");
  for (int k = 1; k <= 5; ++k) ASSERT_TRUE(s.step(chain.time().time(k)).ok());
  EXPECT_EQ(code_->calls_of_mechanisms, 0);
  EXPECT_GE(code_->calls_of_groups, 500);
}

TEST_F(WholeStepTest, ServesLargerClasses) {
  constexpr int kSteps = 200;
  for (const char* name : {"delta", "sarrus", "double_wishbone", "three_rps"}) {
    SCOPED_TRACE(name);
    const Scene scene = sample(name);
    Simulator s = simulator(scene, "irreducible/lanes");
    code_->calls_of_classes = code_->changes = 0;
    for (int k = 1; k <= kSteps; ++k) ASSERT_TRUE(s.step(scene.time().time(k)).ok());
    EXPECT_GE(code_->calls_of_classes, kSteps);
    EXPECT_GT(code_->changes, 0);
  }
}

TEST_F(WholeStepTest, LeavesWhatIsUnusualToTheGeneralPath) {
  const Scene scene = sample("slider_crank");
  EXPECT_EQ(test::expect_same_by_code(scene, "irreducible/lanes").counters.rejected, 0);
  StepSettings few;
  few.most_iterations = 1;
  EXPECT_GT(test::expect_same_by_code(scene.with_time({0, 1, 0.02}), "irreducible/lanes", few).counters.rejected, 0);
  StepSettings fixed;
  fixed.iterations = 3;
  EXPECT_TRUE(test::expect_same_by_code(scene, "irreducible/lanes", fixed).status.ok());
  const auto overflows = [](const std::string&, const Law&) {
    return Law::harmonics({{1, 1, 0}}) + Law::polynomial({0, 0, 0, 0, 0, 0, 0, 0, 1e305});
  };
  EXPECT_FALSE(
      test::expect_same_by_code(scene.with_time({0, 20, 0.5}).with_laws(overflows), "irreducible/lanes").status.ok());
}

// Driven coordinates by machine code and by kernels, also for angles that are too large for both.
void expect_the_same_laws(const Scene& scene, StepCode& code) {
  const System system = lower(std::make_shared<const Scene>(scene), {}, false);
  DriveProgram by_kernels(system, all_driven(system)), by_code = by_kernels;
  by_code.use(code);
  for (const double t : {0.0, 0.1, 1.7, -3.4, 1e3, 1e5, 1e9}) {
    std::vector<double> expected[3], found[3];
    for (auto* all : {&expected, &found}) {
      for (std::vector<double>& v : *all) v.assign(system.coordinates.size(), 0.0);
    }
    by_kernels.evaluate(t);
    by_kernels.place({expected[0].data(), expected[1].data(), expected[2].data()});
    by_code.evaluate(t);
    by_code.place({found[0].data(), found[1].data(), found[2].data()});
    EXPECT_EQ(by_kernels.defined(), by_code.defined());
    for (std::size_t d = 0; d < 3; ++d) {
      for (std::size_t i = 0; i < expected[d].size(); ++i) {
        const bool both_nan = std::isnan(expected[d][i]) && std::isnan(found[d][i]);
        EXPECT_TRUE(both_nan || test::same_bits(found[d][i], expected[d][i])) << t << ", " << d << ", " << i;
      }
    }
  }
}

TEST_F(WholeStepTest, HasTheLawsOfTheKernels) {
  const auto as_it_is = [](const std::string&, const Law& law) { return law; };
  const auto with_table = [](const std::string&, const Law& law) {
    return law + Law::table({0, 0.3, 1, 2.5}, {0, 0.01, -0.02, 0}, true);
  };
  // Tables of different lengths; some end before the last times.
  test::Draw draw(4);
  const auto with_tables = [&](const std::string&, const Law& law) {
    Law sum = law;
    for (std::size_t count = draw.below(3); count > 0; --count) {
      const bool is_monotone = draw.below(2) == 0, repeats = draw.below(2) == 0;
      std::vector<double> time = {draw.real(-9, 0)}, value = {draw.real(-0.01, 0.01)};
      for (std::size_t k = draw.below(40) + 15; k > 0; --k) {
        time.push_back(time.back() + draw.real(0.5, is_monotone ? 9 : 1));
        value.push_back(draw.real(-0.01, 0.01));
      }
      if (repeats) value.back() = value.front();
      sum = sum + Law::table(time, value, repeats, is_monotone);
    }
    return sum;
  };
  for (const auto& file : test::shipped_files()) {
    SCOPED_TRACE(file.string());
    const Scene scene = read_scene(file);
    for (const std::function<Law(const std::string&, const Law&)>& laws :
         {std::function<Law(const std::string&, const Law&)>(as_it_is), {with_table}, {with_tables}}) {
      code_->other_calls = 0;
      expect_the_same_laws(scene.with_laws(laws), *code_);
      EXPECT_EQ(code_->other_calls, 7);
    }
  }
}

}  // namespace
}  // namespace assur
