// Baselines: the library against a hand-written loop with the same calls of KLU and LAPACK, and the same number of
// factorisations and solutions. A ratio is the time of the library over the time of the loop; blocks of both are
// measured in turns. The median of the ratios is reported, and should be at most 1.15.
//   solver: one factorisation and three solutions of each of six groups, our backend against bare calls
//   legs:   position, velocity and acceleration of the six legs of `stewart`, groups/BACKEND+predict=hermite:5 against
//           the leg written by hand, all with the same terminal: `hand` makes the library's checks, `unchecked` makes
//           none, `calls` are only the calls of KLU or LAPACK
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "assur/assur.hpp"
#include "bare_calls.hpp"
#include "drivers/inputs.hpp"
#include "legs_by_hand.hpp"
#include "matrices.hpp"
#include "median.hpp"
#include "motion/layout.hpp"
#include "motion/state.hpp"
#include "plan/preparation.hpp"
#include "program.hpp"

namespace assur::bench {
namespace {

using Clock = std::chrono::steady_clock;

double seconds(Clock::time_point from) { return std::chrono::duration<double>(Clock::now() - from).count(); }

double median_ratio(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> ratio;
  for (std::size_t i = 0; i < a.size(); ++i) ratio.push_back(a[i] / b[i]);
  return median(ratio);
}

// Times of both sides of a comparison, block by block.
struct Times {
  std::vector<double> library, hand;

  void report(benchmark::State& state, double per_block) const {
    state.counters["library"] = median(library) / per_block;
    state.counters["hand"] = median(hand) / per_block;
    state.counters["ratio"] = median_ratio(library, hand);
  }
};

// ---- the solver alone

constexpr int kGroups = 6;
constexpr int kSolves = 3;
constexpr double kBlock = 2e-4;  // s: much longer than a reading of the clock, shorter than most disturbances

template <class Bare>
void compare_solvers(benchmark::State& state, const std::string& kind, int n) {
  const std::vector<test::Matrix> matrices = make_matrices(kind, n, kGroups);
  const Pattern& pattern = matrices[0].pattern;
  const Backend& backend = find_backend(backends(), Bare::kBackend);
  std::vector<std::unique_ptr<Bare>> bare;
  std::vector<std::unique_ptr<LinearSolver>> ours;
  for (int g = 0; g < kGroups; ++g) {
    bare.push_back(std::make_unique<Bare>(pattern));
    ours.push_back(backend.make(ThreadBudget{}, Precision::binary64));
    if (!ours.back()->analyze(pattern, 1).ok()) return state.SkipWithError("an analysis failed");
  }
  test::Random random(1);
  std::vector<double> right, x(static_cast<std::size_t>(pattern.n));
  for (std::size_t i = 0; i < x.size(); ++i) right.push_back(test::nonzero(random));

  bool ok = true;
  const auto sweep = [&](auto& solvers, const auto& factorize, const auto& solve) {
    for (std::size_t g = 0; g < kGroups; ++g) {
      ok = factorize(*solvers[g], matrices[g].values) && ok;
      for (int i = 0; i < kSolves; ++i) {
        std::copy(right.begin(), right.end(), x.begin());
        ok = solve(*solvers[g]) && ok;
      }
      benchmark::DoNotOptimize(x.data());
    }
  };
  const auto by_hand = [&] {
    sweep(
        bare, [](Bare& s, const std::vector<double>& values) { return s.factorize(values.data()); },
        [&](Bare& s) { return s.solve(x.data()); });
  };
  const auto by_library = [&] {
    sweep(
        ours, [](LinearSolver& s, const std::vector<double>& values) { return s.factorize(values).ok(); },
        [&](LinearSolver& s) { return s.solve(x, 1).ok(); });
  };
  const auto block = [](const auto& work, int repeats) {
    const auto start = Clock::now();
    for (int i = 0; i < repeats; ++i) work();
    return seconds(start);
  };
  by_hand();
  by_library();
  const int repeats = std::max(1, static_cast<int>(kBlock / block(by_hand, 10) * 10));
  Times times;
  for ([[maybe_unused]] auto _ : state) {
    times.hand.push_back(block(by_hand, repeats));
    times.library.push_back(block(by_library, repeats));
    state.SetIterationTime(times.library.back());
  }
  if (!ok) return state.SkipWithError("a factorisation or solution failed");
  times.report(state, repeats * kGroups);
}

// ---- the six legs

constexpr int kLegs = 6;
constexpr int kWarm = 10;        // steps
constexpr double kSame = 1e-10;  // m: largest difference of equal motions
constexpr double kConverged = 8 * std::numeric_limits<double>::epsilon();

// Uses internal parts of the library, so that the legs are timed without the terminal.
class LegsByLibrary {
 public:
  LegsByLibrary(const Scene& scene, const std::string& backend, double t)
      : prepared_(prepare(scene, {"groups/" + backend + "+predict=hermite:5", {}})),
        structure_(*preparation(prepared_).structure),
        inputs_(*structure_.system, {}),
        layout_(lay_out(preparation(prepared_))) {
    state_.resize(layout_.first_unknown, layout_.size, prepared_.plan().run.predictor);
    for (std::size_t c = 0; c < layout_.address.size(); ++c) {
      if (layout_.address[c] >= 0) state_.at(0)[layout_.address[c]] = structure_.start[c];
    }
    for (const Pack& pack : layout_.packs) repeat_in_idle_lanes(pack);
    for (const auto& solver : layout_.solvers) solver->restart();
    ok_ = drive(t) && solve(0, Attempt::Branch::start) && solve(1, Attempt::Branch::start);
    state_.accept(t);
  }

  // The terminal at time t.
  bool prepare_step(double t) {
    ok_ = ok_ && drive(t) && (solve(0, Attempt::Branch::inside) || solve(0, Attempt::Branch::start));
    return ok_;
  }
  // Solves the legs at time t, and predicts the next step.
  bool step(double t, double next) {
    counters_ = {};
    held_ = solve(1, Attempt::Branch::inside);
    // Outside the ball of the branch check, the simulator would halve the step; this benchmark measures a new ball
    // instead.
    ok_ = ok_ && (held_ || solve(1, Attempt::Branch::start));
    state_.accept(t);
    state_.predict(next);
    return ok_;
  }
  void predict(double t) { state_.predict(t); }
  // Replaces the prediction by the last posture.
  void restore() { state_.restore(); }

  [[nodiscard]] bool ok() const { return ok_; }
  [[nodiscard]] bool held() const { return held_; }  // the last step of the legs succeeded at the first attempt
  [[nodiscard]] const Counters& counters() const { return counters_; }  // for that step

  // d-th derivative of a point or vector, SI units.
  [[nodiscard]] Vec value(const std::string& name, int d) const {
    const System& s = *structure_.system;
    const Item& item = s.item(name);
    Vec out{};
    for (std::size_t i = 0; i < 3; ++i) {
      for (const Term& t : s.form(item.form[i])) {
        const std::int32_t address = layout_.address[static_cast<std::size_t>(t.coordinate)];
        out[i] += s.constants[static_cast<std::size_t>(t.constant)] * state_.at(d)[address] * s.unit(item.dimension);
      }
    }
    return out;
  }
  [[nodiscard]] Terminal terminal(int d) const { return {value("O", d), value("u", d), value("v", d)}; }

 private:
  GroupSolver& solver(const Pack& pack) { return *layout_.solvers[static_cast<std::size_t>(pack.group_class)]; }
  void repeat_in_idle_lanes(const Pack& pack) {
    const int lanes = solver(pack).lanes();
    double* x = state_.at(0) + pack.unknowns;
    for (std::int32_t i = 0; i < solver(pack).group_class().n; ++i, x += lanes)
      std::fill(x + pack.used, x + lanes, x[0]);
  }
  bool drive(double t) {
    double* const q[3] = {state_.at(0), state_.at(1), state_.at(2)};
    return inputs_.drive(t, q).ok();
  }
  // level 0: the terminal, 1: the legs
  bool solve(int level, Attempt::Branch branch) {
    double* const q[3] = {state_.at(0), state_.at(1), state_.at(2)};
    Attempt attempt;
    attempt.branch = branch;
    for (Pack& pack : layout_.packs) {
      if (pack.level == level && !solver(pack).solve(pack, q, attempt, counters_, errors_).ok()) return false;
    }
    return true;
  }

  Prepared prepared_;
  const GroupedSystem& structure_;
  Inputs inputs_;
  Layout layout_;
  State state_;
  Counters counters_;
  StepErrors errors_;
  bool ok_ = false, held_ = true;
};

template <class Bare>
void compare_legs(benchmark::State& state) {
  const Scene scene = sample("stewart");
  const double dt = scene.time().step;
  LegsByLibrary library(scene, std::string(Bare::kBackend), 0);
  if (!library.ok()) return state.SkipWithError("the start failed");
  LegsByHand<Bare, Checks::as_the_library> hand(scene, library);
  LegsByHand<Bare, Checks::none> unchecked(scene, library);
  LegsByLibrary lanes(scene, "lanes:8", 0);
  library.predict(dt);
  lanes.predict(dt);
  Times times;
  std::vector<double> without_checks, calls, in_lanes;
  std::int64_t k = 0, iterations = 0, iterations_by_hand = 0, factorizations = 0, balls = 0, balls_by_hand = 0;
  double difference = 0;
  const auto step = [&] {
    const double t = scene.time().time(++k), next = scene.time().time(k + 1);
    if (!library.prepare_step(t) || !lanes.prepare_step(t)) return false;
    const Terminal terminal[] = {library.terminal(0), library.terminal(1), library.terminal(2)};
    bool ok = true;
    const auto time = [&ok](std::vector<double>& to, const auto& work) {
      const auto start = Clock::now();
      ok = work() && ok;
      to.push_back(seconds(start));
    };
    time(times.hand, [&] { return hand.step(terminal[0], terminal[1], terminal[2], dt); });
    time(times.library, [&] { return library.step(t, next); });
    time(without_checks, [&] { return unchecked.step(terminal[0], terminal[1], terminal[2], dt); });
    time(calls, [&] { return unchecked.calls(); });
    time(in_lanes, [&] { return lanes.step(t, next); });
    if (!library.held() || !lanes.held()) {
      for (auto* all : {&times.hand, &times.library, &without_checks, &calls, &in_lanes}) all->pop_back();
    }
    return ok;
  };
  const auto compare = [&] {
    library.restore();
    lanes.restore();
    for (int leg = 0; leg < kLegs; ++leg) {
      const Vec ours = library.value(leg_name("B", leg), 0);
      for (const Vec& theirs : {hand.B(leg), unchecked.B(leg), lanes.value(leg_name("B", leg), 0)}) {
        for (std::size_t i = 0; i < 3; ++i) difference = std::max(difference, std::abs(ours[i] - theirs[i]));
      }
    }
    library.predict(scene.time().time(k + 1));
    lanes.predict(scene.time().time(k + 1));
  };
  for (int i = 0; i < kWarm; ++i) {
    if (!step()) return state.SkipWithError("a step failed");
  }
  times = {};
  without_checks.clear();
  calls.clear();
  in_lanes.clear();
  balls_by_hand = -hand.balls();
  for ([[maybe_unused]] auto _ : state) {
    if (!step()) return state.SkipWithError("a step failed");
    state.SetIterationTime(times.library.empty() ? 0 : times.library.back());
    compare();
    iterations += library.counters().newton_iterations;
    factorizations += library.counters().factorizations;
    balls += library.counters().branch_checks;
    iterations_by_hand += hand.iterations();
  }
  if (!(difference <= kSame)) return state.SkipWithError("the motions differ");
  if (!(hand.worst_error() <= kConverged)) return state.SkipWithError("a residual by hand is too large");
  times.report(state, 1);
  state.counters["unchecked"] = median(without_checks);
  state.counters["calls"] = median(calls);
  state.counters["over_unchecked"] = median_ratio(times.library, without_checks);
  state.counters["over_calls"] = median_ratio(times.library, calls);
  state.counters["lanes"] = median(in_lanes);
  state.counters["over_lanes"] = median_ratio(times.library, in_lanes);
  const auto per_leg = [&](std::int64_t all) {
    return static_cast<double>(all) / kLegs / static_cast<double>(state.iterations());
  };
  state.counters["iterations"] = per_leg(iterations);
  state.counters["factorizations"] = per_leg(factorizations);
  state.counters["balls"] = per_leg(balls);
  state.counters["iterations_by_hand"] = per_leg(iterations_by_hand);
  state.counters["balls_by_hand"] = per_leg(balls_by_hand + hand.balls());
  state.counters["difference"] = difference;
}

template <class Bare>
void register_library(const std::string& against = "") {
  const std::string id(Bare::kBackend);
  const auto row = std::find_if(backends().begin(), backends().end(), [&](const Backend& b) { return b.id == id; });
  if (row == backends().end() || !row->why_not({}, {}).empty()) return;
  struct Size {
    const char* kind;
    int n;
  };
  for (const auto& [kind, n] : {Size{"legs", 15}, {"ring", 30}, {"ring", 120}, {"ring", 360}}) {
    benchmark::RegisterBenchmark(("solver " + id + " " + kind + " n=" + std::to_string(n) + against).c_str(),
                                 compare_solvers<Bare>, std::string(kind), n)
        ->UseManualTime();
  }
  benchmark::RegisterBenchmark(("legs groups/" + id + against).c_str(), compare_legs<Bare>)->UseManualTime();
}

void register_all() {
  register_library<BareKlu>();
  register_library<BareKluUnscaled>(", by hand unscaled");
#ifdef ASSUR_BENCH_LAPACK
  if (openblas_set_num_threads != nullptr) openblas_set_num_threads(1);
  register_library<BareLapack>();
#endif
}

}  // namespace
}  // namespace assur::bench

int main(int argc, char** argv) { return assur::bench::run_program(argc, argv, assur::bench::register_all); }
