// Start postures that are only roughly right: shipped mechanisms whose unknowns are moved at random, by a share of a
// typical length (vectors by a share of their length).
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "equations/lowering.hpp"
#include "equations/system.hpp"
#include "index.hpp"
#include "source_dir.hpp"
#include "start/start.hpp"
#include "structure/grouped_system.hpp"

namespace assur {
namespace {

constexpr int kTries = 40;

struct Counts {
  int intended = 0, other = 0, refused = 0;
  std::string why;  // of the last refusal
};

class Rough {
 public:
  explicit Rough(const Scene& scene) : s_(lower(std::make_shared<const Scene>(scene))), time_(scene.time().start) {
    for (std::size_t c = 0; c < s_.coordinates.size(); ++c) {
      if (s_.coordinates[c].role == Role::unknown) unknowns_.push_back(static_cast<Index>(c));
    }
    GroupedSystem out;
    right_ = assembled(s_.guess, out);
    EXPECT_EQ(out.cannot_assemble, "");
  }

  [[nodiscard]] Counts count(double share) const {
    Counts counts;
    std::mt19937 random(1);
    for (int k = 0; k < kTries; ++k) {
      std::vector<double> q = right_;
      for (const Index u : unknowns_)
        q[idx(u)] += share * (2 * static_cast<double>(random()) / static_cast<double>(random.max()) - 1);
      GroupedSystem out;
      q = assembled(q, out);
      if (!out.cannot_assemble.empty() || !out.undetermined.empty()) {
        ++counts.refused;
        counts.why = out.cannot_assemble;
        continue;
      }
      double off = 0;
      for (const Index u : unknowns_) off = std::max(off, std::abs(q[idx(u)] - right_[idx(u)]));
      ++(off < 1e-6 ? counts.intended : counts.other);
    }
    return counts;
  }

 private:
  std::vector<double> assembled(const std::vector<double>& q, GroupedSystem& out) const {
    Problem p;
    p.unknowns = unknowns_;
    p.q = q;
    p.time = time_;
    assemble_start(s_, p, out);
    return p.q;
  }

  System s_;
  double time_;
  std::vector<Index> unknowns_;
  std::vector<double> right_;
};

const std::vector<std::string> kMechanisms = {
    "bennett", "bricard_joints", "delta",  "double_wishbone", "excavator", "geared_five_bar", "hexa",
    "jansen",  "klann",          "sarrus", "scissor",         "three_rps", "whitworth_joints"};

TEST(RoughStart, IsAssembledAsIntendedWithinATenthOfALength) {
  for (const std::string& name : kMechanisms) {
    SCOPED_TRACE(name);
    const Rough rough(read_scene(ASSUR_SOURCE_DIR "/scenes/" + name + ".json"));
    for (const double share : {0.05, 0.1}) EXPECT_EQ(rough.count(share).intended, kTries) << share;
  }
}

// Further away the nearest posture may be another one, but there is one.
TEST(RoughStart, IsAssembledWithinAFifthOfALength) {
  int intended = 0;
  for (const std::string& name : kMechanisms) {
    SCOPED_TRACE(name);
    const Counts counts = Rough(read_scene(ASSUR_SOURCE_DIR "/scenes/" + name + ".json")).count(0.2);
    EXPECT_EQ(counts.refused, 0) << counts.why;
    intended += counts.intended;
  }
  EXPECT_GE(intended, 0.95 * kTries * static_cast<double>(kMechanisms.size()));
}

// What stands behind "violated most, by ", without the unit; -1 if the unit is another one.
double amount(const std::string& message, const std::string& unit) {
  const std::string before = " is violated most, by ";
  const std::size_t at = message.find(before);
  if (at == std::string::npos || !message.ends_with(" " + unit)) return -1;
  return std::stod(message.substr(at + before.size()));
}

// Crank 1 on ground 1; coupler 0.4 and rocker 1.17 do not reach over the 1.72 m between B and D.
TEST(RoughStart, NamesTheBodyAndTheAmountIfALoopCannotClose) {
  SceneBuilder b("double_rocker", 2);
  for (const char* name : {"crank", "coupler", "rocker"}) b.add(Body{.name = name});
  b.joint("A", Revolute{"ground", "crank", Triple{0, 0}});
  b.joint("B", Revolute{"crank", "coupler", Triple{0, 1}});
  b.joint("C", Revolute{"coupler", "rocker", Triple{0.4, 1}});
  b.joint("D", Revolute{"ground", "rocker", Triple{1, 0}});
  b.drive("motor", DrivenCoordinate{"A.angle", Law::constant(0.5)}).time(0, 1, 0.1);
  const GroupedSystem s = group_equations(b.build());
  const auto names = [&](const std::string& what) { return s.cannot_assemble.find(what) != std::string::npos; };
  EXPECT_TRUE(s.cannot_assemble.starts_with("the start posture cannot be reached: at ")) << s.cannot_assemble;
  EXPECT_TRUE(names("group C meets a fold")) << s.cannot_assemble;
  EXPECT_TRUE(names("group C cannot be assembled: the shape of body 'coupler' (rel") ||
              names("group C cannot be assembled: the shape of body 'rocker' (rel"))
      << s.cannot_assemble;
  const double gap = 2 * std::sin((std::acos(0.0) + 0.5) / 2) - 0.4 - std::hypot(0.6, 1);
  EXPECT_GE(amount(s.cannot_assemble, "m"), gap / 3) << s.cannot_assemble;
  EXPECT_LE(amount(s.cannot_assemble, "m"), gap) << s.cannot_assemble;
}

// A parallelogram with a third rod that is 1 mm too long.
TEST(RoughStart, NamesTheRodAndTheAmountOfAContradiction) {
  SceneBuilder b("rods", 2);
  b.fixed_point("A", {0, 0}).fixed_point("D", {2, 0}).fixed_point("E", {1, 0});
  b.point("B", {0, 1}).point("C", {2, 1});
  b.add(Body{.name = "bar", .base = {"B", "C"}, .points = {{"M", {1, 0}}}});
  b.constrain("side", Distance{"B", "C", 2}).constrain("left", Distance{"A", "B", 1});
  b.constrain("right", Distance{"D", "C", 1}).constrain("middle", Distance{"E", "M", 1.001});
  b.drive("motor", PointAngle{"A", "B", "", Law::polynomial({1.2, 1})}).time(0, 1, 0.1);
  const std::string what = group_equations(b.build()).cannot_assemble;
  EXPECT_TRUE(what.starts_with("these equations contradict each other: ")) << what;
  const double by = amount(what, "m");
  EXPECT_GE(by, 1e-3 / 4) << what;
  EXPECT_LE(by, 1.5e-3) << what;  // a move of B and C together counts by sqrt(2) of its length
}

// A joint of directions is named with an angle.
TEST(RoughStart, NamesTheJointAndTheAngle) {
  SceneBuilder b("crossed", 3);
  b.fixed_vector("x", {1, 0, 0}).fixed_vector("tilted", {0.1, 1, 0}).vector("u", {0, 1, 0.1});
  b.constrain("along", Dot{"x", "u", 0.0}).constrain("tilt", Dot{"tilted", "u", 1.0}).time(0, 1, 0.1);
  const std::string what = group_equations(b.build()).cannot_assemble;
  EXPECT_GT(amount(what, "rad"), 1e-3) << what;
}

}  // namespace
}  // namespace assur
