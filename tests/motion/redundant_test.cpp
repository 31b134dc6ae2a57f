// Mechanisms with redundant equations: in every row all equations, solved or checked, hold to rounding errors.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "plan/preparation.hpp"
#include "properties/random_count.hpp"
#include "properties/small_random_scenes.hpp"
#include "simulation/run.hpp"
#include "source_dir.hpp"

namespace assur {
namespace {

using Vec = std::array<long double, 3>;

constexpr double kPi = std::numbers::pi;
constexpr double kHolds = 1e-14;

Vec operator+(const Vec& a, const Vec& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Vec operator-(const Vec& a, const Vec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Vec operator*(long double s, const Vec& a) { return {s * a[0], s * a[1], s * a[2]}; }
long double dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec cross(const Vec& a, const Vec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Vec sizes(const Vec& a) { return {std::abs(a[0]), std::abs(a[1]), std::abs(a[2])}; }
long double norm(const Vec& a) { return std::sqrt(dot(a, a)); }
Triple triple(const Vec& a) { return {double(a[0]), double(a[1]), double(a[2])}; }

// Axes of a frame.
struct Frame3 {
  Vec x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};

  [[nodiscard]] Vec place(const Vec& v) const { return v[0] * x + (v[1] * y + v[2] * z); }
};

Frame3 turned(test::Draw& draw) {
  std::array<long double, 4> q{};
  long double size = 0;
  while (size < 0.1L || size > 1) {
    size = 0;
    for (auto& c : q) {
      c = draw.real(-1, 1);
      size += c * c;
    }
  }
  for (auto& c : q) c /= std::sqrt(size);
  const auto [w, i, j, k] = q;
  return {{1 - 2 * (j * j + k * k), 2 * (i * j + w * k), 2 * (i * k - w * j)},
          {2 * (i * j - w * k), 1 - 2 * (i * i + k * k), 2 * (j * k + w * i)},
          {2 * (i * k + w * j), 2 * (j * k - w * i), 1 - 2 * (i * i + j * j)}};
}

// Bennett's linkage (Bennett, Engineering 76, 1903): four revolute joints whose links alternate between lengths and
// twists (a, alpha) and (b, beta), a / sin(alpha) = b / sin(beta). Its joint angles obey
// tan(theta1 / 2) tan(theta2 / 2) = sin((beta + alpha) / 2) / sin((beta - alpha) / 2), theta3 = -theta1.
struct Bennett {
  double a = 1, alpha = kPi / 6, beta = kPi / 4;
  double b = a * std::sin(beta) / std::sin(alpha);
  double start = kPi / 2;  // crank angle at the start, between the links to joints 1 and 4
  Frame3 frame;

  [[nodiscard]] std::array<long double, 2> joints(long double crank) const {
    const long double first = -crank - std::numbers::pi_v<long double>;
    const long double k = std::sin((0.0L + beta + alpha) / 2) / std::sin((0.0L + beta - alpha) / 2);
    return {first, 2 * std::atan2(k * std::cos(first / 2), std::sin(first / 2))};
  }
  // Points and axes of joints 1 to 4, if link 1-2 is fixed.
  struct Posture {
    std::array<Vec, 4> point, axis;
  };
  [[nodiscard]] Posture posture(long double crank) const {
    const auto [first, second] = joints(crank);
    Posture p;
    Vec at{0, 0, 0}, x{1, 0, 0}, z{0, 0, 1};  // x: along the link behind the joint
    const std::array<long double, 4> angle = {0, second, -first, 0}, length = {a, b, a, b},
                                     twist = {alpha, beta, alpha, beta};
    for (std::size_t i = 0; i < 4; ++i) {
      x = std::cos(angle[i]) * x + std::sin(angle[i]) * cross(z, x);
      p.point[i] = frame.place(at);
      p.axis[i] = frame.place(z);
      at = at + length[i] * x;
      z = std::cos(twist[i]) * z + std::sin(twist[i]) * cross(x, z);
    }
    return p;
  }

  [[nodiscard]] Scene scene(int steps_per_turn, int steps) const {
    const Posture p = posture(start);
    SceneBuilder s("bennett", 3);
    s.fixed_point("P0", triple(p.point[0])).fixed_point("P1", triple(p.point[1]));
    s.fixed_vector("u0", triple(p.axis[0])).fixed_vector("u1", triple(p.axis[1]));
    for (const int i : {2, 3}) {
      s.point("P" + std::to_string(i), triple(p.point[std::size_t(i)]));
      s.vector("u" + std::to_string(i), triple(p.axis[std::size_t(i)]));
    }
    for (int i = 1; i < 4; ++i) {
      const std::string from = std::to_string(i), to = std::to_string((i + 1) % 4), link = from + to;
      const Direction rod("P" + from, "P" + to);
      s.constrain("length" + link, Distance{rod.first, rod.second, i == 2 ? a : b});
      s.constrain("begin" + link, Dot{"u" + from, rod, 0.0}).constrain("end" + link, Dot{"u" + to, rod, 0.0});
      s.constrain("twist" + link, Dot{"u" + from, "u" + to, std::cos(i == 2 ? alpha : beta)});
    }
    s.drive("crank", RelativeAngle{{"P0", "P1"}, {"P0", "P3"}, "u0", Law::polynomial({start, 2 * kPi})});
    return s.time(0, double(steps) / steps_per_turn, 1.0 / steps_per_turn).build();
  }

  // The largest relative residual of all equations in a row, and the position error of the coupler.
  struct Off {
    long double equations = 0, posture = 0;
  };
  [[nodiscard]] Off off(const Trajectory& t, std::size_t row) const {
    const Posture ideal =
        posture(start + 2 * std::numbers::pi_v<long double> * static_cast<long double>(t.times()[row]));
    Posture p = posture(start);
    for (std::size_t i = 0; i < 2; ++i) {  // rounded as in the scene
      for (auto& c : p.point[i]) c = double(c);
      for (auto& c : p.axis[i]) c = double(c);
      p.axis[i] = (1 / norm(p.axis[i])) * p.axis[i];
    }
    for (const std::size_t i : {2u, 3u}) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::string n = std::to_string(i), component(1, "xyz"[k]);
        p.point[i][k] = t(row, t.index("P" + n + "." + component));
        p.axis[i][k] = t(row, t.index("u" + n + "." + component));
      }
    }
    Off out;
    // Residuals are relative to their terms, sum |dPhi/dq| |q| + |constant|; those of dot products at least to
    // |d| |e|.
    const auto see = [&](long double residual, long double scale) {
      residual = std::abs(residual) / scale;
      if (!(residual <= out.equations)) out.equations = residual;
    };
    for (std::size_t i = 1; i < 4; ++i) {
      const std::size_t j = (i + 1) % 4;
      const long double length = i == 2 ? a : b;
      const Vec rod = p.point[j] - p.point[i];
      const Vec ends = sizes(p.point[i]) + sizes(p.point[j]), bar = sizes(rod);
      see(dot(rod, rod) - length * length, 2 * dot(bar, ends) + length * length);
      for (const Vec& u : {p.axis[i], p.axis[j]}) {
        see(dot(u, rod), std::max(norm(rod), dot(sizes(u), ends) + dot(sizes(u), bar)));
      }
      const long double twist = static_cast<double>(std::cos(i == 2 ? alpha : beta));
      see(dot(p.axis[i], p.axis[j]) - twist, 2 * dot(sizes(p.axis[i]), sizes(p.axis[j])) + std::abs(twist));
      if (i > 1) see(dot(p.axis[i], p.axis[i]) - 1, 2 * dot(p.axis[i], p.axis[i]) + 1);
      if (i > 1) out.posture = std::max(out.posture, norm(p.point[i] - ideal.point[i]) / std::max(a, b));
    }
    return out;
  }
};

void turn(const Bennett& linkage, int steps_per_turn, int steps, const std::string& strategy) {
  SCOPED_TRACE(strategy + ": " + std::to_string(steps_per_turn) + " steps a turn from " +
               std::to_string(linkage.start) + ", alpha " + std::to_string(linkage.alpha) + ", beta " +
               std::to_string(linkage.beta) + ", a " + std::to_string(linkage.a));
  const test::Result r = test::run(linkage.scene(steps_per_turn, steps), strategy);
  EXPECT_EQ(r.report().status.code, Code::ok) << "at " << r.report().reached;
  ASSERT_EQ(r.trajectory.rows(), std::size_t(steps) + 1);
  EXPECT_LE(r.report().error.position, kHolds);
  long double equations = 0, posture = 0;
  for (std::size_t row = 0; row < r.trajectory.rows(); ++row) {
    const Bennett::Off off = linkage.off(r.trajectory, row);
    equations = std::max(equations, off.equations);
    posture = std::max(posture, off.posture);
  }
  EXPECT_LE(equations, kHolds);
  // The linkage can only move if its dimensions are exact. Their rounding has an effect, amplified by the condition of
  // all equations.
  EXPECT_LE(posture, 1e-12);
}

TEST(Redundant, BennettsLinkageTurnsAHundredTimes) {
  test::Draw draw(19);
  for (int i = 0, all = test::random_count(3); i < all; ++i) {
    Bennett linkage;
    if (i % 2 != 0) linkage.frame = turned(draw);
    if (i > 1) linkage.start = draw.maybe() ? double(draw.below(24)) * kPi / 12 : draw.real(0, 2 * kPi);
    const int steps = i < 2 ? 48 : draw.maybe() ? 12 * int(1 + draw.below(30)) : int(draw.real(20, 400));
    turn(linkage, steps, 100 * steps, "auto");
  }
}

// A set that was used before is taken again without an analysis of the scene, and a motion that is repeated takes the
// same sets with the same bits.
TEST(Redundant, SetsThatAreKnownNeedNoAnalysis) {
  const Scene scene = read_scene(ASSUR_SOURCE_DIR "/scenes/bricard_joints.json");  // it turns twice
  for (const char* strategy : {"irreducible/lanes", "irreducible/eigen"}) {
    Preparation prepared = preparation(prepare(scene, {.strategy = strategy}));
    int analyses = 0, choices = 0;
    prepared.reselect = [&, choose = prepared.reselect](std::vector<double> at, double t,
                                                        std::vector<std::int32_t> checked) {
      ++analyses;
      Preparation chosen = choose(std::move(at), t, checked);
      std::vector<std::int32_t> found = chosen.structure->checks;
      std::sort(found.begin(), found.end());
      EXPECT_EQ(found, checked) << "at t = " << t;
      return chosen;
    };
    Simulator simulator(Preparation::shared(prepared));
    std::vector<double> first;
    for (int round = 0; round < 3; ++round) {
      const std::vector<std::int32_t>* checks = nullptr;
      simulator.reset();
      std::vector<double> values;
      for (std::int64_t k = 0; k < scene.time().steps(); ++k) {
        ASSERT_TRUE(simulator.step().ok());
        values.insert(values.end(), simulator.outputs().begin(), simulator.outputs().end());
        const std::vector<std::int32_t>* now = &preparation(simulator.prepared()).structure->checks;
        choices += now != checks ? 1 : 0;
        checks = now;
      }
      if (round == 0) {
        EXPECT_GT(analyses, 0);
        EXPECT_GT(choices, 2 * analyses);
        first = values;
      }
      EXPECT_EQ(values, first) << strategy << ", round " << round;
      EXPECT_EQ(round > 0 ? analyses : 0, 0) << "in round " << round;
      analyses = 0;
    }
  }
}

// Simulators of a motion that was rehearsed know its sets, and give the same bits as others.
TEST(Redundant, RehearsedSetsNeedNoAnalysis) {
  for (const std::string file : {"bricard_joints", "goldberg", "delta"}) {
    const Scene scene = read_scene(ASSUR_SOURCE_DIR "/scenes/" + file + ".json");
    const Prepared prepared = prepare(scene, {.strategy = "irreducible/lanes"});
    Preparation rehearsed = preparation(rehearse(prepared));
    EXPECT_EQ(rehearsed.other_sets.empty(), file == "delta") << file;  // whose first set serves
    int analyses = 0;
    rehearsed.reselect = [&](std::vector<double> at, double time, std::vector<std::int32_t> checked) {
      ++analyses;
      return preparation(prepared).reselect(std::move(at), time, std::move(checked));
    };
    Simulator known(Preparation::shared(rehearsed)), alone(prepared);
    std::int64_t changes = 0;
    const std::vector<std::int32_t>* checks = &preparation(known.prepared()).structure->checks;
    for (std::int64_t k = 0; k < scene.time().steps(); ++k) {
      ASSERT_TRUE(known.step().ok() && alone.step().ok()) << file;
      ASSERT_TRUE(std::equal(known.outputs().begin(), known.outputs().end(), alone.outputs().begin())) << file;
      changes += std::exchange(checks, &preparation(known.prepared()).structure->checks) !=
                         &preparation(known.prepared()).structure->checks
                     ? 1
                     : 0;
    }
    EXPECT_EQ(changes > 0, file != "delta") << file;
    EXPECT_EQ(analyses, 0) << file;
  }
}

// Another set of equations does not ask the performance model again: the solvers are those of the first set.
TEST(Redundant, AnotherSetKeepsThePlan) {
  const Scene scene = read_scene(ASSUR_SOURCE_DIR "/scenes/bricard_joints.json");
  const Prepared first = prepare(scene);
  const auto solvers = [](const Plan& plan) {
    std::set<std::string> all;
    for (const Plan::Choice& c : plan.choices) all.insert(to_string(plan.strategy(c)));
    return all;
  };
  Simulator simulator(first);
  int others = 0;
  for (std::int64_t k = 0; k < scene.time().steps(); ++k) {
    ASSERT_TRUE(simulator.step().ok());
    const Prepared prepared = simulator.prepared();
    const Preparation& now = preparation(prepared);
    if (now.structure->checks == preparation(first).structure->checks) continue;
    ++others;
    ASSERT_EQ(now.plan.choices.size(), now.structure->classes.size());
    EXPECT_EQ(now.structure->formulation, first.structure().formulation());
    EXPECT_EQ(solvers(now.plan), solvers(first.plan()));
    EXPECT_EQ(now.plan.reason, first.plan().reason);
    EXPECT_EQ(now.plan.expected_seconds, first.plan().expected_seconds);
    for (const Plan::Choice& c : now.plan.choices) EXPECT_EQ(c.shape.n, now.structure->classes[c.group_class].n);
  }
  EXPECT_GT(others, 0);
}

// The start postures of chunks use the equations of the start; if these have to be reselected, the run is in sequence.
TEST(Redundant, ChunksWithReselectedEquationsRunInSequence) {
  const Scene scene = Bennett{}.scene(48, 96);
  const test::Result alone = test::run(scene, "groups/eigen"), cut = test::run(scene, "groups/eigen+chunks=4");
  EXPECT_EQ(cut.trajectory.values(), alone.trajectory.values());
  const std::vector<std::string>& told = cut.report().fallbacks;
  EXPECT_TRUE(std::any_of(told.begin(), told.end(), [](const std::string& line) {
    return line.find("no chunks: start postures were found only up to") != std::string::npos;
  }));
}

TEST(Redundant, BennettsLinkageOfAnyShapeTurns) {
  test::Draw draw(7);
  const std::vector<std::string> strategies = {"auto", "global/eigen", "irreducible/lanes", "groups/" + test::sparse()};
  for (int i = 0, all = test::random_count(40); i < all; ++i) {
    Bennett linkage;
    if (i % 4 != 0) {
      linkage.a = draw.real(0.3, 3);
      linkage.alpha = draw.real(0.2, 0.9);
      linkage.beta = linkage.alpha + draw.real(0.15, 0.6);
      linkage.b = linkage.a * std::sin(linkage.beta) / std::sin(linkage.alpha);
    }
    linkage.start = i % 3 == 0 ? double(draw.below(24)) * kPi / 12 : draw.real(0, 2 * kPi);
    if (draw.maybe()) linkage.frame = turned(draw);
    const int steps = draw.maybe() ? 12 * int(1 + draw.below(30)) : int(draw.real(20, 400));
    turn(linkage, steps, 2 * steps, draw.of(strategies));
  }
}

// Sets of equations that were used close to their own singularity once lost eight digits of the accelerations.
TEST(Redundant, BennettsLinkageKeepsItsAccuracyAfterReselection) {
  if (std::numeric_limits<long double>::digits < 64) {
    GTEST_SKIP() << "the differences below are not exact to 1e-13: long double has the precision of double here";
  }
  for (const auto& [start, steps] : {std::pair{kPi / 2, 5000}, std::pair{75 * kPi / 180, 400}}) {
    SCOPED_TRACE(steps);
    Bennett linkage;
    linkage.start = start;
    const test::Result r = test::run(linkage.scene(steps, steps));
    EXPECT_EQ(r.report().status.code, Code::ok);
    std::array<long double, 3> off{};
    for (std::size_t row = 0; row < r.trajectory.rows(); ++row) {
      // Derivatives of the closed form by differences of eighth order, exact to 1e-13.
      constexpr long double kStep = 1e-3L, kTurn = 2 * std::numbers::pi_v<long double>;
      constexpr std::array<long double, 5> kFirst = {0, 4.0L / 5, -1.0L / 5, 4.0L / 105, -1.0L / 280};
      constexpr std::array<long double, 5> kSecond = {-205.0L / 72, 8.0L / 5, -1.0L / 5, 8.0L / 315, -1.0L / 560};
      const long double crank = start + kTurn * static_cast<long double>(r.trajectory.times()[row]);
      std::array<Vec, 3> ideal{};  // P3 and its derivatives by the crank angle
      for (int k = -4; k <= 4; ++k) {
        const Vec at = linkage.posture(crank + k * kStep).point[3];
        const auto i = static_cast<std::size_t>(std::abs(k));
        if (k == 0) ideal[0] = at;
        ideal[1] = ideal[1] + (k < 0 ? -1 : 1) * kFirst[i] / kStep * at;
        ideal[2] = ideal[2] + kSecond[i] / (kStep * kStep) * at;
      }
      for (std::size_t d = 0; d < 3; ++d) {
        for (std::size_t k = 0; k < 3; ++k) {
          const std::string column = std::array{"P3.", "P3.v", "P3.a"}[d] + std::string(1, "xyz"[k]);
          const long double is = r.trajectory(row, r.trajectory.index(column));
          off[d] = std::max(off[d], std::abs(is / std::pow(kTurn, static_cast<long double>(d)) - ideal[d][k]));
        }
      }
    }
    // The dimensions equal those of the closed form up to rounding of doubles.
    EXPECT_LE(off[0], 1e-13);
    EXPECT_LE(off[1], 1e-12);
    EXPECT_LE(off[2], 1e-11);
  }
}

}  // namespace
}  // namespace assur
