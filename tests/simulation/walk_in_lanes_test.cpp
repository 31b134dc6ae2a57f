// Ways to the start that lanes follow side by side, beside those that mechanisms follow alone.
#include "side_by_side/walk_in_lanes.hpp"

#include "side_by_side/close_in_lanes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "assur/assur.hpp"
#include "execute/step_code.hpp"
#include "index.hpp"
#include "scene/lowering.hpp"
#include "scene/own_values.hpp"
#include "simulation/random_mechanisms.hpp"
#include "structure/blocks.hpp"
#include "structure/way.hpp"

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
  Way way;
  std::vector<double> q;  // as written
};

DriverValues at_end(const Way& way) {
  DriverValues out = way.from;
  for (std::size_t i = 0; i < out.size(); ++i) {
    for (std::size_t k = 0; k < out[i].size(); ++k) out[i][k] += way.change[i][k];
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

struct Compared {
  int arrived = 0, arrived_alone = 0;
};

// Walks all cases side by side, and each one alone. Those that arrive side by side are then at the end of their way.
Compared compare(std::vector<Case>& cases, WalkInLanes& lanes, bool closes) {
  Compared out;
  lanes.clear();
  std::vector<Way> ways;
  for (Case& c : cases) {
    ways.push_back(closes ? closing_way(c.system, c.parts, c.q) : c.way);
    lanes.add(c.system, ways.back(), c.q);
  }
  lanes.run();
  for (std::size_t i = 0; i < cases.size(); ++i) {
    Case& c = cases[i];
    std::vector<double> q = c.q;
    const bool alone = walk(c.system, c.parts, ways[i], q).end == Walked::End::arrived;
    out.arrived_alone += alone ? 1 : 0;
    if (!lanes.arrived(i)) continue;
    ++out.arrived;
    EXPECT_TRUE(alone) << "mechanism " << i;
    for (const WalkedPart& p : c.parts) {
      for (const Index u : p.unknowns) {
        const auto k = static_cast<std::size_t>(u);
        EXPECT_NEAR(lanes.posture(i)[k], q[k], 1e-11) << "mechanism " << i << ", " << c.system.coordinate_name(u);
      }
    }
    c.q = q;
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
  int arrived = 0, alone = 0;
  for (int round = 0; round < 40; ++round) {
    std::vector<Case> cases;
    for (int i = 0; i < kLanes; ++i) cases.emplace_back(four_bar(draw, draw.real(-2.5, 2.5)), 0);
    WalkInLanes lanes(cases[0].system, cases[0].parts, kLanes);
    const Compared closing = compare(cases, lanes, true);
    EXPECT_EQ(closing.arrived, kLanes);
    const Compared moving = compare(cases, lanes, false);
    arrived += moving.arrived;
    alone += moving.arrived_alone;
  }
  EXPECT_GT(alone, 40 * kLanes * 3 / 4);
  EXPECT_GE(arrived, alone * 0.9);
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
      WalkInLanes lanes(cases[0].system, cases[0].parts, kLanes);
      EXPECT_EQ(compare(cases, lanes, true).arrived, kLanes);
      const Compared moving = compare(cases, lanes, false);
      mechanisms += kLanes;
      arrived += moving.arrived;
      alone += moving.arrived_alone;
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
  WalkInLanes lanes(cases[0].system, cases[0].parts, kLanes);
  EXPECT_EQ(compare(cases, lanes, true).arrived, kLanes);
  const Compared moving = compare(cases, lanes, false);
  EXPECT_EQ(moving.arrived, kLanes - 1);
  EXPECT_EQ(moving.arrived_alone, kLanes - 1);
  EXPECT_FALSE(lanes.arrived(3));
}

// Where each mechanism is at its start, by two walks of its own; empty if one of them does not arrive.
std::vector<double> walked(const Case& c) {
  std::vector<double> q = c.q;
  if (walk(c.system, c.parts, closing_way(c.system, c.parts, q), q).end != Walked::End::arrived) return {};
  if (walk(c.system, c.parts, c.way, q).end != Walked::End::arrived) return {};
  return q;
}

void set(CloseInLanes& lanes, std::size_t lane, const Case& c) {
  std::vector<double> end = c.q, strays(c.q.size());
  drive_by_values(c.system, at_end(c.way), end);
  set_strays(c.system, c.way, 1, strays);
  lanes.set(lane, c.system, c.q);
  lanes.move(lane, end, strays);
}

// Every start that is proven is that of the walks. Returns the number of proofs.
int expect_proven_starts_of_walks(const std::vector<Case>& cases) {
  const std::vector<double> first = walked(cases[0]);
  if (first.empty()) return 0;
  const std::unique_ptr<CloseInLanes> lanes =
      CloseInLanes::make(cases[0].system, cases[0].parts, first, kLanes, nullptr);
  if (!lanes) return 0;
  for (std::size_t i = 0; i < cases.size(); ++i) set(*lanes, i, cases[i]);
  lanes->run();
  int proven = 0;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    if (!lanes->has_arrived(i)) continue;
    ++proven;
    const std::vector<double> q = walked(cases[i]);
    if (q.empty()) {
      ADD_FAILURE() << "mechanism " << i << " does not arrive alone";
      continue;
    }
    for (const WalkedPart& p : cases[i].parts) {
      for (const Index u : p.unknowns) {
        EXPECT_NEAR(lanes->at(idx(u), i), q[idx(u)], 1e-10)
            << "mechanism " << i << ", " << cases[i].system.coordinate_name(u);
      }
    }
  }
  return proven;
}

TEST(CloseInLanes, ProvesStartsOfWalksOnly) {
  test::Draw draw(3);
  int near = 0, far = 0;
  for (int round = 0; round < 60; ++round) {
    for (const double most : {0.2, 2.5}) {
      std::vector<Case> cases;
      for (int i = 0; i < kLanes; ++i) cases.emplace_back(four_bar(draw, draw.real(-most, most)), 0);
      (most < 1 ? near : far) += expect_proven_starts_of_walks(cases);
    }
  }
  EXPECT_GE(near, 60 * kLanes / 4);
  EXPECT_LT(far, near);
}

TEST(CloseInLanes, ProvesStartsOfRandomMechanisms) {
  int proven = 0, mechanisms = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    for (const bool in_space : {false, true}) {
      SCOPED_TRACE("seed " + std::to_string(seed) + (in_space ? ", in space" : ", in the plane"));
      std::vector<Case> cases;
      for (std::uint64_t i = 0; i < kLanes; ++i) {
        test::Draw draw(seed, 0.02, i);
        cases.emplace_back(in_space ? test::spatial_mechanism(draw) : test::planar_mechanism(draw), 0.02);
        if (!alike(cases[i].system, cases[0].system)) {
          cases.pop_back();
          break;
        }
      }
      if (cases.size() < kLanes) continue;
      mechanisms += kLanes;
      proven += expect_proven_starts_of_walks(cases);
    }
  }
  EXPECT_GE(mechanisms, 400);
  EXPECT_GE(proven, mechanisms / 4);
}

TEST(CloseInLanes, BitsDependOnNothingElse) {
  test::Draw draw(4);
  std::vector<Case> cases;
  for (int i = 0; i < 16; ++i) cases.emplace_back(four_bar(draw, draw.real(-0.1, 0.1)), 0);
  const std::vector<double> first = walked(cases[0]);
  const auto code = step_code();
  std::vector<std::vector<double>> expected(16);
  for (const int w : {16, 8, 4, 2, 1}) {
    for (StepCode* const by : {static_cast<StepCode*>(nullptr), code.get()}) {
      const auto lanes = CloseInLanes::make(cases[0].system, cases[0].parts, first, w, by);
      ASSERT_TRUE(lanes);
      for (std::size_t i = 0; i < 16; i += idx(w)) {
        for (std::size_t l = 0; l < idx(w); ++l) set(*lanes, l, cases[i + l]);
        lanes->run();
        for (std::size_t l = 0; l < idx(w); ++l) {
          std::vector<double> q = {lanes->has_arrived(l) ? 1.0 : 0.0};
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
