// The C interface gives the results of the C++ one, and errors for wrong calls.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "assur/assur.h"
#include "assur/assur.hpp"
#include "backends/allocations.hpp"

namespace assur {
namespace {

struct Free {
  void operator()(assur_scene* h) const { assur_scene_free(h); }
  void operator()(assur_plan* h) const { assur_plan_free(h); }
  void operator()(assur_simulator* h) const { assur_simulator_free(h); }
  void operator()(assur_state* h) const { assur_state_free(h); }
  void operator()(assur_ensemble* h) const { assur_ensemble_free(h); }
};
template <class Handle>
using Owned = std::unique_ptr<Handle, Free>;

Owned<assur_scene> scene_of(const char* text) {
  assur_scene* scene = nullptr;
  EXPECT_EQ(assur_scene_open(text, &scene), ASSUR_OK) << assur_error();
  return Owned<assur_scene>(scene);
}

Owned<assur_plan> plan_of(const assur_scene* scene, std::vector<const char*> controlled = {},
                          const char* strategy = nullptr) {
  assur_options options = ASSUR_OPTIONS;
  options.strategy = strategy;
  options.controlled = controlled.data();
  options.controlled_count = controlled.size();
  options.threads = 1;
  assur_plan* plan = nullptr;
  EXPECT_EQ(assur_prepare(scene, &options, &plan), ASSUR_OK) << assur_error();
  return Owned<assur_plan>(plan);
}

Owned<assur_simulator> simulator_of(const assur_plan* plan) {
  assur_simulator* simulator = nullptr;
  EXPECT_EQ(assur_simulator_new(plan, nullptr, &simulator), ASSUR_OK) << assur_error();
  return Owned<assur_simulator>(simulator);
}

TEST(C, VersionsAndCodes) {
  EXPECT_EQ(assur_abi(), ASSUR_ABI);
  EXPECT_STREQ(assur_version(), ASSUR_VERSION);
  for (int code = ASSUR_OK; code <= ASSUR_NEAR_SINGULAR; ++code) {
    if (code == ASSUR_WITHIN_LIMITS + 1) continue;  // belongs to no code any more
    EXPECT_EQ(assur_code_name(code), name(static_cast<Code>(code)));
    EXPECT_EQ(assur_code_explanation(code), explanation(static_cast<Code>(code)));
    EXPECT_STRNE(assur_code_name(code), "unknown");
    EXPECT_EQ(assur_arrived(code) != 0, Status(static_cast<Code>(code), {}).arrived());
  }
  EXPECT_STREQ(assur_code_name(ASSUR_NEAR_SINGULAR + 1), "unknown");
  EXPECT_STREQ(assur_code_name(-1), "unknown");
  EXPECT_EQ(assur_code_name(ASSUR_LIMIT_REACHED), std::string("limit_reached"));
}

TEST(C, ControlledStepsAreThoseOfCpp) {
  const auto scene = scene_of("four_bar:2");
  EXPECT_STREQ(assur_scene_name(scene.get()), "four_bar");
  const auto plan = plan_of(scene.get(), {"motor"});
  const auto simulator = simulator_of(plan.get());
  Simulator same(prepare(sample("four_bar:2"), {.controlled = {"motor"}, .budget = ThreadBudget{1}}));

  ASSERT_EQ(assur_simulator_column_count(simulator.get()), same.columns().size());
  for (std::size_t i = 0; i < same.columns().size(); ++i) {
    EXPECT_EQ(assur_simulator_column_name(simulator.get(), i), same.columns()[i]);
  }
  EXPECT_EQ(assur_simulator_column_name(simulator.get(), same.columns().size()), nullptr);
  EXPECT_EQ(assur_simulator_driver_count(simulator.get()), 1U);
  EXPECT_STREQ(assur_simulator_driver_name(simulator.get(), 0), "motor");
  std::size_t motor = 9, column = 9;
  EXPECT_EQ(assur_simulator_driver(simulator.get(), "motor", &motor), ASSUR_OK);
  EXPECT_EQ(assur_simulator_column(simulator.get(), same.columns()[3].c_str(), &column), ASSUR_OK);
  EXPECT_EQ(motor, 0U);
  EXPECT_EQ(column, 3U);

  assur_state* state = nullptr;
  for (int k = 1; k <= 50; ++k) {
    EXPECT_EQ(assur_simulator_set(simulator.get(), motor, 0.03 * k, 1, 0.5), ASSUR_OK);
    same.set("motor", 0.03 * k, 1, 0.5);
    assur_status status;
    ASSERT_EQ(assur_simulator_step(simulator.get(), &status), static_cast<std::int32_t>(same.step().code));
    EXPECT_EQ(assur_simulator_time(simulator.get()), same.time());
    ASSERT_TRUE(std::equal(same.outputs().begin(), same.outputs().end(), assur_simulator_outputs(simulator.get())));
    if (k == 20) {
      EXPECT_EQ(assur_simulator_save(simulator.get(), &state), ASSUR_OK);
    }
  }
  const double slope = same.jacobian()(0, 0);
  std::vector<double> slopes(assur_simulator_jacobian_rows(simulator.get()));
  ASSERT_EQ(slopes.size(), same.jacobian().outputs.size());
  EXPECT_EQ(assur_simulator_jacobian_row_name(simulator.get(), 0), same.jacobian().outputs[0]);
  double smallest = 0;
  EXPECT_EQ(assur_simulator_jacobian(simulator.get(), slopes.data(), 1, &smallest, nullptr), ASSUR_OK);
  EXPECT_EQ(slopes[0], slope);
  EXPECT_EQ(smallest, same.jacobian().smallest_singular_value);

  assur_report report{};
  report.size = sizeof report;
  EXPECT_EQ(assur_simulator_report(simulator.get(), &report), ASSUR_OK);
  EXPECT_EQ(report.steps, 50);
  EXPECT_EQ(report.newton_iterations, same.report().counters.newton_iterations);
  EXPECT_EQ(report.residual[0], same.report().error.position);
  EXPECT_EQ(report.estimated_error[2], same.report().error.estimated_acceleration.value());

  EXPECT_EQ(assur_simulator_restore(simulator.get(), state), ASSUR_OK);
  EXPECT_NEAR(assur_simulator_time(simulator.get()), 20 * same.prepared().time().step, 1e-15);
  EXPECT_EQ(assur_simulator_save(simulator.get(), &state), ASSUR_OK);  // to the same one
  assur_state_free(state);
  EXPECT_EQ(assur_simulator_reset(simulator.get()), ASSUR_OK);
  EXPECT_EQ(assur_simulator_retreat(simulator.get()), ASSUR_OK);
  EXPECT_EQ(assur_simulator_time(simulator.get()), 0);
}

TEST(C, StepsAllocateNothing) {
  const auto simulator = simulator_of(plan_of(scene_of("stewart").get()).get());
  assur_status status;
  for (int k = 0; k < 3; ++k) ASSERT_EQ(assur_simulator_step(simulator.get(), &status), ASSUR_OK);
  const std::int64_t before = test::allocations();
  for (int k = 0; k < 50; ++k) ASSERT_EQ(assur_simulator_step(simulator.get(), &status), ASSUR_OK);
  EXPECT_EQ(test::allocations(), before);
}

TEST(C, RunsWithStridesAndSinks) {
  const auto scene = scene_of("slider_crank");
  ASSERT_EQ(assur_scene_set_time(scene.get(), 0, 1, 0.1), ASSUR_OK);
  const auto simulator = simulator_of(plan_of(scene.get()).get());
  Simulator same(prepare(sample("slider_crank").with_time({0, 1, 0.1}), {.budget = ThreadBudget{1}}));
  const Trajectory motion = same.run();
  const std::size_t columns = motion.columns().size(), stride = columns + 3;
  std::vector<double> values(12 * stride, -7);
  std::size_t rows = 0;
  assur_status status;
  EXPECT_EQ(assur_simulator_run(simulator.get(), nullptr, 12, values.data(), stride, &rows, &status), ASSUR_OK);
  ASSERT_EQ(rows, 11U);
  for (std::size_t k = 0; k < rows; ++k) {
    EXPECT_TRUE(std::ranges::equal(motion.row(k), std::span(values).subspan(k * stride, columns)));
    EXPECT_EQ(values[k * stride + columns], -7);  // between rows nothing is written
  }
  const double times[] = {0.2, 0.25};
  EXPECT_EQ(assur_simulator_run(simulator.get(), times, 2, values.data(), columns, &rows, nullptr), ASSUR_OK);
  EXPECT_EQ(rows, 2U);
  EXPECT_EQ(values[0], same.run(times)(0, 0));

  struct Seen {
    std::size_t rows = 0;
    double sum = 0;
  } seen;
  const auto take = [](void* context, const double* at, const double* of, std::size_t count) {
    auto* all = static_cast<Seen*>(context);
    all->rows += count;
    all->sum += at[count - 1] + of[0];
    return std::int32_t{0};
  };
  EXPECT_EQ(assur_simulator_stream(simulator.get(), nullptr, 0, 2, take, &seen, &rows, nullptr), ASSUR_OK);
  EXPECT_EQ(seen.rows, 6U);
  EXPECT_EQ(rows, 11U);
  EXPECT_DOUBLE_EQ(seen.sum, 1 + motion(0, 0));
}

TEST(C, EventsAndFailures) {
  const char* text = R"({"assur": 1, "name": "jams", "dimension": 2,
    "points": {"A": {"at": [0, 0], "fixed": true}, "D": {"at": [3, 0], "fixed": true},
               "B": {"at": [0, 1]}, "C": {"at": [2.5, 2]}},
    "constraints": {"coupler": {"distance": ["B", "C"], "value": 2.2}, "rocker": {"distance": ["D", "C"], "value": 1.5}},
    "drivers": {"motor": {"angle": ["A", "B"], "law": {"polynomial": [1.57, 1]}}},
    "time": {"start": 0, "end": 6, "step": 0.05}})";
  assur_scene* scene = nullptr;
  ASSERT_EQ(assur_scene_parse(text, std::strlen(text), &scene), ASSUR_OK) << assur_error();
  const Owned<assur_scene> owned(scene);
  const auto simulator = simulator_of(plan_of(scene).get());
  std::vector<double> values(121 * assur_simulator_column_count(simulator.get()));
  std::size_t rows = 0;
  assur_status status;
  EXPECT_EQ(assur_simulator_run(simulator.get(), nullptr, 121, values.data(),
                                assur_simulator_column_count(simulator.get()), &rows, &status),
            ASSUR_FOLD);
  EXPECT_EQ(status.code, ASSUR_FOLD);
  EXPECT_EQ(status.place, ASSUR_PLACE_GROUP);
  EXPECT_LT(rows, 121U);
  assur_report report{};
  report.size = sizeof report;
  ASSERT_EQ(assur_simulator_report(simulator.get(), &report), ASSUR_OK);
  ASSERT_GE(report.events, 1U);
  assur_event event{};
  event.size = sizeof event;
  EXPECT_EQ(assur_simulator_event(simulator.get(), report.events - 1, &event), ASSUR_OK);
  EXPECT_EQ(event.code, ASSUR_FOLD);
  EXPECT_STRNE(event.group, "");
  EXPECT_EQ(assur_simulator_event(simulator.get(), report.events, &event), ASSUR_ERROR_INPUT);
  EXPECT_EQ(assur_simulator_fallback(simulator.get(), report.fallbacks), nullptr);
}

TEST(C, EnsemblesOfATableAndOfPlans) {
  const auto scene = scene_of("four_bar:1");
  ASSERT_EQ(assur_scene_set_time(scene.get(), 0, 0.1, 0.01), ASSUR_OK);
  const char* names[] = {"coupler1", "rocker1"};
  const double table[] = {1.8, 1.3, -1, 1.9, 1.2, -1, 0.05, 1.3, -1};  // the third cannot be assembled; -1: gaps
  assur_ensemble* ensemble = nullptr;
  assur_options options = ASSUR_OPTIONS;
  options.threads = 1;
  options.mode = ASSUR_THROUGHPUT;
  ASSERT_EQ(assur_ensemble_new(scene.get(), names, 2, table, 3, 3, &options, nullptr, &ensemble), ASSUR_OK)
      << assur_error();
  const Owned<assur_ensemble> owned(ensemble);
  Ensemble same(sample("four_bar:1").with_time({0, 0.1, 0.01}), {"coupler1", "rocker1"},
                {1.8, 1.3, 1.9, 1.2, 0.05, 1.3}, {.budget = ThreadBudget{1}, .mode = Mode::throughput});
  const EnsembleTrajectory motion = same.run();
  EXPECT_EQ(assur_ensemble_members(ensemble), 3U);
  ASSERT_EQ(assur_ensemble_column_count(ensemble), same.columns().size());
  EXPECT_EQ(assur_ensemble_column_name(ensemble, 1), same.columns()[1]);
  std::size_t wanted[2] = {0, 2}, rows[3];
  ASSERT_EQ(assur_ensemble_column(ensemble, same.columns()[2].c_str(), &wanted[1]), ASSUR_OK);

  std::vector<double> values(3 * 11 * 2);
  assur_status status;
  EXPECT_EQ(assur_ensemble_run(ensemble, nullptr, 11, wanted, 2, values.data(), 22, 2, rows, &status),
            static_cast<std::int32_t>(same.report().status.code));
  EXPECT_EQ(status.place, ASSUR_PLACE_MEMBER);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(rows[i], motion.rows(i));
    for (std::size_t k = 0; k < 11; ++k) {
      for (std::size_t c = 0; c < 2; ++c) {
        const double x = values[i * 22 + k * 2 + c], y = motion(i, k, wanted[c]);
        EXPECT_TRUE(x == y || (std::isnan(x) && std::isnan(y))) << i << " " << k;
      }
    }
  }
  // The times first: [time][member][column].
  std::vector<double> by_times(values.size());
  EXPECT_GT(assur_ensemble_run(ensemble, nullptr, 11, wanted, 2, by_times.data(), 2, 6, nullptr, nullptr), 0);
  EXPECT_EQ(by_times[1 * 6 + 1 * 2 + 1], values[1 * 22 + 1 * 2 + 1]);

  assur_outcome outcome{};
  outcome.size = sizeof outcome;
  EXPECT_EQ(assur_ensemble_outcome(ensemble, 2, &outcome), ASSUR_OK);
  EXPECT_STRNE(outcome.cannot, "");
  EXPECT_EQ(assur_ensemble_outcome(ensemble, 0, &outcome), ASSUR_OK);
  EXPECT_STREQ(outcome.cannot, "");
  EXPECT_NEAR(outcome.reached, 0.1, 1e-12);

  std::vector<assur_summary> summaries(6);
  EXPECT_GT(assur_ensemble_summarize(ensemble, nullptr, 11, wanted, 2, summaries.data(), 2, nullptr), 0);
  const EnsembleSummary expected = same.summarize({same.columns()[0], same.columns()[2]});
  EXPECT_EQ(summaries[3].maximum, expected(1, 1).maximum);
  EXPECT_EQ(summaries[3].minimum_time, expected(1, 1).minimum_time);
  EXPECT_TRUE(std::isnan(summaries[4].mean));

  const double other[] = {1.85, 1.25};
  EXPECT_EQ(assur_ensemble_bind(ensemble, other, 1, 2), ASSUR_OK);
  EXPECT_EQ(assur_ensemble_members(ensemble), 1U);
  EXPECT_EQ(assur_ensemble_run(ensemble, nullptr, 11, wanted, 2, values.data(), 22, 2, rows, nullptr), ASSUR_OK);

  const auto plan = plan_of(scene.get());
  const assur_plan* plans[] = {plan.get(), plan.get()};
  assur_ensemble* of_plans = nullptr;
  ASSERT_EQ(assur_ensemble_of_plans(plans, 2, nullptr, &of_plans), ASSUR_OK);
  const Owned<assur_ensemble> second(of_plans);
  EXPECT_EQ(assur_ensemble_run(of_plans, nullptr, 11, wanted, 2, values.data(), 22, 2, rows, nullptr), ASSUR_OK);
  EXPECT_EQ(values[2], values[24]);
  EXPECT_EQ(assur_ensemble_bind(of_plans, other, 1, 2), ASSUR_ERROR_INPUT);
}

TEST(C, PlansAsFilesAndText) {
  const auto plan = plan_of(scene_of("stewart").get(), {}, "irreducible/lanes:8");
  EXPECT_STREQ(assur_plan_name(plan.get()), "stewart");
  double end = 0, step = 0;
  EXPECT_EQ(assur_plan_time(plan.get(), nullptr, &end, &step), ASSUR_OK);
  EXPECT_EQ(end, 10);
  const std::string file = testing::TempDir() + "assur_c_test.plan";
  ASSERT_EQ(assur_plan_save(plan.get(), file.c_str()), ASSUR_OK) << assur_error();
  assur_plan* loaded = nullptr;
  ASSERT_EQ(assur_plan_load(file.c_str(), 1, &loaded), ASSUR_OK) << assur_error();
  const Owned<assur_plan> first(loaded);
  std::stringstream text;
  text << std::ifstream(file).rdbuf();
  std::filesystem::remove(file);
  assur_plan* read = nullptr;
  ASSERT_EQ(assur_plan_read(text.str().data(), text.str().size(), 1, &read), ASSUR_OK) << assur_error();
  const Owned<assur_plan> second(read);
  for (const assur_plan* p : {loaded, read}) {
    const auto simulator = simulator_of(p), original = simulator_of(plan.get());
    ASSERT_EQ(assur_simulator_step_to(simulator.get(), 0.1, nullptr), ASSUR_OK);
    ASSERT_EQ(assur_simulator_step_to(original.get(), 0.1, nullptr), ASSUR_OK);
    EXPECT_EQ(assur_simulator_outputs(simulator.get())[0], assur_simulator_outputs(original.get())[0]);
  }
  EXPECT_EQ(assur_plan_read("no plan", 7, 1, &read), ASSUR_ERROR_INPUT);
  EXPECT_EQ(assur_plan_load("/no/such/file", 1, &read), ASSUR_ERROR_ENVIRONMENT);
  EXPECT_EQ(assur_plan_save(plan.get(), "/no/such/folder/x"), ASSUR_ERROR_ENVIRONMENT);
}

TEST(C, ErrorsNameWhatIsWrong) {
  assur_scene* scene = nullptr;
  EXPECT_EQ(assur_scene_open("no_such_sample", &scene), ASSUR_ERROR_INPUT);
  EXPECT_EQ(scene, nullptr);
  EXPECT_NE(std::string(assur_error()).find("no_such_sample"), std::string::npos);
  const char* text = R"({"assur": 1, "name": "x", "dimension": 2, "points": {"A": {"at": [0, "nan"]}}})";
  EXPECT_EQ(assur_scene_parse(text, std::strlen(text), &scene), ASSUR_ERROR_INPUT);
  ASSERT_GE(assur_error_count(), 1U);
  EXPECT_NE(std::string(assur_error_where(0)).find("/points/A"), std::string::npos) << assur_error_where(0);
  EXPECT_STRNE(assur_error_what(0), "");
  EXPECT_STREQ(assur_error_what(assur_error_count()), "");
  std::thread([] { EXPECT_STREQ(assur_error(), ""); }).join();  // errors belong to their thread

  EXPECT_EQ(assur_scene_open(nullptr, &scene), ASSUR_ERROR_INPUT);
  EXPECT_STREQ(assur_error(), "file_or_sample is NULL");
  EXPECT_EQ(assur_scene_open("stewart", nullptr), ASSUR_ERROR_INPUT);
  const auto good = scene_of("four_bar:1");
  assur_plan* plan = nullptr;
  assur_options options = ASSUR_OPTIONS;
  options.size = 3;
  EXPECT_EQ(assur_prepare(good.get(), &options, &plan), ASSUR_ERROR_INPUT);
  options.size = sizeof options + 8;
  EXPECT_EQ(assur_prepare(good.get(), &options, &plan), ASSUR_ERROR_INPUT);
  EXPECT_NE(std::string(assur_error()).find("sizeof"), std::string::npos);
  options = ASSUR_OPTIONS;
  options.mode = 2;
  EXPECT_EQ(assur_prepare(good.get(), &options, &plan), ASSUR_ERROR_INPUT);
  options = ASSUR_OPTIONS;
  options.threads = -1;
  EXPECT_EQ(assur_prepare(good.get(), &options, &plan), ASSUR_ERROR_INPUT);
  options = ASSUR_OPTIONS;
  options.strategy = "groups/nothing";
  EXPECT_EQ(assur_prepare(good.get(), &options, &plan), ASSUR_ERROR_INPUT);
  EXPECT_EQ(plan, nullptr);
  const char* names[] = {"coupler1", nullptr};
  const double values[] = {1.8, 2};
  EXPECT_EQ(assur_scene_set(good.get(), names, values, 2), ASSUR_ERROR_INPUT);
  EXPECT_STREQ(assur_error(), "names[1] is NULL");

  const auto simulator = simulator_of(plan_of(good.get(), {"motor"}).get());
  std::size_t index = 5;
  EXPECT_EQ(assur_simulator_driver(simulator.get(), "nothing", &index), ASSUR_ERROR_INPUT);
  EXPECT_EQ(assur_simulator_column(simulator.get(), "nothing", &index), ASSUR_ERROR_INPUT);
  EXPECT_EQ(index, 5U);
  EXPECT_EQ(assur_simulator_set(simulator.get(), 1, 0, 0, 0), ASSUR_ERROR_INPUT);
  std::vector<double> row(1000);
  EXPECT_EQ(assur_simulator_run(simulator.get(), nullptr, 1, row.data(), 1000, nullptr, nullptr), ASSUR_ERROR_INPUT);
  EXPECT_NE(std::string(assur_error()).find("room for 1"), std::string::npos);
  EXPECT_EQ(assur_simulator_run(simulator.get(), nullptr, 1, row.data(), 1, nullptr, nullptr), ASSUR_ERROR_INPUT);
  // A number that is not finite is an outcome.
  EXPECT_EQ(assur_simulator_step_to(simulator.get(), NAN, nullptr), ASSUR_NOT_FINITE);
  assur_step_settings settings = ASSUR_STEP_SETTINGS;
  settings.most_iterations = 0;
  assur_simulator* other = nullptr;
  EXPECT_EQ(assur_simulator_new(plan_of(good.get()).get(), &settings, &other), ASSUR_ERROR_INPUT);
}

// Sizes that no memory has, such as -1 from a language with signed numbers.
TEST(C, SizesWithoutSense) {
  const auto scene = scene_of("four_bar:1");
  const auto simulator = simulator_of(plan_of(scene.get(), {"motor"}).get());
  std::vector<double> values(4000, -7);
  const std::size_t huge[] = {SIZE_MAX, SIZE_MAX - 1, SIZE_MAX - 11, SIZE_MAX / 2, SIZE_MAX / 8, SIZE_MAX / 16};
  const char* names[] = {"coupler1", "rocker1"};
  const std::size_t column = 0;
  assur_ensemble* ensemble = nullptr;
  const double good[] = {1.8, 1.3};
  ASSERT_EQ(assur_ensemble_new(scene.get(), names, 2, good, 1, 2, nullptr, nullptr, &ensemble), ASSUR_OK);
  const Owned<assur_ensemble> owned(ensemble);
  double* const middle = values.data() + 2000;
  for (const std::size_t n : huge) {
    EXPECT_EQ(assur_simulator_jacobian(simulator.get(), middle, n, nullptr, nullptr), ASSUR_ERROR_INPUT) << n;
    EXPECT_EQ(assur_simulator_run(simulator.get(), middle, 2, middle, n, nullptr, nullptr), ASSUR_ERROR_INPUT) << n;
    EXPECT_EQ(assur_simulator_run(simulator.get(), middle, n, middle, 50, nullptr, nullptr), ASSUR_ERROR_INPUT) << n;
    EXPECT_EQ(assur_ensemble_bind(ensemble, middle, n, 3), ASSUR_ERROR_INPUT) << n;
    EXPECT_EQ(assur_ensemble_bind(ensemble, middle, 2, n), ASSUR_ERROR_INPUT) << n;
    EXPECT_EQ(assur_ensemble_run(ensemble, nullptr, 2000, &column, n, middle, 50, 1, nullptr, nullptr),
              ASSUR_ERROR_INPUT);
    EXPECT_EQ(assur_ensemble_run(ensemble, nullptr, 2000, &column, 1, middle, 50, n, nullptr, nullptr),
              ASSUR_ERROR_INPUT);
  }
  EXPECT_EQ(std::count(values.begin(), values.end(), -7.0), 4000);
}

// A program that was compiled with an older, shorter struct gets what it knows.
TEST(C, ShorterStructs) {
  const auto scene = scene_of("four_bar:1");
  assur_options options = ASSUR_OPTIONS;
  options.size = offsetof(assur_options, accuracy);
  options.accuracy = -1;  // beyond the size: not read
  assur_plan* plan = nullptr;
  ASSERT_EQ(assur_prepare(scene.get(), &options, &plan), ASSUR_OK) << assur_error();
  const Owned<assur_plan> owned(plan);
  const auto simulator = simulator_of(plan);
  assur_report report{};
  report.size = offsetof(assur_report, steps);
  report.steps = -5;
  EXPECT_EQ(assur_simulator_report(simulator.get(), &report), ASSUR_OK);
  EXPECT_EQ(report.steps, -5);
  EXPECT_EQ(report.size, offsetof(assur_report, steps));
}

}  // namespace
}  // namespace assur
