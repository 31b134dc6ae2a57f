// Motions and postures compared with reference tables: Andrews' squeezer, Dietmaier's platform with 40 postures.
#include <gtest/gtest.h>

#include <numbers>

#include "errors/deviation.hpp"
#include "plan/preparation.hpp"
#include "references/perturb.hpp"
#include "references/planar.hpp"
#include "references/tables.hpp"

namespace assur {
namespace {

using references::Quad;
using references::QuadJet;
using test::Deviation;
using test::Result;

std::vector<std::string> every_strategy() {
  std::vector<std::string> all;
  for (const std::string formulation : {"global", "groups", "irreducible"}) {
    for (const std::string& solver : test::solvers()) all.push_back(formulation + "/" + solver);
  }
  return all;
}

TEST(Andrews, FollowsTheTableOverAWholeTurn) {
  const auto table = references::read_andrews();
  ASSERT_EQ(table.size(), 72u);
  for (const std::string& strategy : every_strategy()) {
    SCOPED_TRACE(strategy);
    const Result r = test::run(sample("andrews"), strategy);
    ASSERT_TRUE(r.report().status.ok());
    ASSERT_EQ(r.trajectory.rows(), 73u);
    Deviation deviation(r.trajectory);
    for (std::size_t k = 0; k < table.size(); ++k) {
      deviation.add(k, "F", references::on_circle(references::at_rest(0, 0), 0.007, {table[k].beta, 1, 0}));
      deviation.add(k, "E", table[k].E);
      deviation.add(k, "G", table[k].G);
      deviation.add(k, "H", table[k].H);
    }
    const Motion off = deviation.worst();
    EXPECT_LE(off.value, 1e-12);
    EXPECT_LE(off.rate, 1e-11);
    EXPECT_LE(off.acceleration, 1e-11);
    EXPECT_LE(r.report().error.position, 1e-14);
  }
}

TEST(Andrews, HasThreeDyadsOnTwoLevels) {
  const Prepared prepared = prepare(sample("andrews"), {"groups/eigen", {}});
  const GroupedSystem& s = *preparation(prepared).structure;
  ASSERT_EQ(s.groups.size(), 3u);
  EXPECT_EQ(s.levels, 2);
  EXPECT_EQ(s.groups[0].name, "E");
  EXPECT_EQ(s.groups[0].level, 0);
  for (const SolvedGroup& g : s.groups) EXPECT_EQ(g.unknowns.size(), 2u);
  for (std::size_t g : {1u, 2u}) EXPECT_EQ(s.groups[g].level, 1);
}

TEST(Andrews, CannotBeAssembledWithTheMisprint) {
  for (const std::string& strategy : every_strategy()) {
    try {
      (void)prepare(sample("andrews", {{"xb", 0.03635}}), {strategy, {}});
      ADD_FAILURE() << strategy << ": the misprinted mechanism was accepted";
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), Error::Kind::numerical) << e.what();
      // E(F, B) can be assembled, but is out of reach for A: |EG| + |GA| = 0.06.
      EXPECT_NE(std::string(e.what()).find("group G cannot be assembled: 'G"), std::string::npos) << e.what();
    }
  }
}

// Andrews' squeezer with a crank that passes the state of the IVP test set at t = 0.03 s, on a parabola from beta = 0.
struct Ivp {
  static constexpr double kBeta = 15.81077119629904, kRate = 1139.920302151208, kAcceleration = -24631.76316945196;

  double start;
  Scene scene;

  Ivp() : start(0.03 + before()), scene(make()) {}

 private:
  // The root of kBeta + kRate s + kAcceleration s^2 / 2 = 0 that is nearer to s = 0.
  static double before() { return -2 * kBeta / (kRate + std::sqrt(kRate * kRate - 2 * kBeta * kAcceleration)); }
  [[nodiscard]] Scene make() const {
    const Scene andrews = sample("andrews");
    SceneBuilder builder("andrews", 2);
    for (const Point& p : andrews.points()) builder.add(p);
    for (const Vector& v : andrews.vectors()) builder.add(v);
    for (const Constraint& c : andrews.constraints()) builder.add(c);
    for (const Measure& m : andrews.measures()) builder.add(m);
    const auto law = [](double t) -> Motion {
      const double s = t - 0.03;
      return {kBeta + s * (kRate + s * (kAcceleration / 2)), kRate + s * kAcceleration, kAcceleration};
    };
    builder.drive("motor", PointAngle{"O", "F", "", Law::function(law)});
    return builder.time(start, 0.03, (0.03 - start) / 400).build();
  }
};

// Compares gamma, delta, epsilon, and theta up to whole turns, because the runs start at different postures. Phi and
// Omega are measured from directions turned by a quarter and add no information.
TEST(Andrews, AgreesWithTheIvpTestSet) {
  const Ivp ivp;
  for (const std::string& strategy : every_strategy()) {
    SCOPED_TRACE(strategy);
    Simulator s = test::simulator(ivp.scene, strategy);
    for (int k = 1; k < 400; ++k) ASSERT_TRUE(s.step(ivp.scene.time().time(k)).ok()) << k;
    ASSERT_TRUE(s.step(0.03).ok());
    const auto turns = [](double angle) { return std::remainder(angle, 2 * std::numbers::pi); };
    const double theta = turns(s.output("theta") + 15.75637105984298);
    const double gamma = s.output("gamma") - 0.04082224013073101;
    const double delta = s.output("delta") - 0.5244099658805304;
    const double epsilon = s.output("epsilon") - 1.048080741042263;
    EXPECT_NEAR(theta, 0, 1e-13);
    EXPECT_NEAR(gamma, 0, 1e-13);
    EXPECT_NEAR(delta, 0, 1e-13);
    EXPECT_NEAR(epsilon, 0, 1e-13);
    EXPECT_NEAR(turns(s.output("beta") - Ivp::kBeta), 0, 1e-13);
    EXPECT_NEAR(s.output("beta.rate"), Ivp::kRate, 1e-13 * Ivp::kRate);
    EXPECT_NEAR(s.output("beta.acceleration"), Ivp::kAcceleration, 1e-13 * -Ivp::kAcceleration);
  }
}

// A guess with errors in every coordinate starts in the posture of the table: errors up to 0.001, less where the
// condition exceeds 1e4. The legs are led from their lengths in the guess to their laws; next to a singular posture
// such a way may end in another posture. Tolerance: the residual of an assembled posture (64 eps of the sum of the
// terms of an equation, in practice a few eps) and the rounding of the dimensions from decimals, times the condition of
// the equations. 4e-15 is 18 eps.
TEST(Gough, FindsAllFortyPosturesFromPerturbedGuesses) {
  const auto table = references::read_gough();
  ASSERT_EQ(table.size(), 40u);
  for (const references::GoughRow& row : table) {
    const Scene scene = sample("gough", {{"posture", row.posture}});
    const double errors = std::min(1e-3, 10 / row.condition);
    for (unsigned draw = 0; draw < 3; ++draw) {
      const unsigned seed = 100 * static_cast<unsigned>(row.posture) + draw;
      const Scene guess = references::perturbed(scene, errors, seed);
      const Simulator s = test::simulator(guess, draw % 2 == 0 ? "groups/eigen" : "irreducible/" + test::sparse());
      double off = 0;
      const auto compare = [&](const std::string& name, const references::Vec<Quad>& reference) {
        for (std::size_t i = 0; i < 3; ++i) {
          const Quad found = s.output(name + "." + "xyz"[i]);
          off = std::max(off, std::abs(static_cast<double>(found - reference[i])));
        }
      };
      compare("B1", row.n);  // A1 is the origin
      compare("u", row.u);
      compare("v", row.v);
      compare("w", references::cross(row.u, row.v));
      EXPECT_LE(off, 4e-15 * row.condition) << "posture " << row.posture << ", seed " << seed;
    }
  }
}

}  // namespace
}  // namespace assur
