// A saved and loaded plan runs bitwise like the original. Other files are refused.
#include "assur/saved_plan.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <functional>
#include <random>
#include <sstream>

#include "assur/ensemble.hpp"
#include "files/shipped_files.hpp"
#include "plan/preparation.hpp"
#include "properties/random_count.hpp"
#include "samples/samples.hpp"
#include "simulation/same_run.hpp"
#include "simulation/towers.hpp"

namespace assur {
namespace {

using test::Result;

std::string saved(const Prepared& prepared) {
  std::ostringstream out;
  save_plan(out, prepared);
  return out.str();
}

Prepared loaded(const std::string& text, const LoadOptions& options = {backends(), ThreadBudget{4}}) {
  std::istringstream in(text);
  return load_plan(in, options);
}

Result run(Prepared prepared) {
  Simulator simulator(std::move(prepared));
  Trajectory motion = simulator.run();
  return {std::move(simulator), std::move(motion)};
}

void expect_same_plan(const Plan& a, const Plan& b) {
  EXPECT_EQ(a.run.formulation, b.run.formulation);
  EXPECT_EQ(a.run.predictor, b.run.predictor);
  EXPECT_EQ(a.lanes, b.lanes);
  EXPECT_EQ(a.run.chunks, b.run.chunks);
  EXPECT_EQ(a.run.together, b.run.together);
  EXPECT_EQ(a.run.threads, b.run.threads);
  EXPECT_EQ(a.level_threads, b.level_threads);
  EXPECT_EQ(a.reason, b.reason);
  EXPECT_EQ(a.expected_seconds, b.expected_seconds);
  EXPECT_EQ(a.meeting_seconds, b.meeting_seconds);
  ASSERT_EQ(a.choices.size(), b.choices.size());
  for (std::size_t c = 0; c < a.choices.size(); ++c) {
    EXPECT_EQ(a.choices[c].group_class, b.choices[c].group_class);
    Shape saved = a.choices[c].shape;
    saved.one_program = b.choices[c].shape.one_program;  // is not saved
    EXPECT_EQ(saved, b.choices[c].shape);
    EXPECT_EQ(a.strategy(a.choices[c]), b.strategy(b.choices[c]));
    EXPECT_EQ(a.choices[c].reason, b.choices[c].reason);
    EXPECT_EQ(a.choices[c].expected_seconds, b.choices[c].expected_seconds);
    EXPECT_EQ(a.choices[c].origin, b.choices[c].origin);
  }
}

// The scene with at most this number of steps.
Scene shortened(const Scene& scene, std::int64_t steps) {
  const TimeGrid& t = scene.time();
  return t.steps() <= steps ? scene : scene.with_time({t.start, t.start + static_cast<double>(steps) * t.step, t.step});
}

// Every sample, some in other sizes, and every scene file.
std::vector<std::string> shipped() {
  std::vector<std::string> scenes = {"stewart:legs=22", "stewart:platforms=3", "four_bar:64", "n_four_bar:7"};
  for (const samples::SampleMechanism& row : samples::table()) scenes.emplace_back(row.name);
  for (const auto& file : test::shipped_files()) scenes.push_back(file);
  return scenes;
}

void expect_same_jacobians(const Prepared& a, const Prepared& b) {
  const ConstraintJacobian made = Simulator(a).constraint_jacobian(), read = Simulator(b).constraint_jacobian();
  EXPECT_EQ(made.unknowns.empty(), a.structure().groups().empty());
  EXPECT_EQ(made.equations, read.equations);
  EXPECT_EQ(made.unknowns, read.unknowns);
  EXPECT_EQ(made.column_start, read.column_start);
  EXPECT_EQ(made.row, read.row);
  EXPECT_EQ(made.values, read.values);
}

void expect_to_run_alike(const Prepared& made, const std::string& text) {
  const Prepared again = loaded(text);
  EXPECT_EQ(saved(again), text);
  EXPECT_EQ(again.name(), made.scene()->name());
  EXPECT_TRUE(preparation(again).structure->classes == preparation(made).structure->classes);
  expect_same_plan(made.plan(), again.plan());
  Preparation original = preparation(made);
  original.reselect = nullptr;  // a saved plan keeps its set of the redundant equations
  expect_same_run(run(Preparation::shared(std::move(original))), run(again));
  expect_same_jacobians(made, again);
}

TEST(SavedPlan, EveryShippedSceneRunsLikeItsOriginal) {
  for (const std::string& text : shipped()) {
    const Scene scene = shortened(open_scene(text), 40);
    std::vector<PrepareOptions> ways = {{}, {.strategy = "irreducible/lanes:8"}, {.strategy = "groups/eigen:4 3x1"}};
    ways.push_back({.strategy = "groups/" + test::sparse()});
    ways.push_back({.strategy = "irreducible/eigen+float+once+predict=taylor:2"});
    ways.push_back({.strategy = "irreducible/lanes:4+refine+reuse=run+predict=past:3"});
    if (!test::has_callback(scene)) ways.push_back({.strategy = "irreducible/lanes:8+chunks=3"});
    ways.push_back({.mode = Mode::throughput});
    for (PrepareOptions& way : ways) {
      SCOPED_TRACE(text + ", " + way.strategy + (way.mode == Mode::throughput ? ", throughput" : ""));
      way.budget = ThreadBudget{3};
      way.model = std::make_shared<const PerformanceModel>();
      const Prepared made = prepare(scene, way);
      expect_to_run_alike(made, saved(made));
      if (HasFailure()) return;
    }
  }
}

TEST(SavedPlan, HoldsGearsAndRacks) {
  const auto wheels = [](int dimension) {
    const Anchor axis = dimension == 3 ? Anchor(Triple{0, 0, 1}) : Anchor();
    return SceneBuilder("wheels", dimension)
        .add(Body{.name = "A"})
        .add(Body{.name = "B"})
        .add(Body{.name = "C"})
        .joint("a", Revolute{"ground", "A", Triple{0, 0, 0}, axis})
        .joint("b", Revolute{"ground", "B", Triple{1, 0, 0}, axis})
        .joint("c", Prismatic{"ground", "C", Triple{0, 1, 0}})
        .constrain("gear", Gear{"a.angle", "b.angle", -3.0 / 7})
        .constrain("rack", Gear{"b.angle", "c.displacement", 0.25})
        .drive("motor", DrivenCoordinate{"a.angle", Law::harmonics({{2, 0.5, 0}})})
        .output("b.angle")
        .output("c.displacement")
        .time(0, 1, 0.01)
        .build();
  };
  for (const int dimension : {2, 3}) {
    for (const std::string strategy : {"auto", "groups/eigen", "irreducible/lanes"}) {
      const Prepared made = prepare(wheels(dimension), {strategy});
      expect_to_run_alike(made, saved(made));
    }
  }
}

TEST(SavedPlan, LawsAndNamesReadBackUnchanged) {
  SceneBuilder b("a \"four\\bar\"\nof two lines", 2);
  b.fixed_point("A", {0, 0}).fixed_point("D", {2, 0}).point("B", {0.8, 0}).point("C", {1.6, 1.2});
  b.constrain("coupler", Distance{"B", "C", 1.8}).constrain("rocker", Distance{"D", "C", 1.3});
  const Law table = Law::table({0, 0.1, 0.25, 0.4}, {0, 0.1, -0.2, 1.0 / 3});
  const Law periodic = Law::table({-0.1, 0.1, 0.3}, {0.1, 0.15, 0.1}, true);
  b.drive("motor", PointAngle{"A", "B", "",
                              table + periodic + Law::harmonics({{0.1, 0.7, 1e-300}, {-0.2, 3, 0.5}}, -0.0) +
                                  Law::polynomial({0, 1.0 / 3})});
  const Scene scene = b.time(0, 0.4, 0.01).build();
  for (const std::string strategy : {"groups/eigen", "irreducible/lanes:1+predict=past:2"}) {
    const Prepared made = prepare(scene, {strategy});
    expect_to_run_alike(made, saved(made));
  }
}

TEST(SavedPlan, KeepsOutputsAndGroupsSolvedOnce) {
  const std::vector<std::vector<std::string>> wanted = {
      {"B1.position"}, {"rocker_angle.rate", "B1.velocity"}, {"B0", "B1", "rocker_angle.value"}};
  for (const auto& outputs : wanted) {
    const Prepared made = prepare(shortened(sample("four_bar"), 30).with_outputs(outputs).with_time({0, 0.1, 0.01}));
    expect_to_run_alike(made, saved(made));
  }
}

TEST(SavedPlan, ControlledDriversCanBeSet) {
  for (const std::string strategy : {"auto", "groups/eigen", "irreducible/lanes:8"}) {
    const Prepared made = prepare(sample("stewart"), {.strategy = strategy, .controlled = {"pose"}});
    Simulator original(made), again(loaded(saved(made)));
    for (int k = 1; k <= 50; ++k) {
      for (Simulator* s : {&original, &again}) {
        s->set("pose.x", 0.01 * std::sin(0.1 * k), 0.1 * std::cos(0.1 * k));
        s->set("pose.phi", 0.002 * k, 0.2);
        ASSERT_TRUE(s->step().ok()) << k;
      }
      ASSERT_TRUE(std::equal(original.outputs().begin(), original.outputs().end(), again.outputs().begin(),
                             again.outputs().end(), test::same_bits));
    }
    EXPECT_THROW(again.set("nobody", 1), Error);
  }
}

TEST(SavedPlan, EnsembleMembersShareALoadedPlan) {
  const Prepared made = prepare(shortened(sample("stewart"), 20), {"irreducible/lanes:4"});
  const Prepared again = loaded(saved(made));
  Ensemble original(5, [&](std::size_t) { return made; }), copy(5, [&](std::size_t) { return again; });
  const EnsembleTrajectory a = original.run(), b = copy.run();
  ASSERT_EQ(a.values().size(), b.values().size());
  EXPECT_TRUE(std::equal(a.values().begin(), a.values().end(), b.values().begin(), test::same_bits));
}

TEST(SavedPlan, TheCoreAloneRunsALoadedPlan) {
  for (const Prepared& made : {prepare(shortened(sample("stewart"), 40), {"irreducible/lanes:8"}),
                               prepare(test::tower(3, 11, 1), {"irreducible/lanes:8+together"})}) {
    const Result original = run(made), alone = run(loaded(saved(made), {}));
    expect_same_run(original, alone);
  }
}

// The triangle has a redundant rod (see levels_test.cpp), and the redundant equation changes during the run.
TEST(SavedPlan, DoesNotReselectEquationsWithoutTheScene) {
  SceneBuilder b("triangle", 2);
  const double x = std::cos(1.5), y = std::sin(1.5);
  b.fixed_point("A", {0, 0}).point("B", {x, y}).constrain("crank", Distance{"A", "B", 1.0});
  b.drive("motor", PointAngle{"A", "B", "", Law::polynomial({1.5, 1})});
  b.fixed_point("D", {2, 0}).fixed_point("E", {1, 1}).point("C", {x + 2, y}).point("M", {x + 1, y + 1});
  b.constrain("base", Distance{"B", "C", 2.0}).constrain("left", Distance{"B", "M", std::sqrt(2.0)});
  b.constrain("right", Distance{"C", "M", std::sqrt(2.0)});
  b.constrain("rocker", Distance{"D", "C", 1.0}).constrain("third", Distance{"E", "M", 1.0});
  const Prepared made = prepare(b.time(0, 6, 0.05).build(), {"groups/eigen"});
  ASSERT_TRUE(preparation(made).reselect);
  const Result original = run(made), again = run(loaded(saved(made)));
  EXPECT_TRUE(original.report().status.ok());
  ASSERT_FALSE(original.report().fallbacks.empty());
  EXPECT_TRUE(again.report().fallbacks.empty());
  // The equations of the plan become singular in regular postures of the mechanism. The run passes these postures as
  // change points and reports them, and it checks the redundant equation. The estimated errors include these postures.
  ASSERT_TRUE(again.report().status.ok());
  ASSERT_EQ(again.report().events.size(), 2u);
  for (const Event& e : again.report().events) EXPECT_EQ(e.kind, Code::change_point_passed);
  const ErrorFigures& error = again.report().error;
  const double bound = std::max({*error.estimated_position, *error.estimated_velocity, *error.estimated_acceleration});
  ASSERT_EQ(again.trajectory.rows(), original.trajectory.rows());
  for (std::size_t i = 0; i < again.trajectory.values().size(); ++i) {
    ASSERT_NEAR(again.trajectory.values()[i], original.trajectory.values()[i], bound) << i;
  }
}

// ---- refusals

Error::Kind kind_of(const std::function<void()>& call, std::string* what = nullptr) {
  try {
    call();
  } catch (const Error& e) {
    if (what) *what = e.what();
    return e.kind();
  }
  ADD_FAILURE() << "nothing was thrown";
  return {};
}

TEST(SavedPlan, FunctionsCannotBeSaved) {
  const auto builder = [](const Law& law) {
    SceneBuilder b("four_bar", 2);
    b.fixed_point("A", {0, 0}).fixed_point("D", {2, 0}).point("B", {0.8, 0}).point("C", {1.6, 1.2});
    b.constrain("coupler", Distance{"B", "C", 1.8}).drive("motor", PointAngle{"A", "B", "", law});
    return b.time(0, 1, 0.01);
  };
  const Law function = Law::function([](double t) { return Motion{t, 1, 0}; });
  std::string what;
  const Prepared by_law = prepare(builder(function).constrain("rocker", Distance{"D", "C", 1.3}).build());
  EXPECT_EQ(kind_of([&] { (void)saved(by_law); }, &what), Error::Kind::input);
  EXPECT_NE(what.find("'motor'"), std::string::npos) << what;

  Callback rocker{{"C.x", "C.y"}, 1, {}, {}, {}};
  rocker.residual = [](auto p, auto phi) { phi[0] = (p[0] - 2) * (p[0] - 2) + p[1] * p[1] - 1.69; };
  rocker.jacobian = [](auto p, auto j) {
    j[0] = 2 * (p[0] - 2);
    j[1] = 2 * p[1];
  };
  rocker.curvature = [](auto, auto v, auto c) { c[0] = 2 * (v[0] * v[0] + v[1] * v[1]); };
  const Prepared by_callback = prepare(builder(Law::polynomial({0, 1})).constrain("rocker", rocker).build());
  EXPECT_EQ(kind_of([&] { (void)saved(by_callback); }, &what), Error::Kind::input);
  EXPECT_NE(what.find("'rocker'"), std::string::npos) << what;
}

TEST(SavedPlan, NamesAMissingBackend) {
  if (test::sparse() != "klu") GTEST_SKIP() << "without klu";
  const std::string text = saved(prepare(sample("stewart"), {"groups/klu"}));
  std::string what;
  EXPECT_EQ(kind_of([&] { (void)loaded(text, {}); }, &what), Error::Kind::environment);
  EXPECT_NE(what.find("klu"), std::string::npos) << what;
  EXPECT_NE(what.find("--without klu"), std::string::npos) << what;
  EXPECT_NO_THROW((void)loaded(text, {.table = backends()}));
}

TEST(SavedPlan, UsesFewerThreadsAndReportsIt) {
  const Prepared made = prepare(shortened(sample("stewart"), 20), {"groups/eigen 3x1", {}, ThreadBudget{3}});
  const std::string text = saved(made);
  EXPECT_EQ(loaded(text, {.budget = ThreadBudget{3}}).plan().reason, "forced");
  const Prepared fewer = loaded(text, {.budget = ThreadBudget{2}});
  EXPECT_EQ(fewer.plan().run.threads, 2);
  EXPECT_EQ(fewer.plan().choices[0].threads, 2);
  EXPECT_NE(fewer.plan().reason.find("2 instead of 3 threads"), std::string::npos) << fewer.plan().reason;
  test::expect_same_rows(run(made).trajectory, run(fewer).trajectory);
  EXPECT_EQ(kind_of([&] { (void)loaded(text, {.budget = ThreadBudget{0}}); }), Error::Kind::input);
}

TEST(SavedPlan, KeepsThreadsOfTheLinearAlgebra) {
  if (!find_backend(backends(), "team").why_not({}, {2}).empty()) GTEST_SKIP() << "without team";
  const std::string text = saved(prepare(sample("stewart"), {"groups/team 2x2", {}, ThreadBudget{4}}));
  EXPECT_EQ(loaded(text, {.table = backends(), .budget = ThreadBudget{3}}).plan().run.threads, 1);
  const auto load = [&] { (void)loaded(text, {.table = backends(), .budget = ThreadBudget{1}}); };
  EXPECT_EQ(kind_of(load), Error::Kind::environment);
}

TEST(SavedPlan, TheReferenceNeedsTheScene) {
  const Prepared again = loaded(saved(prepare(shortened(sample("four_bar"), 5), {"groups/eigen"})));
  const Trajectory motion = Simulator(again).run();
  EXPECT_THROW((void)forward_error(again, motion), Error);
}

TEST(SavedPlan, RefusesOtherFiles) {
  const std::string text = saved(prepare(sample("four_bar"), {"groups/eigen"}));
  std::string what;
  for (const std::string& other : {std::string("{\"assur\": 1}"), std::string("\0\0\0", 3), text.substr(1)}) {
    EXPECT_EQ(kind_of([&] { (void)loaded(other); }, &what), Error::Kind::input);
    EXPECT_NE(what.find("not a saved plan"), std::string::npos) << what;
  }
  std::string later = text;
  later.replace(0, 12, "assur plan 9");
  EXPECT_EQ(kind_of([&] { (void)loaded(later); }, &what), Error::Kind::input);
  EXPECT_NE(what.find("version 8"), std::string::npos) << what;
  EXPECT_EQ(kind_of([] { (void)loaded(""); }), Error::Kind::input);
  std::istringstream missing;
  missing.setstate(std::ios::failbit);
  EXPECT_EQ(kind_of([&] { (void)load_plan(missing); }), Error::Kind::environment);
  std::ostringstream full;
  full.setstate(std::ios::badbit);
  EXPECT_EQ(kind_of([&] { save_plan(full, prepare(sample("four_bar"))); }), Error::Kind::environment);
}

// ---- damaged files

// A second implementation of FNV-1a.
std::string signed_again(std::string text) {
  text.resize(text.rfind("checksum "));
  std::uint64_t hash = 14695981039346656037u;
  for (const char c : text) {
    hash ^= static_cast<unsigned char>(c);
    hash *= 1099511628211u;
  }
  char digits[17];
  std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(hash));
  return text + "checksum " + digits + "\n";
}

TEST(SavedPlan, DetectsDamage) {
  const std::string text = saved(prepare(sample("stewart"), {"irreducible/lanes:8"}));
  ASSERT_EQ(signed_again(text), text);
  std::mt19937 random(5);
  const auto below = [&](std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random); };
  for (int k = 0; k < test::random_count(100); ++k) {
    std::string damaged = text;
    const std::size_t at = below(text.size());
    damaged[at] = static_cast<char>(static_cast<unsigned char>(damaged[at]) + 1 + below(255));
    EXPECT_EQ(kind_of([&] { (void)loaded(damaged); }), Error::Kind::input) << at;
    EXPECT_EQ(kind_of([&] { (void)loaded(text.substr(0, below(text.size()))); }), Error::Kind::input);
    damaged = text;
    damaged.insert(below(text.size() + 1), 1 + below(30), ' ');
    EXPECT_EQ(kind_of([&] { (void)loaded(damaged); }), Error::Kind::input);
  }
}

// Begin and end of each number that is not part of a name.
std::vector<std::pair<std::size_t, std::size_t>> numbers_of(const std::string& text) {
  std::vector<std::pair<std::size_t, std::size_t>> found;
  bool in_name = false;
  for (std::size_t i = 12, begin = 0; i < text.rfind("checksum "); ++i) {
    if (text[i] == '"') in_name = !in_name;
    const bool space = text[i] == ' ' || text[i] == '\n';
    if (space && !in_name && begin > 0) found.emplace_back(begin, i);
    if (space || in_name) begin = 0;
    if (begin == 0 && !in_name && (text[i] == '-' || std::isdigit(static_cast<unsigned char>(text[i])))) {
      if (text[i - 1] == ' ' || text[i - 1] == '\n') begin = i;
    }
  }
  return found;
}

// Numbers are changed and the checksum is made valid. The plan is refused, or the motion differs or ends with a status,
// but no foreign memory is accessed (address sanitizers check this).
TEST(SavedPlan, SurvivesTamperedNumbers) {
  // Each process draws other numbers.
  std::mt19937 random(17 + static_cast<unsigned>(testing::UnitTest::GetInstance()->random_seed()));
  const auto below = [&](std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random); };
  const std::vector<std::string> others = {"0",  "1",   "-1",      "-2",         "2",           "3",   "7",    "8",
                                           "16", "255", "1000000", "2147483647", "-2147483648", "0.5", "1e300"};
  int refused = 0, accepted = 0;
  for (const auto& [scene, strategy] :
       std::vector<std::pair<Scene, std::string>>{{sample("stewart"), "irreducible/lanes:8"},
                                                  {sample("four_bar:3"), "groups/eigen:2+chunks=3 2x1"},
                                                  {sample("andrews"), "irreducible/lanes:4"},
                                                  {sample("geared_five_bar"), "groups/eigen"},
                                                  {sample("slider_crank"), "groups/eigen+predict=past:3"},
                                                  {test::tower(2, 3, 3), "irreducible/lanes:4+together"}}) {
    const std::string text = saved(prepare(shortened(scene, 5), {strategy, {}, ThreadBudget{2}}));
    const auto numbers = numbers_of(text);
    ASSERT_GT(numbers.size(), 100u);
    for (int k = 0; k < test::random_count(150); ++k) {
      std::string altered = text;
      const auto [begin, end] = numbers[below(numbers.size())];
      altered.replace(begin, end - begin, others[below(others.size())]);
      try {
        const Prepared prepared = loaded(signed_again(altered), {backends(), ThreadBudget{2}});
        ++accepted;
        // A law may now turn a million times within a step.
        int substeps = 0;
        StepSettings settings;
        settings.stop = [&] { return ++substeps > 1000; };
        Simulator simulator(prepared, settings);
        const double t = simulator.time(), step = prepared.time().step;
        (void)simulator.run(std::vector<double>{t, t + step, t + 2 * step, t + 3 * step, t + 4 * step});
      } catch (const Error&) {
        ++refused;
      }
    }
  }
  EXPECT_GT(refused, 0);
  EXPECT_GT(accepted, 0);
}

}  // namespace
}  // namespace assur
