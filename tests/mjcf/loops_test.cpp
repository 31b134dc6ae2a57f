// The models of scenes/mjcf: their loops close to 1e-12 at every step of 200 random motions, by the forward kinematics
// of their trees, which are written here a second time.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "assur/mjcf.hpp"
#include "mjcf/tree.hpp"
#include "simulation/run.hpp"
#include "source_dir.hpp"

namespace assur {
namespace {

using test::cross;
using test::dot;
using test::kNoTurn;
using test::M3;
using test::norm;
using test::Tree;
using test::turn;
using test::V3;
using Poses = std::vector<Tree::Pose>;

constexpr double kDegree = std::numbers::pi / 180;
constexpr V3 kX = {1, 0, 0}, kY = {0, 1, 0}, kZ = {0, 0, 1}, kO = {0, 0, 0};

// The position of a site in one row, by its name.
using Place = std::function<V3(const std::string&)>;

struct Case {
  std::string name;
  Tree tree;
  std::vector<std::pair<std::string, double>> reach;  // driven joints, with the largest way to either side
  // Distances that must be 0: the gaps of loops, and from sites to their places in the tree.
  std::function<std::vector<double>(const Poses&, const Place&)> gaps;

  friend void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }
};

Case four_bar() {
  const V3 axis = {0, -1, 0};
  Case c{"four_bar", {}, {{"shaft", 3.1}}, {}};
  const int crank = c.tree.add(0, kO, kNoTurn, {{"shaft", false, kO, axis}});
  const int coupler =
      c.tree.add(crank, {0.1, 0, 0}, turn(kY, -53.13010235415598 * kDegree), {{"elbow", false, kO, axis}});
  const int rocker = c.tree.add(0, {0.3, 0, 0}, kNoTurn, {{"swing", false, kO, axis}});
  const Poses first = c.tree.poses({});
  const V3 tip = {0.3, 0, 0}, on_rocker = first[static_cast<std::size_t>(coupler)](tip) - V3{0.3, 0, 0};
  c.gaps = [=](const Poses& p, const Place& site) -> std::vector<double> {
    const Tree::Pose &k = p[static_cast<std::size_t>(coupler)], &r = p[static_cast<std::size_t>(rocker)];
    return {norm(k(tip) - r(on_rocker)), norm(site("pen") - k({0.15, 0, 0.05})), norm(site("tip") - k(tip)),
            norm(site("rocker_tip") - r({-0.02, 0, 0.24}))};
  };
  return c;
}

Case five_bar() {
  Case c{"five_bar", {}, {{"left", 0.4}, {"right", 0.4}}, {}};
  const int left = c.tree.add(0, {-0.1, 0, 0}, turn(kZ, 2.0943951023931953), {{"left", false, kO, kZ}});
  const int rod1 = c.tree.add(left, {0.2, 0, 0}, turn(kZ, -1.3), {{"left_elbow", false, {0, 0, 0.02}, kZ}});
  const int right = c.tree.add(0, {0.1, 0, 0}, turn(kZ, 1.0471975511965976), {{"right", false, kO, kZ}});
  const int rod2 = c.tree.add(right, {0.2, 0, 0}, turn(kZ, 1.3), {{"right_elbow", false, kO, kZ}});
  c.gaps = [=](const Poses& p, const Place& site) -> std::vector<double> {
    const V3 pen = p[static_cast<std::size_t>(rod1)]({0.3, 0, 0}), end = p[static_cast<std::size_t>(rod2)]({0.3, 0, 0});
    return {norm(pen - end), norm(site("pen") - pen), norm(site("end") - end)};
  };
  return c;
}

// Largest change of a distance between two sites of a body, from the local places of the sites.
double change_of_shape(const std::vector<V3>& now, const std::vector<V3>& local) {
  double worst = 0;
  for (std::size_t i = 0; i < now.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      worst = std::max(worst, std::abs(norm(now[i] - now[k]) - norm(local[i] - local[k])));
    }
  }
  return worst;
}

Case delta() {
  Case c{"delta", {}, {{"shoulder_a", 0.4}, {"shoulder_b", 0.4}, {"shoulder_c", 0.4}}, {}};
  struct Rod {
    int body;
    std::string tip, ball;
  };
  std::vector<Rod> rods;
  std::vector<V3> local = {{0, 0, -0.02}};
  for (int leg = 0; leg < 3; ++leg) {
    const std::string n(1, static_cast<char>('a' + leg));
    const M3 mount = turn(kZ, 120 * leg * kDegree);
    const int arm = c.tree.add(0, mount * V3{0.1, 0, 0}, mount, {{"shoulder_" + n, false, kO, kY}});
    for (const auto& [side, y] : {std::pair<std::string, double>("left", 0.04), {"right", -0.04}}) {
      rods.push_back({c.tree.add(arm, {0.2, y, 0}, test::z_along({0.6, 0, 0.8}),
                                 {{side + "_pitch_" + n, false, kO, kY}, {side + "_roll_" + n, false, kO, kX}}),
                      side + "_tip_" + n, side + "_ball_" + n});
      local.push_back(mount * V3{0.06, y, 0});
    }
  }
  c.gaps = [=](const Poses& p, const Place& site) {
    std::vector<double> gaps;
    std::vector<V3> platform = {site("tool")};
    for (const Rod& rod : rods) {
      const V3 tip = p[static_cast<std::size_t>(rod.body)]({0, 0, -0.4});
      gaps.push_back(norm(site(rod.tip) - tip));
      gaps.push_back(norm(site(rod.ball) - tip));
      platform.push_back(site(rod.ball));
    }
    gaps.push_back(change_of_shape(platform, local));
    return gaps;
  };
  return c;
}

Case stewart() {
  Case c{"stewart", {}, {}, {}};
  const std::vector<std::pair<V3, V3>> legs = {
      {{0.591, 0.104, 0}, {0.193, 0.23, 0}},     {{-0.205, 0.564, 0}, {0.103, 0.282, 0}},
      {{-0.386, 0.46, 0}, {-0.295, 0.052, 0}},   {{-0.386, -0.46, 0}, {-0.295, -0.052, 0}},
      {{-0.205, -0.564, 0}, {0.103, -0.282, 0}}, {{0.591, -0.104, 0}, {0.193, -0.23, 0}}};
  std::vector<int> rods;
  for (std::size_t i = 0; i < legs.size(); ++i) {
    const std::string n = std::to_string(i + 1);
    const V3 along = legs[i].second + V3{0, 0, 0.8} - legs[i].first;
    const int cylinder = c.tree.add(0, legs[i].first, test::z_along(along),
                                    {{"lean_" + n, false, kO, kX}, {"tilt_" + n, false, kO, kY}});
    rods.push_back(c.tree.add(cylinder, {0, 0, 0.4}, kNoTurn, {{"leg_" + n, true, kO, kZ}}));
    c.reach.emplace_back("leg_" + n, 0.05);
  }
  // Ends of the rods in the posture of the model.
  const Poses first = c.tree.poses({});
  std::vector<V3> ends;
  for (std::size_t i = 0; i < legs.size(); ++i) {
    const Tree::Pose& rod = first[static_cast<std::size_t>(rods[i])];
    const V3 way = legs[i].second + V3{0, 0, 0.8} - rod.at;
    V3 end{};
    for (std::size_t k = 0; k < 3; ++k) {
      V3 column = {rod.turn[0][k], rod.turn[1][k], rod.turn[2][k]};
      end[k] = dot(column, way);
    }
    ends.push_back(end);
  }
  c.gaps = [=](const Poses& p, const Place& site) {
    const V3 o = site("centre"), x = 5 * (site("front") - o), y = 5 * (site("side") - o);
    std::vector<double> gaps = {std::abs(norm(x) - 1), std::abs(norm(y) - 1), std::abs(dot(x, y))};
    for (std::size_t i = 0; i < legs.size(); ++i) {
      const V3 ball = o + legs[i].second[0] * x + legs[i].second[1] * y;
      gaps.push_back(norm(p[static_cast<std::size_t>(rods[i])](ends[i]) - ball));
    }
    return gaps;
  };
  return c;
}

Case leg() {
  Case c{"leg", {}, {{"roll", 0.6}, {"pitch", 0.8}, {"knee_crank", 0.4}, {"foot_crank", 0.4}}, {}};
  const int hip = c.tree.add(0, {0, 0.1, 1}, kNoTurn, {{"roll", false, kO, kX}});
  const int thigh = c.tree.add(hip, kO, kNoTurn, {{"pitch", false, kO, kY}});
  const int crank = c.tree.add(thigh, {-0.02, 0.03, 0}, kNoTurn, {{"knee_crank", false, kO, kY}});
  const int rod = c.tree.add(crank, {-0.06, 0, 0}, kNoTurn, {{"knee_rod_joint", false, kO, kY}});
  const int shin = c.tree.add(thigh, {0, 0, -0.4}, kNoTurn, {{"knee", false, kO, kY}});
  const int arm = c.tree.add(shin, {0, -0.04, 0}, kNoTurn, {{"foot_crank", false, kO, kY}});
  const int foot = c.tree.add(shin, {0, 0, -0.4}, kNoTurn, {{"ankle", false, kO, kY}});
  c.gaps = [=](const Poses& p, const Place& site) -> std::vector<double> {
    const auto in = [&](int body, const V3& x) { return p[static_cast<std::size_t>(body)](x); };
    const V3 pin = in(arm, {-0.05, 0, 0}), lever = in(foot, {-0.05, -0.04, 0});
    return {norm(in(rod, {0, 0, -0.36}) - in(shin, {-0.08, 0.03, 0.04})),
            std::abs(norm(pin - lever) - 0.4),
            norm(site("foot_crank_pin") - pin),
            norm(site("foot_rod_end") - lever),
            norm(site("foot_lever") - lever),
            norm(site("toe") - in(foot, {0.1, 0, -0.05})),
            norm(site("heel") - in(foot, {-0.05, 0, -0.05}))};
  };
  return c;
}

Case chain() {
  Case c{"chain", {}, {}, {}};
  int frame = 0;
  V3 at = {0, 0, 0.1};
  M3 turned = kNoTurn;
  std::vector<std::pair<int, int>> pairs;
  for (int i = 1; i <= 4; ++i) {
    const std::string n = std::to_string(i);
    const int rocker = c.tree.add(frame, at + turned * V3{0.2, 0, 0}, turned, {{"rock_" + n, false, kO, kY}});
    const int crank = c.tree.add(frame, at, turned, {{"turn_" + n, false, kO, kY}});
    frame = c.tree.add(crank, {0, 0, 0.2}, kNoTurn, {{"bend_" + n, false, kO, kY}});
    at = {0, 0, 0.05};
    turned = turn(kZ, 90 * kDegree);
    pairs.emplace_back(rocker, frame);
    c.reach.emplace_back("turn_" + n, 0.6);
  }
  c.gaps = [=](const Poses& p, const Place& site) {
    std::vector<double> gaps = {norm(site("top") - p[static_cast<std::size_t>(frame)]({0.1, 0, 0.1}))};
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const V3 end = p[static_cast<std::size_t>(pairs[i].first)]({0, 0, 0.25});
      gaps.push_back(norm(end - p[static_cast<std::size_t>(pairs[i].second)]({0.2, 0, 0.05})));
      gaps.push_back(norm(end - site("joint_" + std::to_string(i + 1))));
    }
    return gaps;
  };
  return c;
}

std::string in_scenes(const std::string& name) { return ASSUR_SOURCE_DIR "/scenes/mjcf/" + name + ".xml"; }

class Models : public testing::TestWithParam<Case> {};

TEST_P(Models, CloseTheirLoopsInRandomPostures) {
  const Case& c = GetParam();
  const ImportedModel model = import_model(in_scenes(c.name));
  std::map<std::string, std::string> driver_of;  // joints
  std::vector<std::string> drivers;
  for (const ImportedModel::Driver& d : model.drivers) {
    for (const ImportedModel::Coordinate& k : model.coordinates) {
      if (k.name == d.coordinate) driver_of[k.joint] = d.name;
    }
    drivers.push_back(d.name);
  }
  Simulator s = test::simulator(model.scene.with_time({0, 1, 0.05}), "auto", {}, drivers);
  const auto site = [&](const std::string& name) -> V3 {
    return {s.output(name + ".x"), s.output(name + ".y"), s.output(name + ".z")};
  };
  const SimulatorState start = s.save();
  std::mt19937 random(20261123);
  double worst = 0, farthest = 0;
  for (int posture = 0; posture < 200; ++posture) {
    s.restore(start);
    std::vector<std::pair<std::string, double>> targets;
    for (const auto& [joint, reach] : c.reach) {
      targets.emplace_back(driver_of.at(joint), std::uniform_real_distribution(-reach, reach)(random));
    }
    for (int step = 1; step <= 20; ++step) {
      for (const auto& [driver, to] : targets) s.set(driver, to * step / 20, to);
      const Status status = s.step();
      ASSERT_TRUE(status.arrived()) << posture << ", " << step << ": " << name(status.code);
      std::map<std::string, double> q;
      for (const ImportedModel::Coordinate& k : model.coordinates) {
        q[k.joint] = k.start + s.output(k.name);
        farthest = std::max(farthest, std::abs(s.output(k.name)));
      }
      for (const double gap : c.gaps(c.tree.poses(q), site)) {
        if (!(gap <= worst)) worst = gap;  // also if it is NaN
      }
    }
  }
  EXPECT_LE(worst, 1e-12);
  EXPECT_GE(farthest, 0.04);  // it moves
  RecordProperty("worst", std::to_string(worst * 1e15) + "e-15");
}

INSTANTIATE_TEST_SUITE_P(Shipped, Models, testing::Values(four_bar(), five_bar(), delta(), stewart(), leg(), chain()),
                         [](const auto& one) { return one.param.name; });

// The check above finds a loop that is open.
TEST(LoopCheck, FindsAGap) {
  const Case c = four_bar();
  const auto site = [](const std::string&) { return kO; };
  EXPECT_LE(c.gaps(c.tree.poses({}), site)[0], 1e-15);
  EXPECT_NEAR(c.gaps(c.tree.poses({{"shaft", 1e-6}}), site)[0], 3.7e-7, 1e-7);
}

}  // namespace
}  // namespace assur
