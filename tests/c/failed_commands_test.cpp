// Failed commands leave nothing behind, called from C.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "assur/assur.h"
#include "properties/random_count.hpp"
#include "properties/small_random_scenes.hpp"

namespace {

constexpr const char* kLegs[] = {"leg1", "leg2", "leg3"};

// The platform of three legs, as text: its drivers rest at the start.
constexpr const char* kPlatform = R"({"assur": 1, "name": "platform", "dimension": 2,
  "points": {"A": {"at": [0, 0], "fixed": true}, "B": {"at": [3, 1.1], "fixed": true}, "C": {"at": [1.5, 3], "fixed": true},
             "P": {"at": [1, 1.2]}, "Q": {"at": [2, 1.1]}, "R": {"at": [1.5, 1.9]}},
  "constraints": {"PQ": {"distance": ["P", "Q"]}, "QR": {"distance": ["Q", "R"]}, "RP": {"distance": ["R", "P"]}},
  "drivers": {"leg1": {"distance": ["A", "P"], "law": {"constant": 1.5620499351813309}},
              "leg2": {"distance": ["B", "Q"], "law": {"constant": 1}},
              "leg3": {"distance": ["C", "R"], "law": {"constant": 1.1}}})";

struct Robot {
  assur_scene* scene = nullptr;
  assur_plan* plan = nullptr;
  assur_simulator *every = nullptr, *successful = nullptr;  // commands that the simulator gets
  assur_state* state = nullptr;

  explicit Robot(bool has_grid) {
    const std::string text =
        std::string(kPlatform) + (has_grid ? R"(, "time": {"start": 0, "end": 1, "step": 0.01}})" : "}");
    assur_options options = ASSUR_OPTIONS;
    options.controlled = kLegs;
    options.controlled_count = 3;
    options.threads = 1;
    options.strategy = "irreducible/eigen";  // keeps no pivots from one matrix to the next
    EXPECT_EQ(assur_scene_parse(text.data(), text.size(), &scene), ASSUR_OK) << assur_error();
    EXPECT_EQ(assur_prepare(scene, &options, &plan), ASSUR_OK) << assur_error();
    EXPECT_EQ(assur_simulator_new(plan, nullptr, &every), ASSUR_OK);
    EXPECT_EQ(assur_simulator_new(plan, nullptr, &successful), ASSUR_OK);
  }
  Robot(const Robot&) = delete;
  Robot& operator=(const Robot&) = delete;
  ~Robot() {
    assur_state_free(state);
    assur_simulator_free(every);
    assur_simulator_free(successful);
    assur_plan_free(plan);
    assur_scene_free(scene);
  }
  [[nodiscard]] std::vector<double> row(const assur_simulator* s) const {
    const double* const all = assur_simulator_outputs(s);
    return {all, all + assur_simulator_column_count(s)};
  }
};

TEST(C, ARejectedTargetDoesNotMoveTheRobotLater) {
  const Robot r(true);
  ASSERT_EQ(assur_simulator_set(r.every, 0, 1.58, 0, 0), ASSUR_OK);
  ASSERT_EQ(assur_simulator_step(r.every, nullptr), ASSUR_OK);
  const std::vector<double> there = r.row(r.every);
  ASSERT_EQ(assur_simulator_set(r.every, 0, 9, 0, 0), ASSUR_OK);
  assur_status status;
  ASSERT_EQ(assur_simulator_step(r.every, &status), ASSUR_FOLD);
  EXPECT_EQ(r.row(r.every), there);
  for (int k = 0; k < 2; ++k) {
    const double next = assur_simulator_time(r.every) + 1e-3;
    ASSERT_EQ(k == 0 ? assur_simulator_step(r.every, nullptr) : assur_simulator_step_to(r.every, next, nullptr),
              ASSUR_OK);
    for (std::size_t i = 0; i < there.size(); ++i) EXPECT_NEAR(r.row(r.every)[i], there[i], 1e-14);
  }
}

TEST(C, StepsWithoutATimeGridReachTheirTargets) {
  const Robot r(false);
  std::size_t x = 0;
  ASSERT_EQ(assur_simulator_column(r.every, "P.x", &x), ASSUR_OK);
  const double before = assur_simulator_outputs(r.every)[x];
  ASSERT_EQ(assur_simulator_set(r.every, 0, 1.6, 0, 0), ASSUR_OK);
  ASSERT_EQ(assur_simulator_step(r.every, nullptr), ASSUR_OK);
  EXPECT_EQ(assur_simulator_time(r.every), 1);
  const double now = assur_simulator_outputs(r.every)[x];
  EXPECT_GT(std::abs(now - before), 1e-3);
  std::size_t y = 0;
  ASSERT_EQ(assur_simulator_column(r.every, "P.y", &y), ASSUR_OK);
  EXPECT_NEAR(std::hypot(now, assur_simulator_outputs(r.every)[y]), 1.6, 1e-14);
}

TEST(C, StatusesNameTheirDriver) {
  const Robot r(true);
  assur_status status;
  ASSERT_EQ(assur_simulator_set(r.every, 2, std::nan(""), 0, 0), ASSUR_OK);
  EXPECT_EQ(assur_simulator_step(r.every, &status), ASSUR_NOT_FINITE);
  EXPECT_EQ(status.place, ASSUR_PLACE_TARGET);
  EXPECT_EQ(status.index, 2);
  EXPECT_STREQ(assur_simulator_place_name(r.every, status.place, status.index), "leg3");
  EXPECT_STREQ(assur_simulator_place_name(r.every, ASSUR_PLACE_DRIVER, 0), "leg1");
  EXPECT_STREQ(assur_simulator_place_name(r.every, ASSUR_PLACE_NONE, -1), "");
  EXPECT_EQ(assur_simulator_place_name(r.every, ASSUR_PLACE_LIMIT, 0), nullptr);
  EXPECT_EQ(assur_simulator_place_name(r.every, ASSUR_PLACE_TARGET, 3), nullptr);
}

// One simulator gets all commands, its twin those that succeed.
TEST(C, RandomCommandsLeaveTheBitsOfATwin) {
  Robot r(true);
  assur::test::Draw draw(51);
  const double home[3] = {1.5620499351813309, 1, 1.1};
  double at[3] = {home[0], home[1], home[2]};
  const int cycles = assur::test::random_count(2000);
  int failed = 0, arrived = 0;
  for (int k = 0; k < cycles; ++k) {
    const double jump = draw.below(4) == 0 ? 3 : 0.03;
    const bool returns = draw.below(10) == 0;  // far from home the commands would be like each other
    double target[3];
    bool set[3];
    for (std::size_t i = 0; i < 3; ++i) {
      set[i] = returns || draw.below(3) != 0;
      target[i] = draw.below(30) == 0 ? std::nan("") : (returns ? home[i] : at[i]) + draw.real(-jump, jump);
    }
    const double rate = draw.below(3) == 0 ? draw.real(-3, 3) : 0;
    const bool to_time = draw.below(5) == 0;
    const double until = assur_simulator_time(r.every) + draw.real(-0.01, 0.03);
    const auto give = [&](assur_simulator* s) {
      for (std::size_t i = 0; i < 3; ++i) {
        if (!set[i]) continue;
        EXPECT_EQ(assur_simulator_set(s, i, target[i], rate, 0), ASSUR_OK);
      }
      return to_time ? assur_simulator_step_to(s, until, nullptr) : assur_simulator_step(s, nullptr);
    };
    const std::int32_t code = give(r.every);
    if (assur_arrived(code) != 0) {
      ++arrived;
      ASSERT_EQ(give(r.successful), code) << k;
      for (std::size_t i = 0; i < 3; ++i) at[i] = set[i] ? target[i] : at[i];
    } else if (to_time) {  // it stays on the way: go on from where the twin is
      ASSERT_EQ(assur_simulator_save(r.successful, &r.state), ASSUR_OK);
      ASSERT_EQ(assur_simulator_restore(r.every, r.state), ASSUR_OK);
      ASSERT_EQ(assur_simulator_restore(r.successful, r.state), ASSUR_OK);
    } else {
      ++failed;
    }
    ASSERT_EQ(assur_simulator_time(r.every), assur_simulator_time(r.successful)) << k;
    ASSERT_EQ(r.row(r.every), r.row(r.successful)) << k << " " << assur_code_name(code);
  }
  EXPECT_GT(failed, cycles / 20);
  EXPECT_GT(arrived, cycles / 4);
}

}  // namespace
