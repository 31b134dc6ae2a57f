// Angles and gears in lanes and as programs, against the C library and against gears as functions.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "evaluation/angles-inl.hpp"
#include "evaluation/evaluator.hpp"
#include "executors/executors.hpp"
#include "index.hpp"
#include "numbers.hpp"
#include "program/step_graph.hpp"
#include "source_dir.hpp"
#include "structure/look.hpp"

namespace assur {
namespace {

// Distance of x from y in units of the last place of y.
double ulps(double x, long double y) {
  const double size = std::abs(static_cast<double>(y));
  const double unit = std::nextafter(size, kInfinity) - size;
  return static_cast<double>(std::abs(static_cast<long double>(x) - y) / static_cast<long double>(unit));
}

TEST(Angles, OfDirectionsAreRoundedAsSaid) {
  Graph g;
  const Slot y{Memory::work, 0}, x{Memory::work, 1}, angle{Memory::work, 2};
  g.store(angle, HWY_NAMESPACE::angle_of(g.load(y), g.load(x)));
  std::array<std::size_t, kMemories> sizes{};
  sizes[static_cast<std::size_t>(Memory::work)] = 3;
  const auto executors = test::executors_of({{g.phase()}}, {8});
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> any(-1, 1), exponent(-40, 40);
  double most = 0;
  for (int round = 0; round < 20'000; ++round) {
    double given[2][8];
    for (std::size_t l = 0; l < 8; ++l) {
      given[0][l] = any(random), given[1][l] = any(random);
      if (round % 3 == 1) given[0][l] *= std::exp2(exponent(random));
      if (round % 3 == 2) given[0][l] = given[1][l] * (1 + 1e-3 * any(random)) * (l % 2 == 0 ? 0.5 : -1);
    }
    if (round == 0) {
      const double axes[2][8] = {{0, 1, 0, -1, 1, 1, -1, -1}, {1, 0, -1, 0, 1, -1, -1, 1}};
      std::copy_n(&axes[0][0], 16, &given[0][0]);
    }
    std::vector<double> first;
    for (const test::NamedExecutor& e : executors) {
      test::StepMemory memory(sizes, 8);
      std::copy_n(&given[0][0], 16, memory.at[static_cast<std::size_t>(Memory::work)]);
      e.executor->run(memory.at);
      std::vector<double> found;
      for (std::size_t l = 0; l < 8; ++l) found.push_back(memory(angle, l));
      if (first.empty()) {
        first = found;
        for (std::size_t l = 0; l < 8; ++l) {
          most = std::max(most, ulps(found[l], std::atan2(static_cast<long double>(given[0][l]),
                                                          static_cast<long double>(given[1][l]))));
        }
      }
      ASSERT_EQ(found, first) << e.name;
    }
  }
  EXPECT_LE(most, 1) << "units in the last place";
  test::StepMemory memory(sizes, 8);  // no direction
  executors[0].executor->run(memory.at);
  EXPECT_TRUE(std::isnan(memory(angle, 0)));
}

Law turning(double speed) { return Law::polynomial({0.1, speed}); }

Scene bevel() {
  return SceneBuilder("bevel gears", 3)
      .add(Body{.name = "first"})
      .add(Body{.name = "second"})
      .joint("A", Revolute{"ground", "first", Triple{0, 0, 0}, Triple{0, 0, 1}})
      .joint("B", Revolute{"ground", "second", Triple{0, 0, 0}, Triple{1, 0.2, 0.5}})
      .constrain("gear", Gear{"A.angle", "B.angle", 3.0 / 2})
      .drive("motor", DrivenCoordinate{"A.angle", turning(3)})
      .time(0, 1, 0.01)
      .build();
}

Scene rack() {
  return SceneBuilder("rack", 2)
      .add(Body{.name = "pinion"})
      .add(Body{.name = "rack"})
      .joint("A", Revolute{"ground", "pinion", Triple{0, 0}})
      .joint("S", Prismatic{"ground", "rack", Triple{1, 0}})
      .constrain("gear", Gear{"S.displacement", "A.angle", 1 / 37.0})
      .drive("cylinder", DrivenCoordinate{"S.displacement", turning(300)})
      .time(0, 1, 0.01)
      .build();
}

Scene racks() {
  return SceneBuilder("two racks", 2)
      .add(Body{.name = "a"})
      .add(Body{.name = "b"})
      .joint("S", Prismatic{"ground", "a", Triple{1, 0}})
      .joint("T", Prismatic{"ground", "b", Triple{0, 1}})
      .constrain("gear", Gear{"S.displacement", "T.displacement", 0.37})
      .drive("cylinder", DrivenCoordinate{"S.displacement", turning(3)})
      .time(0, 1, 0.01)
      .build();
}

// What an evaluator gives at random postures near the start, with random rates and changes.
std::vector<std::vector<double>> results(const GroupedSystem& s, const SolvedGroup& g, const GroupClass& c) {
  constexpr std::size_t w = 4;
  const auto evaluator = make_evaluator(*s.system, c, w);
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> any(-1, 1);
  const auto numbers = [&](std::size_t count) {
    std::vector<double> out(count * w);
    for (double& x : out) x = any(random);
    return out;
  };
  std::vector<double> constants, k((idx(one_coefficient(c)) + 1) * w, 1.0), x, h;
  for (const Index i : g.constants) constants.insert(constants.end(), w, s.system->constants[idx(i)]);
  bind_coefficients(c, constants.data(), k.data(), w);
  for (const Index i : g.inputs) h.insert(h.end(), w, s.start[idx(i)]);
  for (const Index i : g.unknowns) {
    for (std::size_t l = 0; l < w; ++l) x.push_back(s.start[idx(i)] + 0.05 * any(random));
  }
  const std::size_t n = g.unknowns.size(), m = g.inputs.size();
  std::vector<double> phi(n * w), j(idx(c.pattern.nnz()) * w), scale(n * w), least(n * w, 0.0), rounding(n * w);
  evaluator->set_inputs(k.data(), h.data());
  evaluator->evaluate(x.data(), phi.data(), j.data());
  evaluator->scale(scale.data());
  evaluator->raise_scale(least.data());
  evaluator->rounding(rounding.data());
  std::vector<double> a = numbers(n), a_in = numbers(m), b = numbers(n), b_in = numbers(m), bent(n * w), bend(n * w);
  const std::vector<double> rates = numbers(n), rates_in = numbers(m), accelerations_in = numbers(m);
  evaluator->subtract_bend({a.data(), a_in.data()}, {b.data(), b_in.data()}, 0.7, bent.data(), bend.data());
  std::vector<double> velocity(n * w), acceleration(n * w);
  evaluator->velocity_rhs(rates_in.data(), velocity.data());
  evaluator->acceleration_rhs(rates.data(), accelerations_in.data(), acceleration.data());
  return {phi, j, scale, least, rounding, bend, velocity, acceleration};
}
constexpr std::size_t kPhi = 0, kScale = 2, kRounding = 4;  // among them

TEST(GearRows, AreTheFunctionsOfGears) {
  for (const Scene& scene : {read_scene(ASSUR_SOURCE_DIR "/scenes/geared_five_bar.json"), bevel(), rack(), racks()}) {
    const GroupedSystem s = look::structure(scene, Formulation::groups);
    bool any = false;
    for (const SolvedGroup& g : s.groups) {
      const GroupClass& c = look::class_of(s, g);
      if (c.gears.empty()) continue;
      any = true;
      GroupClass by_functions = c;
      by_functions.gears.clear();
      by_functions.gear_entries.clear();
      by_functions.gear_arguments = by_functions.gear_angles = 0;
      for (std::size_t i = 0; i < c.equations.size(); ++i) {
        const Index gear = std::exchange(by_functions.equations[i].gear, -1);
        if (gear < 0) continue;
        const auto use = static_cast<Index>(by_functions.callbacks.size());
        by_functions.callbacks.push_back({s.system->equations[idx(g.equations[i])].callback,
                                          {{static_cast<Index>(i), 0}},
                                          c.gears[idx(gear)].arguments});
        for (const GroupClass::GearEntry& e : c.gear_entries) {
          if (e.gear == gear) by_functions.callback_entries.push_back({e.nonzero, use, 0, e.argument, e.coefficient});
        }
      }
      const auto found = results(s, g, c), expected = results(s, g, by_functions);
      for (std::size_t i = 0; i < found[kPhi].size(); ++i) {
        // Both residuals are rounded; the scales of functions differ, and may vanish.
        EXPECT_LE(std::abs(found[kPhi][i] - expected[kPhi][i]), found[kRounding][i] * kEps) << scene.name() << ' ' << i;
        EXPECT_GT(found[kScale][i], 0) << scene.name() << ' ' << i;
        EXPECT_LE(found[kRounding][i], 16 * found[kScale][i]) << scene.name() << ' ' << i;
      }
      for (std::size_t k = kPhi + 1; k < found.size(); ++k) {
        if (k == kScale || k == kRounding) continue;
        for (std::size_t i = 0; i < found[k].size(); ++i) {
          const double wanted = expected[k][i];
          EXPECT_NEAR(found[k][i], wanted, 256 * kEps * (1 + std::abs(wanted))) << scene.name() << ' ' << k << ' ' << i;
        }
      }
    }
    EXPECT_TRUE(any) << scene.name();
  }
}

// Equal gears have one class, so that one pack solves them.
TEST(GearRows, ShareTheirClass) {
  SceneBuilder b("wheels", 2);
  b.add(Body{.name = "w0"}).joint("J0", Revolute{"ground", "w0", Triple{0, 0}});
  for (int k = 1; k <= 4; ++k) {
    const std::string wheel = "w" + std::to_string(k), joint = "J" + std::to_string(k);
    b.add(Body{.name = wheel}).joint(joint, Revolute{"ground", wheel, Triple{double(k), 0}});
    b.constrain("gear" + std::to_string(k), Gear{"J0.angle", joint + ".angle", k == 4 ? 3.0 : -2.0});
  }
  b.drive("motor", DrivenCoordinate{"J0.angle", turning(1)}).time(0, 1, 0.1);
  const GroupedSystem s = look::structure(b.build(), Formulation::irreducible);
  std::vector<std::int32_t> of;
  for (const SolvedGroup& g : s.groups) {
    if (!look::class_of(s, g).gears.empty()) of.push_back(g.group_class);
  }
  std::sort(of.begin(), of.end());
  ASSERT_EQ(of.size(), 4u);
  EXPECT_EQ(std::unique(of.begin(), of.end()) - of.begin(), 2);
}

}  // namespace
}  // namespace assur
