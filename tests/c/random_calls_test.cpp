// Random sequences of calls of the C interface, also with NULL and with numbers without sense, never crash. Handles are
// valid or NULL, and arrays have the sizes that their arguments say.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "assur/assur.h"
#include "properties/random_count.hpp"
#include "properties/small_random_scenes.hpp"

namespace assur {
namespace {

class Caller {
 public:
  explicit Caller(std::uint64_t seed) : draw_(seed) {}
  Caller(const Caller&) = delete;
  Caller& operator=(const Caller&) = delete;
  ~Caller() {
    for (auto* h : scenes_) assur_scene_free(h);
    for (auto* h : plans_) assur_plan_free(h);
    for (auto* h : simulators_) assur_simulator_free(h);
    for (auto* h : states_) assur_state_free(h);
    for (auto* h : ensembles_) assur_ensemble_free(h);
  }

  // One random call. Returns its result.
  std::int32_t call() {
    switch (draw_.below(36)) {
      case 0:
        return keep(scenes_, [&](auto** out) { return assur_scene_open(text(), out); });
      case 1: {
        const std::string json = scene_text();
        return keep(scenes_, [&](auto** out) { return assur_scene_parse(json.data(), json.size(), out); });
      }
      case 2:
        return drop(scenes_, assur_scene_free);
      case 3:
        (void)assur_scene_name(any(scenes_));
        (void)assur_scene_parameter_name(any(scenes_), index());
        return 0;
      case 4: {
        const std::array<const char*, 2> names = {text(), text()};
        const std::array<double, 2> values = {number(), number()};
        return assur_scene_set(any(scenes_), names.data(), draw_.maybe() ? values.data() : nullptr, draw_.below(3));
      }
      case 5: {
        const std::array<const char*, 2> names = {text(), text()};
        return assur_scene_set_outputs(any(scenes_), names.data(), draw_.below(3));
      }
      case 6:
        return assur_scene_set_time(any(scenes_), draw_.maybe() ? 0 : number(), number(), number());
      case 7:
      case 8:
        return keep(plans_, [&](auto** out) {
          const Options options(*this);
          return assur_prepare(any(scenes_), draw_.maybe() ? nullptr : &options.value, out);
        });
      case 9:
        return drop(plans_, assur_plan_free);
      case 10:
        return keep(plans_, [&](auto** out) { return assur_plan_read(text(), draw_.below(1), small(), out); });
      case 11: {
        double a = 0, b = 0;
        (void)assur_plan_name(any(plans_));
        return assur_plan_time(any(plans_), &a, draw_.maybe() ? &b : nullptr, nullptr);
      }
      case 12:
      case 13:
        return keep(simulators_, [&](auto** out) {
          const assur_step_settings settings = random_limits();
          return assur_simulator_new(any(plans_), draw_.maybe() ? nullptr : &settings, out);
        });
      case 14:
        return drop(simulators_, assur_simulator_free);
      case 15:
      case 16:
      case 17:
        return assur_simulator_step(any(simulators_), status());
      case 18:
      case 19:
        return assur_simulator_step_to(any(simulators_), draw_.maybe() ? draw_.real(0, 0.2) : number(), status());
      case 20:
      case 21:
        return assur_simulator_set(any(simulators_), index(), draw_.maybe() ? draw_.real(-2, 2) : number(), number(),
                                   0);
      case 22: {
        std::size_t out = 0;
        return draw_.maybe() ? assur_simulator_column(any(simulators_), text(), draw_.maybe() ? &out : nullptr)
                             : assur_simulator_driver(any(simulators_), text(), &out);
      }
      case 23: {
        auto* const s = any(simulators_);
        (void)assur_simulator_column_name(s, index());
        (void)assur_simulator_driver_name(s, index());
        (void)assur_simulator_time(s);
        const double* const row = assur_simulator_outputs(s);
        double sum = 0;
        for (std::size_t i = 0; i < assur_simulator_column_count(s); ++i) sum += row[i];
        return std::isnan(sum) ? 0 : 0;
      }
      case 24:
      case 25:
        return run();
      case 26: {
        const auto sink = [](void* context, const double*, const double*, std::size_t) {
          return --*static_cast<std::int32_t*>(context) < 0 ? 1 : 0;
        };
        std::int32_t left = 2;
        const std::vector<double> at = times();
        return assur_simulator_stream(any(simulators_), at.data(), at.size(), index(),
                                      draw_.below(5) == 0 ? nullptr : static_cast<assur_sink>(sink), &left, nullptr,
                                      status());
      }
      case 27:
        return draw_.maybe() ? assur_simulator_reset(any(simulators_)) : assur_simulator_retreat(any(simulators_));
      case 28: {
        if (states_.empty() || draw_.maybe()) {
          return keep(states_, [&](auto** out) { return assur_simulator_save(any(simulators_), out); });
        }
        return assur_simulator_save(any(simulators_), &states_[draw_.below(states_.size())]);
      }
      case 29:
        return assur_simulator_restore(any(simulators_), any(states_));
      case 30: {
        auto* const s = any(simulators_);
        const std::size_t rows = assur_simulator_jacobian_rows(s), drivers = assur_simulator_driver_count(s);
        std::vector<double> values(rows * (drivers + 1) + 1);
        (void)assur_simulator_jacobian_row_name(s, index());
        return assur_simulator_jacobian(s, draw_.below(5) == 0 ? nullptr : values.data(), drivers + draw_.below(2),
                                        nullptr, status());
      }
      case 31: {
        assur_report report{};
        report.size = draw_.maybe() ? sizeof report : draw_.below(200);
        assur_event event{};
        event.size = draw_.maybe() ? sizeof event : draw_.below(sizeof event + 9);
        auto* const s = any(simulators_);
        (void)assur_simulator_event(s, index(), &event);
        (void)assur_simulator_fallback(s, index());
        return report.size > sizeof report ? 0 : assur_simulator_report(s, draw_.below(9) == 0 ? nullptr : &report);
      }
      case 32: {
        if (draw_.below(4) == 0) {
          const std::array<const assur_plan*, 2> plans = {any(plans_), any(plans_)};
          return keep(ensembles_,
                      [&](auto** out) { return assur_ensemble_of_plans(plans.data(), draw_.below(3), nullptr, out); });
        }
        const std::array<const char*, 2> names = {draw_.maybe() ? "coupler1" : text(), "rocker1"};
        std::array<double, 9> values{};
        for (double& v : values) v = draw_.below(4) == 0 ? number() : draw_.real(1.2, 1.9);
        return keep(ensembles_, [&](auto** out) {
          const Options options(*this);
          return assur_ensemble_new(any(scenes_), names.data(), draw_.below(3), values.data(), draw_.below(4),
                                    draw_.below(4), draw_.maybe() ? nullptr : &options.value, nullptr, out);
        });
      }
      case 33:
        return run_ensemble();
      case 34: {
        const std::array<double, 6> values = {1.8, 1.3, 1.9, number(), 1.7, 1.2};
        auto* const e = any(ensembles_);
        // The table of an ensemble has two columns at most.
        return assur_ensemble_bind(e, draw_.below(6) == 0 ? nullptr : values.data(), draw_.below(4), draw_.below(3));
      }
      default: {
        assur_outcome outcome{};
        outcome.size = sizeof outcome;
        auto* const e = any(ensembles_);
        (void)assur_ensemble_column_name(e, index());
        (void)assur_error_what(index());
        if (draw_.below(4) == 0) return drop(ensembles_, assur_ensemble_free);
        return assur_ensemble_outcome(e, index(), draw_.below(5) == 0 ? nullptr : &outcome);
      }
    }
  }

  // Handles that exist: the sequence reached all kinds.
  [[nodiscard]] std::size_t handles() const { return simulators_.size() + ensembles_.size() + states_.size(); }

 private:
  struct Options {
    explicit Options(Caller& c) {
      value.strategy = c.draw_.of(std::vector<const char*>{nullptr, "auto", "groups/eigen", "global/eigen", "x/y", ""});
      names = {c.text(), "motor"};
      value.controlled = c.draw_.maybe() ? names.data() + 1 : names.data();
      value.controlled_count = c.draw_.below(value.controlled == names.data() ? 3 : 2);
      value.threads = c.small();
      value.mode = static_cast<std::int32_t>(c.draw_.below(3));
      value.accuracy = c.draw_.maybe() ? 0 : c.number();
      if (c.draw_.below(9) == 0) value.size = c.draw_.below(sizeof value + 9);
    }
    std::array<const char*, 2> names;
    assur_options value = ASSUR_OPTIONS;
  };

  template <class Handle>
  Handle* any(const std::vector<Handle*>& from) {
    return from.empty() || draw_.below(12) == 0 ? nullptr : from[draw_.below(from.size())];
  }
  template <class Handle, class Make>
  std::int32_t keep(std::vector<Handle*>& in, const Make& make) {
    Handle* made = nullptr;
    const std::int32_t result = make(draw_.below(20) == 0 ? nullptr : &made);
    EXPECT_TRUE(made == nullptr || result == ASSUR_OK);
    if (made == nullptr) return result;
    if (in.size() < 6) {
      in.push_back(made);
    } else {
      std::swap(in[draw_.below(in.size())], made);
      free_one(made);
    }
    return result;
  }
  static void free_one(assur_scene* h) { assur_scene_free(h); }
  static void free_one(assur_plan* h) { assur_plan_free(h); }
  static void free_one(assur_simulator* h) { assur_simulator_free(h); }
  static void free_one(assur_state* h) { assur_state_free(h); }
  static void free_one(assur_ensemble* h) { assur_ensemble_free(h); }
  template <class Handle, class FreeIt>
  std::int32_t drop(std::vector<Handle*>& from, const FreeIt& free_it) {
    if (from.size() < 2) return 0;
    const std::size_t i = draw_.below(from.size());
    free_it(from[i]);
    from.erase(from.begin() + static_cast<std::ptrdiff_t>(i));
    return 0;
  }

  const char* text() {
    return draw_.of(std::vector<const char*>{"four_bar", "four_bar:1", "slider_crank", "stewart", "motor", "coupler1",
                                             "omega", "B1", "B1.x", "rocker_angle", "all", "", "../x", "\xff\xfe",
                                             nullptr});
  }
  std::string scene_text() {
    std::string json = R"({"assur": 1, "name": "four_bar", "dimension": 2, "parameters": {"omega": 6},
      "points": {"A": {"at": [0, 0], "fixed": true}, "D": {"at": [2, 0], "fixed": true}, "B": {"at": [0.8, 0]},
                 "B1": {"at": [2, 1.3]}},
      "constraints": {"coupler1": {"distance": ["B", "B1"], "value": 1.8},
                      "rocker1": {"distance": ["D", "B1"], "value": 1.3}},
      "drivers": {"motor": {"angle": ["A", "B"], "law": {"polynomial": [0, "=omega"]}}},
      "time": {"start": 0, "end": 1, "step": 0.05}})";
    if (draw_.below(3) == 0) json[draw_.below(json.size())] = static_cast<char>(draw_.below(256));
    return json;
  }
  double number() {
    return draw_.of(std::vector<double>{0, 1, -1, 0.05, 2, 1e-300, 1e300, -0.0, std::numeric_limits<double>::infinity(),
                                        std::numeric_limits<double>::quiet_NaN(), 1.8, 1.3});
  }
  std::size_t index() { return draw_.below(8) == 0 ? std::numeric_limits<std::size_t>::max() : draw_.below(5); }
  std::int32_t small() { return draw_.of(std::vector<std::int32_t>{0, 1, 1, 1, 2, -1}); }
  assur_status* status() { return draw_.maybe() ? &status_ : nullptr; }
  assur_step_settings random_limits() {
    assur_step_settings settings = ASSUR_STEP_SETTINGS;
    settings.iterations = draw_.below(4) == 0 ? small() : 0;
    settings.most_iterations = draw_.maybe() ? 12 : small();
    settings.seconds = draw_.maybe() ? 0 : number();
    if (draw_.below(9) == 0) settings.size = draw_.below(sizeof settings + 9);
    return settings;
  }
  std::vector<double> times() {
    std::vector<double> out;
    for (std::size_t i = draw_.below(6); i > 0; --i) {
      out.push_back(draw_.below(9) == 0 ? number() : (out.empty() ? 0 : out.back()) + draw_.real(0, 0.1));
    }
    return out;
  }
  std::int32_t run() {
    auto* const s = any(simulators_);
    const std::size_t columns = assur_simulator_column_count(s), stride = columns + draw_.below(2);
    const std::vector<double> at = times();
    const bool grid = draw_.maybe();
    const std::size_t room = grid ? 30 : at.size();  // the grids of other scenes have more rows: refused
    std::vector<double> values(room * stride + 1);
    std::size_t rows = 0;
    const std::int32_t result = assur_simulator_run(
        s, grid ? nullptr : at.data(), room, draw_.below(9) == 0 ? nullptr : values.data(), stride, &rows, status());
    EXPECT_LE(rows, room);
    return result;
  }
  std::int32_t run_ensemble() {
    auto* const e = any(ensembles_);
    const std::size_t all = assur_ensemble_column_count(e), members = assur_ensemble_members(e), room = 30;
    const std::array<std::size_t, 2> columns = {draw_.below(3), index()};
    const bool chosen = draw_.maybe();
    const std::size_t count = chosen ? draw_.below(3) : all, width = std::max<std::size_t>(count, 1);
    std::vector<double> values((members + 1) * room * width);
    std::vector<assur_summary> summaries((members + 1) * width);
    std::vector<std::size_t> rows(members + 1);
    const std::size_t* const wanted = chosen ? columns.data() : nullptr;
    if (draw_.below(3) == 0) {
      return assur_ensemble_summarize(e, nullptr, room, wanted, count, summaries.data(), width, status());
    }
    if (draw_.maybe()) {
      return assur_ensemble_run(e, nullptr, room, wanted, count, values.data(), width, members * width, rows.data(),
                                status());
    }
    return assur_ensemble_run(e, nullptr, room, wanted, count, values.data(), room * width, width,
                              draw_.maybe() ? rows.data() : nullptr, status());
  }

  test::Draw draw_;
  std::vector<assur_scene*> scenes_;
  std::vector<assur_plan*> plans_;
  std::vector<assur_simulator*> simulators_;
  std::vector<assur_state*> states_;
  std::vector<assur_ensemble*> ensembles_;
  assur_status status_{};
};

TEST(RandomCalls, NeverCrash) {
  std::size_t good = 0, refused = 0, outcomes = 0, handles = 0;
  const int sequences = test::random_count(60);
  for (int seed = 0; seed < sequences; ++seed) {
    Caller caller(static_cast<std::uint64_t>(seed));
    for (int k = 0; k < 120; ++k) {
      const std::int32_t result = caller.call();
      ASSERT_GE(result, ASSUR_ERROR_ENVIRONMENT) << assur_error() << " in sequence " << seed;
      ASSERT_LE(result, ASSUR_NEAR_SINGULAR);
      (result == 0 ? good : result < 0 ? refused : outcomes)++;
    }
    handles += caller.handles();
  }
  // All of them are reached: success, numerical failures, and errors.
  EXPECT_GT(good, 10U * static_cast<std::size_t>(sequences));
  EXPECT_GT(refused, 10U * static_cast<std::size_t>(sequences));
  EXPECT_GT(outcomes, 0U);
  EXPECT_GT(handles, static_cast<std::size_t>(sequences));
}

}  // namespace
}  // namespace assur
