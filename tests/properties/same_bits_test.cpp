// The backend `lanes` gives the same bits by machine code and by kernels, for every number of lanes, in every tile, and
// on any number of threads.
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "assur/ensemble.hpp"
#include "assur/simulator.hpp"
#include "files/shipped_files.hpp"
#include "numbers.hpp"
#include "plan/preparation.hpp"
#include "program/group_step.hpp"
#include "properties/random_count.hpp"
#include "properties/small_random_scenes.hpp"
#include "simulation/same_run.hpp"
#include "simulation/towers.hpp"

namespace assur {
namespace {

Prepared with(const Scene& scene, const std::string& strategy, bool machine_code) {
  PrepareOptions options{.strategy = strategy};
  options.machine_code = machine_code;
  return prepare(scene, options);
}

bool same_bits(std::span<const double> a, std::span<const double> b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), test::same_bits);
}

bool only_small_groups(const GroupedSystem& structure) {
  return std::all_of(structure.classes.begin(), structure.classes.end(), has_group_step);
}

// At most 300 steps.
Scene shortened(const Scene& scene) {
  const TimeGrid& time = scene.time();
  return scene.with_time({time.start, std::min(time.end, time.start + 300 * time.step), time.step});
}

struct Outcome {
  Trajectory rows;
  Report report;
};
Outcome run(const Scene& scene, const std::string& lanes, bool machine_code) {
  Simulator simulator(with(scene, "irreducible/" + lanes, machine_code));
  Trajectory rows = simulator.run();
  return {std::move(rows), simulator.report()};
}

void expect_same_bits(const Outcome& found, const Outcome& expected) {
  EXPECT_TRUE(same_bits(found.rows.values(), expected.rows.values()));
  EXPECT_EQ(found.report.status.code, expected.report.status.code);
  EXPECT_EQ(found.report.events.size(), expected.report.events.size());
  for (const auto figure : {&ErrorFigures::position, &ErrorFigures::velocity, &ErrorFigures::acceleration}) {
    EXPECT_TRUE(test::same_bits(found.report.error.*figure, expected.report.error.*figure));
  }
}

// The groups of all levels together: machine code and kernels agree, for every number of lanes, and on two threads.
// False if the strategy cannot solve the mechanism.
bool expect_same_bits_together(const Scene& scene) {
  try {
    (void)with(scene, "irreducible/lanes:4+together", false);
  } catch (const Error&) {
    return false;
  }
  const Outcome expected = run(scene, "lanes:4+together", false);
  for (const char* way : {"lanes:4+together", "lanes:8+together", "lanes:16+together", "lanes:8+together 2x1"}) {
    for (const bool code : {true, false}) {
      SCOPED_TRACE(scene.name() + " " + way + (code ? ", machine code" : ", kernels"));
      expect_same_bits(run(scene, way, code), expected);
    }
  }
  return true;
}

// Machine code and kernels agree; and if all groups are small, so do all numbers of lanes. True if they are.
bool expect_same_bits(const Scene& scene) {
  const bool small = only_small_groups(*preparation(with(scene, "irreducible/lanes", false)).structure);
  const Outcome one = run(scene, "lanes", false);
  for (const char* lanes : {"lanes", "lanes:2", "lanes:4", "lanes:8", "lanes:16"}) {
    SCOPED_TRACE(scene.name() + " " + lanes);
    const Outcome expected = small ? one : run(scene, lanes, false);
    for (const bool code : {true, false}) {
      SCOPED_TRACE(code ? "machine code" : "kernels");
      expect_same_bits(run(scene, lanes, code), expected);
    }
  }
  return small;
}

TEST(SameBits, EveryShippedMechanism) {
  int small = 0;
  for (const auto& file : test::shipped_files()) small += expect_same_bits(shortened(read_scene(file))) ? 1 : 0;
  EXPECT_GT(small, 10);
}

// In one class, tripods with legs that are almost parallel, whose linear solutions are refined, and others.
TEST(SameBits, WhereSomeLanesAreRefined) {
  SceneBuilder b("tripods", 3);
  int number = 0;
  for (const double apart : {0.5, 1e-2, 0.3, 2e-3}) {
    const std::string k = std::to_string(++number);
    const double x = 3.0 * number;
    b.fixed_point("P" + k, {x + apart, 0, 0}).fixed_point("Q" + k, {x, apart, 0}).point("C" + k, {x, 0, 0});
    b.point("T" + k, {x + 0.3, 0.2, 1});
    b.drive("x" + k, DrivenCoordinate{"C" + k + ".x", Law::harmonics({{0.1 * apart, 3, 0}}, x)});
    b.drive("y" + k, DrivenCoordinate{"C" + k + ".y", Law::harmonics({{0.1 * apart, 2, 0}})});
    b.drive("z" + k, DrivenCoordinate{"C" + k + ".z", Law::harmonics({{0.1 * apart, 1, 0}})});
    for (const std::string of : {"P", "Q", "C"}) b.constrain("leg" + of + k, Distance{of + k, "T" + k, std::nullopt});
  }
  const Scene scene = b.time(0, 0.2, 0.001).build();
  EXPECT_TRUE(expect_same_bits(scene));
  const Outcome lanes = run(scene, "lanes:4", true), eigen = run(scene, "eigen", false);
  for (const double residual : {lanes.report.error.velocity, lanes.report.error.acceleration}) {
    EXPECT_LE(residual, 8 * kEps);
    EXPECT_GT(residual, 2 * kEps);  // some solutions were close to the bound, so others were above
  }
  EXPECT_LE(test::difference(lanes.rows, eigen.rows), 1e-8);
}

// Also without instructions for fused products.
TEST(SameBits, EveryInstructionSet) {
  int sets = 0;
  for (const auto& file : test::shipped_files()) {
    const Scene scene = shortened(read_scene(file));
    const Outcome expected = run(scene, "lanes:8", true);
    sets = 0;
    for (std::int64_t left = hwy::SupportedTargets(); left != 0; left &= left - 1, ++sets) {
      SCOPED_TRACE(scene.name() + " " + hwy::TargetName(left & -left));
      hwy::SetSupportedTargetsForTest(left & -left);
      const Outcome found = run(scene, "lanes:8", false);
      hwy::SetSupportedTargetsForTest(0);
      EXPECT_TRUE(same_bits(found.rows.values(), expected.rows.values()));
      EXPECT_EQ(found.report.status.code, expected.report.status.code);
    }
    if (testing::Test::HasFailure()) return;
  }
  EXPECT_GT(sets, 0);
}

TEST(SameBits, ShippedMechanismsTogether) {
  int moved = 0;
  for (const auto& file : test::shipped_files()) {
    moved += expect_same_bits_together(shortened(read_scene(file))) ? 1 : 0;
  }
  EXPECT_GE(moved, 3);
}

TEST(SameBits, ChainsTogether) {
  for (const char* text : {"four_bar:1", "four_bar:7", "four_bar:64", "n_four_bar:40", "jansen:4",
                           "stewart:platforms=3", "slider_crank"}) {
    EXPECT_TRUE(expect_same_bits_together(shortened(sample(text)))) << text;
  }
  EXPECT_TRUE(expect_same_bits_together(test::tower(2, 11, 3)));
  EXPECT_TRUE(expect_same_bits_together(test::tower(3, 11, 1)));
}

TEST(SameBits, RandomMechanismsTogether) {
  test::Draw draw(11);
  const int count = test::random_count(60);
  int moved = 0;
  for (int i = 0; i < count; ++i) {
    const Scene scene = draw.maybe() ? test::planar_mechanism(draw) : test::spatial_mechanism(draw);
    moved += expect_same_bits_together(shortened(scene)) ? 1 : 0;
  }
  EXPECT_GT(moved, count / 4);
}

TEST(SameBits, RandomMechanisms) {
  test::Draw draw(9);
  const int count = test::random_count(60);
  int small = 0;
  for (int i = 0; i < count; ++i) {
    const Scene scene = draw.maybe() ? test::planar_mechanism(draw) : test::spatial_mechanism(draw);
    small += expect_same_bits(shortened(scene)) ? 1 : 0;
  }
  EXPECT_GE(2 * small, count);
}

// Wheels that turn each other, in the plane or about any axes, racks, and rods from wheels to slides. angles: of the
// wheels for 1 rad of the driven one
Scene random_wheels(test::Draw& draw, std::vector<std::pair<std::string, double>>& angles) {
  const bool in_space = draw.maybe();
  SceneBuilder b("wheels", in_space ? 3 : 2);
  angles = {{"J0", 1}};
  const auto revolute = [&](const std::string& wheel, double x) {
    const Triple axis = {draw.real(-1, 1), draw.real(-1, 1), draw.real(0.5, 1)};
    return in_space ? Revolute{"ground", wheel, Triple{x, 0, 0}, axis} : Revolute{"ground", wheel, Triple{x, 0}};
  };
  b.add(Body{.name = "w0"}).joint("J0", revolute("w0", 0));
  b.drive("motor", DrivenCoordinate{"J0.angle", Law::polynomial({draw.real(-1, 1), draw.real(-2, 2)}) +
                                                    Law::harmonics({{draw.real(0, 0.5), 1, draw.real(0, 3)}})});
  const std::size_t count = 2 + draw.below(5);
  for (std::size_t k = 1; k <= count; ++k) {
    const std::string number = std::to_string(k), wheel = "w" + number, joint = "J" + number;
    const auto& [other, angle] = angles[draw.below(angles.size())];
    const double ratio = (draw.maybe() ? 1.0 : -1.0) * double(3 + draw.below(8)) / double(3 + draw.below(8));
    const double x = 3 * double(k);
    b.add(Body{.name = wheel}).joint(joint, revolute(wheel, x));
    b.constrain("gear" + number, Gear{other + ".angle", joint + ".angle", ratio}).output(joint + ".angle");
    if (!in_space && draw.maybe()) {
      b.add(Body{.name = "rod" + number}).add(Body{.name = "slide" + number});
      b.joint("A" + number, Revolute{wheel, "rod" + number, Triple{x + 0.2, 0.1}});
      b.joint("B" + number, Revolute{"rod" + number, "slide" + number, Triple{x + 1.4, 0}});
      b.joint("C" + number, Prismatic{"ground", "slide" + number, Triple{1, 0}}).output("C" + number + ".displacement");
    } else if (!in_space && draw.maybe()) {
      b.add(Body{.name = "rack" + number});
      b.joint("R" + number, Prismatic{"ground", "rack" + number, Triple{0, 1}});
      b.constrain("teeth" + number, Gear{joint + ".angle", "R" + number + ".displacement", draw.real(0.05, 0.3)});
      b.output("R" + number + ".displacement");
    }
    angles.emplace_back(joint, ratio * angle);
  }
  return b.output("J0.angle").time(0, 1, 0.01).build();
}

TEST(SameBits, RandomWheels) {
  test::Draw draw(13);
  const int count = test::random_count(30);
  for (int i = 0; i < count; ++i) {
    SCOPED_TRACE(i);
    std::vector<std::pair<std::string, double>> angles;
    const Scene scene = random_wheels(draw, angles);
    (void)expect_same_bits(scene);
    for (const char* solver : {"lanes", "klu"}) {
      const Trajectory t = run(scene, solver, true).rows;
      ASSERT_EQ(t.rows(), 101u);
      const std::size_t driven = t.index("J0.angle");
      for (const auto& [joint, angle] : angles) {
        const std::size_t column = t.index(joint + ".angle");
        for (std::size_t k = 0; k < t.rows(); ++k) {
          for (std::size_t d = 0; d < 3; ++d) {  // columns of value, rate and acceleration are neighbours
            const double wanted = angle * (t(k, driven + d) - (d == 0 ? t(0, driven) : 0));
            const double found = t(k, column + d) - (d == 0 ? t(0, column) : 0);
            ASSERT_NEAR(found, wanted, 1e-11 * (1 + std::abs(wanted))) << joint << ' ' << k << ' ' << d;
          }
        }
      }
    }
  }
}

// Each gear is a class of its own. There is no time for the code of all of them; the others take kernels.
TEST(SameBits, WhereTheTimeForCodeEnds) {
  constexpr int kWheels = 300;
  SceneBuilder b("wheels", 2);
  b.add(Body{.name = "w0"}).joint("J0", Revolute{"ground", "w0", Triple{0, 0}});
  for (int k = 1; k <= kWheels; ++k) {
    const std::string number = std::to_string(k), wheel = "w" + number, joint = "J" + number;
    b.add(Body{.name = wheel}).joint(joint, Revolute{"ground", wheel, Triple{double(k), 0}});
    b.constrain("gear" + number, Gear{"J0.angle", joint + ".angle", (300.0 + k) / 299}).output(joint + ".angle");
  }
  b.drive("motor", DrivenCoordinate{"J0.angle", Law::polynomial({0, 1})}).time(0, 0.2, 0.01);
  const Scene scene = b.build();
  const Prepared prepared = with(scene, "irreducible/lanes", true);
  EXPECT_EQ(preparation(prepared).structure->classes.size(), kWheels);
  Simulator by_code(prepared);
  if (preparation(prepared).code) {
    // "AVX2, 18 of 300 groups"; later simulators find the code of earlier ones and make more.
    EXPECT_NE(by_code.machine_code().find(" of 300 groups"), std::string::npos) << by_code.machine_code();
  }
  const Trajectory found = by_code.run(), expected = run(scene, "lanes", false).rows;
  EXPECT_TRUE(same_bits(found.values(), expected.values()));
  for (int k = 1; k <= kWheels; ++k) {
    EXPECT_NEAR(found.last("J" + std::to_string(k) + ".angle"), 0.2 * (300.0 + k) / 299, 1e-14);
  }
}

// Members with other lengths, in tiles with each other and alone. Tiles that a member leaves are not compared: where a
// step must be divided, it goes on without its earlier postures.
TEST(SameBits, MembersOfTiles) {
  constexpr std::size_t kMembers = 16;
  test::Draw draw(4);
  int served = 0;
  for (const auto& file : test::shipped_files()) {
    const Scene scene = read_scene(file);
    if (!only_small_groups(*preparation(with(scene, "irreducible/lanes", true)).structure)) continue;
    SCOPED_TRACE(file.string());
    std::vector<Scene> members;
    for (std::size_t m = 0; m < kMembers; ++m) {
      Parameters values;
      for (const Constraint& c : scene.constraints()) {
        const auto* distance = std::get_if<Distance>(&c.kind);
        if (distance != nullptr && distance->value) values[c.name] = *distance->value * draw.real(0.998, 1.002);
      }
      members.push_back(shortened(scene).with_values(values));
    }
    for (const char* lanes : {"lanes:4", "lanes:8", "lanes:16"}) {
      SCOPED_TRACE(lanes);
      const std::string strategy = std::string("irreducible/") + lanes;
      Ensemble tiles(kMembers, [&](std::size_t m) { return with(members[m], strategy, true); });
      const EnsembleTrajectory together = tiles.run();
      const auto& outcomes = tiles.outcomes();
      if (std::any_of(outcomes.begin(), outcomes.end(), [](const auto& o) { return o.alone; })) continue;
      ++served;
      for (std::size_t m = 0; m < kMembers; ++m) {
        const Trajectory alone = Simulator(with(members[m], "irreducible/lanes", false)).run();
        ASSERT_EQ(together.rows(m), alone.rows());
        EXPECT_TRUE(same_bits({together.row(m, 0).data(), alone.values().size()}, alone.values())) << "member " << m;
      }
    }
  }
  EXPECT_GT(served, 30);
}

}  // namespace
}  // namespace assur
