// Ways to the start that lanes follow side by side, beside those that mechanisms follow alone.
#include "tables/walk_in_lanes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "assur/assur.hpp"
#include "equations/lowering.hpp"
#include "equations/own_values.hpp"
#include "executors/step_code.hpp"
#include "graph/blocks.hpp"
#include "index.hpp"
#include "properties/small_random_scenes.hpp"
#include "start/walk_path.hpp"

namespace assur {
namespace {

constexpr int kLanes = 8;

// A mechanism as prepare() assembles it: its equations before presolve, and its posture as written, from which the laws
// are away at the start time.
struct Case {
  Case(const Scene& scene, double start) : system(lower(std::make_shared<const Scene>(scene))) {
    std::vector<Index> unknowns, equations, mentioned;
    const auto is_unknown = [&](Index c) {
      return system.coordinates[static_cast<std::size_t>(c)].role == Role::unknown;
    };
    for (Index c = 0; c < std::ssize(system.coordinates); ++c) {
      if (is_unknown(c)) unknowns.push_back(c);
    }
    for (Index e = 0; e < std::ssize(system.equations); ++e) {
      system.mentioned(e, mentioned);
      if (std::any_of(mentioned.begin(), mentioned.end(), is_unknown)) equations.push_back(e);
    }
    const Blocks blocks = decompose(system, equations, unknowns);
    for (Index b = 0; b < blocks.size(); ++b) {
      const auto own = blocks.equations_of(b), solved = blocks.unknowns_of(b);
      parts.push_back({{own.begin(), own.end()}, {solved.begin(), solved.end()}});
    }
    q = system.guess;
    EXPECT_TRUE(drive(system, start, q.data(), nullptr, nullptr).ok());
    way = way_to_laws(system, q, start);
    drive_by_values(system, way.from, q);
  }

  System system;
  std::vector<WalkedPart> parts;
  WalkPath way;
  std::vector<double> q;  // as written
};

DriverValues at(const WalkPath& way, double share) {
  DriverValues out = way.from;
  for (std::size_t i = 0; i < out.size(); ++i) {
    for (std::size_t k = 0; k < out[i].size(); ++k) out[i][k] += share * way.change[i][k];
  }
  return out;
}

// True if the systems differ in numbers only.
bool alike(const System& a, const System& b) {
  const auto same_term = [](const Term& x, const Term& y) {
    return x.coordinate == y.coordinate && x.constant == y.constant;
  };
  const auto same_product = [](const Product& x, const Product& y) {
    return x.a == y.a && x.b == y.b && x.constant == y.constant;
  };
  return a.constants.size() == b.constants.size() && a.length_exponent == b.length_exponent &&
         std::equal(a.terms.begin(), a.terms.end(), b.terms.begin(), b.terms.end(), same_term) &&
         std::equal(a.products.begin(), a.products.end(), b.products.begin(), b.products.end(), same_product);
}

// The drivers of mechanisms in lanes.
struct Drivers final : WalkInLanes::Drivers {
  explicit Drivers(std::span<const Case> of) : cases(of) {}
  void move(std::size_t lane, double before, double share, std::vector<double>& q,
            std::vector<double>& strays) override {
    const Case& c = cases[lane];
    set_strays(c.system, c.way, share - before, strays);
    drive_by_values(c.system, at(c.way, share), q);
  }
  bool hold(std::size_t lane, const std::vector<double>& q) override {
    return drivers_hold(cases[lane].system, cases[lane].way, q);
  }

  std::span<const Case> cases;
};

// Where a mechanism is at its start, by two walks of its own; empty if one of them does not arrive.
std::vector<double> walked(const Case& c) {
  std::vector<double> q = c.q;
  if (walk(c.system, c.parts, closing_way(c.system, c.parts, q), q).end != Walked::End::arrived) return {};
  if (walk(c.system, c.parts, c.way, q).end != Walked::End::arrived) return {};
  return q;
}

void follow(WalkInLanes& lanes, std::span<const Case> cases) {
  for (std::size_t i = 0; i < cases.size(); ++i) lanes.set(i, cases[i].system, cases[i].q, true);
  Drivers drivers(cases);
  lanes.run(drivers);
}

struct Compared {
  int arrived = 0, arrived_alone = 0;
};

// Follows all cases side by side, and each one alone. Those that arrive side by side are where they arrive alone.
Compared compare(const std::vector<Case>& cases) {
  Compared out;
  std::vector<std::vector<double>> alone;
  for (const Case& c : cases) {
    alone.push_back(walked(c));
    out.arrived_alone += alone.back().empty() ? 0 : 1;
  }
  const auto first = std::find_if(alone.begin(), alone.end(), [](const auto& q) { return !q.empty(); });
  if (first == alone.end()) return out;
  const Case& of = cases[static_cast<std::size_t>(first - alone.begin())];
  const auto lanes = WalkInLanes::make(of.system, of.parts, *first, kLanes, nullptr);
  if (!lanes) {
    ADD_FAILURE() << "there are no lanes";
    return out;
  }
  follow(*lanes, cases);
  for (std::size_t i = 0; i < cases.size(); ++i) {
    if (!lanes->arrived(i)) continue;
    ++out.arrived;
    if (alone[i].empty()) {
      ADD_FAILURE() << "mechanism " << i << " does not arrive alone";
      continue;
    }
    for (const WalkedPart& p : cases[i].parts) {
      for (const Index u : p.unknowns) {
        EXPECT_NEAR(lanes->at(idx(u), i), alone[i][idx(u)], 1e-11)
            << "mechanism " << i << ", " << cases[i].system.coordinate_name(u);
      }
    }
  }
  return out;
}

Scene four_bar(test::Draw& draw, double turn) {
  const double crank = draw.real(0.8, 1.2), angle = draw.real(0.2, 1);
  return SceneBuilder("four_bar", 2)
      .fixed_point("A", {0, 0})
      .fixed_point("D", {3, 0})
      .point("B", {crank * std::cos(angle), crank * std::sin(angle)})
      .point("C", {2.5, 2.4})
      .constrain("crank", Distance{"A", "B", crank})
      .constrain("coupler", Distance{"B", "C", draw.real(2.7, 3.3)})
      .constrain("rocker", Distance{"D", "C", draw.real(2.2, 2.8)})
      .drive("motor", RelativeAngle{{"A", "D"}, {"A", "B"}, "", Law::constant(angle + turn)})
      .time(0, 1, 0.5)
      .build();
}

TEST(WalkInLanes, EndsWhereEachMechanismEndsAlone) {
  test::Draw draw(1);
  for (const double most : {0.2, 2.5}) {
    SCOPED_TRACE(most);
    int arrived = 0, alone = 0;
    for (int round = 0; round < 40; ++round) {
      std::vector<Case> cases;
      for (int i = 0; i < kLanes; ++i) cases.emplace_back(four_bar(draw, draw.real(-most, most)), 0);
      const Compared both = compare(cases);
      arrived += both.arrived;
      alone += both.arrived_alone;
    }
    EXPECT_GT(alone, 40 * kLanes * 3 / 4);
    EXPECT_GE(arrived, alone * 0.9);
  }
}

TEST(WalkInLanes, FollowsRandomMechanisms) {
  int mechanisms = 0, arrived = 0, alone = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    for (const bool in_space : {false, true}) {
      SCOPED_TRACE("seed " + std::to_string(seed) + (in_space ? ", in space" : ", in the plane"));
      const double start = 0.3 + 0.1 * static_cast<double>(seed);
      std::vector<Case> cases;
      for (std::uint64_t i = 0; i < kLanes; ++i) {
        test::Draw draw(seed, 0.02, i);
        cases.emplace_back(in_space ? test::spatial_mechanism(draw) : test::planar_mechanism(draw), start);
        if (!alike(cases[i].system, cases[0].system)) {
          cases.pop_back();
          break;
        }
      }
      if (cases.size() < kLanes) continue;
      const Compared both = compare(cases);
      mechanisms += kLanes;
      arrived += both.arrived;
      alone += both.arrived_alone;
    }
  }
  EXPECT_GE(mechanisms, 400);
  EXPECT_GE(alone, mechanisms / 2);
  EXPECT_GE(arrived, alone * 0.9);
}

// The crank of one mechanism cannot turn so far; the others arrive.
TEST(WalkInLanes, LeavesAMechanismThatMeetsAFold) {
  test::Draw draw(2);
  std::vector<Case> cases;
  for (int i = 0; i < kLanes; ++i) cases.emplace_back(four_bar(draw, 0.5), 0);
  cases[3] = Case(SceneBuilder("four_bar", 2)
                      .fixed_point("A", {0, 0})
                      .fixed_point("D", {3, 0})
                      .point("B", {1.1, 0})
                      .point("C", {2, 1})
                      .constrain("crank", Distance{"A", "B", 1.1})
                      .constrain("coupler", Distance{"B", "C", 1.4})
                      .constrain("rocker", Distance{"D", "C", 1.5})
                      .drive("motor", RelativeAngle{{"A", "D"}, {"A", "B"}, "", Law::constant(2.5)})
                      .time(0, 1, 0.5)
                      .build(),
                  0);
  EXPECT_TRUE(walked(cases[3]).empty());
  const Compared both = compare(cases);
  EXPECT_EQ(both.arrived, kLanes - 1);
  EXPECT_EQ(both.arrived_alone, kLanes - 1);
}

TEST(WalkInLanes, BitsDependOnNothingElse) {
  test::Draw draw(4);
  std::vector<Case> cases;
  for (int i = 0; i < 16; ++i) cases.emplace_back(four_bar(draw, draw.real(-1.5, 1.5)), 0);
  const std::vector<double> first = walked(cases[0]);
  const auto code = step_code();
  std::vector<std::vector<double>> expected(16);
  for (const std::size_t w : {16u, 8u, 4u, 2u, 1u}) {
    for (StepCode* const by : {static_cast<StepCode*>(nullptr), code.get()}) {
      const auto lanes = WalkInLanes::make(cases[0].system, cases[0].parts, first, static_cast<int>(w), by);
      ASSERT_TRUE(lanes);
      for (std::size_t i = 0; i < 16; i += w) {
        follow(*lanes, std::span(cases).subspan(i, w));
        for (std::size_t l = 0; l < w; ++l) {
          std::vector<double> q = {lanes->arrived(l) ? 1.0 : 0.0};
          for (std::size_t c = 0; c < first.size(); ++c) q.push_back(lanes->at(c, l));
          if (expected[i + l].empty()) expected[i + l] = q;
          EXPECT_EQ(q, expected[i + l]) << "mechanism " << i + l << " in " << w << " lanes";
        }
      }
    }
  }
}

}  // namespace
}  // namespace assur
