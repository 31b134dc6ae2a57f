// Certificates compared with the reference in quad. The two share nothing but the equations of the scene.
#include "verification/certificate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "assur/saved_plan.hpp"
#include "errors/conditions.hpp"
#include "motion/limited.hpp"
#include "plan/preparation.hpp"
#include "properties/small_random_scenes.hpp"
#include "references/scaled.hpp"
#include "simulation/simulator_access.hpp"
#include "source_dir.hpp"
#include "verification/reference_motion.hpp"

namespace assur {
namespace {

using test::Draw;

struct Largest {
  double radius = 0, error = 0;  // the largest of the run
  int rows = 0, proven = 0, unknowns = 0;
};

double true_error(const Ball<double>& computed, const Quad& truth) {
  return static_cast<double>(abs(Quad(computed.middle()) - truth));
}

// The true value of every coordinate of a certified row is within its radius.
Largest expect_truth_inside(const Scene& scene, const std::string& strategy, std::int64_t rows = 20) {
  SCOPED_TRACE(scene.name() + " " + strategy);
  const Prepared prepared = prepare(scene, {strategy, {}});
  Simulator simulator(prepared);
  Certifier certifier(preparation(prepared));
  ReferenceMotion truth(prepared);
  Largest out;
  for (std::int64_t k = 0; k <= std::min(scene.time().steps(), rows); ++k) {
    const double t = scene.time().time(k);
    EXPECT_TRUE(simulator.step(t).ok());
    truth.advance(t);
    const Certificate certificate = certifier.certify(SimulatorAccess::posture(simulator), t);
    double largest = 0;
    for (std::size_t c = 1; c < certifier.coordinates().size(); ++c) {
      const Ball<double>& x = certifier.coordinates()[c];
      if (!std::isfinite(x.radius())) continue;
      const double error = true_error(x, truth.state().q[0][c]);
      EXPECT_LE(error, x.radius()) << certifier.system().coordinate_name(static_cast<Index>(c)) << " at t = " << t;
      if (certifier.system().coordinates[c].role != Role::unknown) continue;
      ++out.unknowns;
      largest = std::max(largest, x.radius());
      out.error = std::max(out.error, error);
    }
    ++out.rows;
    EXPECT_EQ(certificate.time, t);
    if (!certificate.why_not.empty()) continue;
    ++out.proven;
    EXPECT_EQ(certificate.radius, largest);
    EXPECT_GT(certificate.uniqueness, certificate.radius);
    out.radius = std::max(out.radius, largest);
  }
  return out;
}

std::string in_scenes(const std::string& file) { return std::string(ASSUR_SOURCE_DIR) + "/scenes/" + file; }

const char* const kFormulations[] = {"global/eigen", "groups/eigen", "irreducible/eigen"};

TEST(Certificate, EnclosesTheTruthOfEveryScene) {
  for (const char* text : {"four_bar", "slider_crank:offset=0.02", "andrews", "stewart", "n_four_bar:5",
                           "rings:legs=3,n=12", "rings:legs=1,n=60,terminal=24"}) {
    for (const char* strategy : kFormulations) {
      const Largest found = expect_truth_inside(sample(text), strategy);
      EXPECT_EQ(found.proven, found.rows) << text;
      EXPECT_GT(found.unknowns, 0);
    }
  }
}

TEST(Certificate, EnclosesTheTruthOfEveryFile) {
  for (const char* file : {"almost_parallelogram.json", "andrews.json", "four_bar.json", "gough.json",
                           "slider_crank.json", "stewart.json"}) {
    const Largest found = expect_truth_inside(open_scene(in_scenes(file)), "auto", 100);
    EXPECT_EQ(found.proven, found.rows) << file;
  }
}

// With constant inputs and one group, the radius exceeds the error only by second-order terms: the condition, at most
// 6e5 here, times the rounding of the matrices of 18 unknowns.
TEST(Certificate, RadiusOfAGoughPostureIsItsError) {
  for (int k = 1; k <= 40; ++k) {
    const Largest found = expect_truth_inside(sample("gough:posture=" + std::to_string(k)), "auto");
    EXPECT_EQ(found.proven, found.rows) << k;
    EXPECT_LE(found.radius, found.error * 1.001) << k;
  }
}

TEST(Certificate, EnclosesTheTruthThroughManyLevels) {
  for (const char* text : {"four_bar:20", "n_four_bar:20"}) {
    const Largest found = expect_truth_inside(sample(text), "irreducible/eigen", 50);
    EXPECT_EQ(found.proven, found.rows) << text;
  }
}

TEST(Certificate, EnclosesTheTruthOfRandomMechanisms) {
  Draw draw(11);
  for (int k = 0; k < 12; ++k) {
    const Scene scene = k % 2 == 0 ? test::planar_mechanism(draw) : test::spatial_mechanism(draw);
    const Largest found = expect_truth_inside(scene, kFormulations[k % 3], 10);
    EXPECT_EQ(found.proven, found.rows);
  }
}

// Three equal cranks on one coupler, the third at its middle: one equation follows from the others.
Scene three_cranks() {
  SceneBuilder b("three_cranks", 2);
  for (int i = 0; i < 3; ++i) {
    const std::string k = std::to_string(i);
    b.fixed_point("A" + k, {1.0 * i, 0, 0}).point("B" + k, {1.0 * i, 1, 0});
    b.constrain("crank" + k, Distance{"A" + k, "B" + k, 1.0});
  }
  b.constrain("coupler", Distance{"B0", "B2", 2.0});
  b.constrain("middle", Linear{{{"B0", 1}, {"B1", -2}, {"B2", 1}}, {}});
  b.drive("motor", PointAngle{"A0", "B0", "", Law::harmonics({{0.5, 0.2, 0}}, std::numbers::pi / 2)});
  return b.time(0, 1, 0.05).build();
}

TEST(Certificate, LeavesOutRedundantEquations) {
  ASSERT_EQ(preparation(prepare(three_cranks())).structure->checks.size(), 1U);
  for (const char* strategy : kFormulations) {
    const Largest found = expect_truth_inside(three_cranks(), strategy);
    EXPECT_EQ(found.proven, found.rows);
  }
}

// The radius of a computed posture comes from its residual. Each equation holds to 8 eps of its scale (the criterion of
// convergence), and the condition amplifies this error. The radii passed to the next level have no signs, which costs a
// factor of two.
TEST(Certificate, IsAsNarrowAsTheConditionAllows) {
  for (const char* text : {"four_bar", "slider_crank:offset=0.02", "andrews", "stewart", "rings:legs=3,n=12"}) {
    const Scene scene = sample(text);
    const std::vector<double> conditions =
        test::conditions(scene, test::grid_of(scene.with_time({0, 20 * scene.time().step, scene.time().step})));
    Simulator simulator = test::simulator(scene, "groups/eigen");
    Certifier certifier(preparation(simulator.prepared()));
    for (std::size_t k = 0; k < conditions.size(); ++k) {
      ASSERT_TRUE(simulator.step(scene.time().time(static_cast<std::int64_t>(k))).ok());
      const std::vector<double> posture = SimulatorAccess::posture(simulator);
      const double size = std::abs(*std::max_element(posture.begin(), posture.end(),
                                                     [](double a, double b) { return std::abs(a) < std::abs(b); }));
      const Certificate certificate = certifier.certify(posture, simulator.time());
      EXPECT_LE(certificate.radius, 4 * 8 * kEps * conditions[k] * size) << text << " in row " << k;
    }
  }
}

// ---- wrong postures

TEST(Certificate, EnclosesTheTruthOrFailsForAWrongPosture) {
  for (const char* text : {"stewart", "four_bar:3", "rings:legs=2,n=24"}) {
    const Prepared prepared = prepare(sample(text), {"groups/eigen", {}});
    Simulator simulator(prepared);
    Certifier certifier(preparation(prepared));
    ReferenceMotion truth(prepared);
    const std::vector<double> posture = SimulatorAccess::posture(simulator);
    Draw draw(12);
    for (const double off : {1e-12, 1e-9, 1e-6, 1e-3, 0.3}) {
      for (int k = 0; k < 10; ++k) {
        std::size_t wrong = 0;  // index of a random unknown
        while (preparation(prepared).structure->system->coordinates[wrong].role != Role::unknown)
          wrong = draw.below(posture.size());
        std::vector<double> other = posture;
        other[wrong] += draw.maybe() ? off : -off;
        const Certificate certificate = certifier.certify(other, simulator.time());
        for (std::size_t c = 1; c < posture.size(); ++c) {
          EXPECT_FALSE(true_error(certifier.coordinates()[c], truth.state().q[0][c]) >
                       certifier.coordinates()[c].radius());
        }
        EXPECT_GE(certificate.radius, off * (1 - 1e-3)) << text << " off by " << off;
        EXPECT_TRUE(off > 1e-9 || certificate.why_not.empty()) << text << " off by " << off;
      }
    }
  }
}

// P slides on y = 0, and Q is at a distance of 1 from the origin and from P: Q = (x / 2, +-h) with h^2 = 1 - x^2 / 4.
// At x = 2 the two solutions coincide. The singular values of the Jacobian [2 Q; 2 (Q - P)] are sqrt(8) h and sqrt(8) x
// / 2.
struct Fold {
  Prepared prepared = prepare(SceneBuilder("fold", 2)
                                  .fixed_point("O", {0, 0, 0})
                                  .point("P", {1, 0, 0})
                                  .point("Q", {0.5, 0.9, 0})
                                  .constrain("near", Distance{"O", "Q", 1.0})
                                  .constrain("far", Distance{"Q", "P", 1.0})
                                  .drive("slide", DrivenCoordinate{"P.x", Law::polynomial({0, 1})})
                                  .drive("level", DrivenCoordinate{"P.y", Law::constant(0)})
                                  .time(1, 2, 0.1)
                                  .build(),
                              {"irreducible/eigen", {}});

  Certificate certify(double x, double y) {
    std::vector<double> posture = preparation(prepared).structure->start;
    const System& s = *preparation(prepared).structure->system;
    const Index first = s.form(s.item("Q").form[0])[0].coordinate;
    posture[static_cast<std::size_t>(first)] = x / 2;
    posture[static_cast<std::size_t>(first) + 1] = y;
    return Certifier(preparation(prepared)).certify(posture, x);
  }
};

TEST(Certificate, ShrinksTowardsAFoldAndEndsThere) {
  Fold fold;
  double least = 1;
  for (int k = 1; k <= 7; ++k) {
    const double x = 2 * std::sqrt((1 - std::pow(10, -k)) * (1 + std::pow(10, -k)));
    const double h = static_cast<double>(sqrt(1 - Quad(x) * Quad(x) / 4));
    const Certificate certificate = fold.certify(x, h);
    ASSERT_EQ(certificate.why_not, "") << h;
    // With J^-1 = [2 h, -2 h; x, x] / (4 h x) and second derivatives of 2 in both coordinates of Q, the theorem has B =
    // 1 / h. The solution is unique within h, half of the way to the other posture.
    EXPECT_NEAR(certificate.uniqueness, h, 1e-6 * h + 4 * kEps / h);
    EXPECT_LE(certificate.radius, 4 * kEps / h);  // x / 2 is exact, h is rounded by half a unit
    least = h;
    // Close to the middle between both postures no proof exists.
    EXPECT_NE(fold.certify(x, 0.01 * h).why_not, "");
  }
  EXPECT_LE(least, 1.1e-7);
  const Certificate at = fold.certify(2, 0);
  EXPECT_NE(at.why_not.find("singular"), std::string::npos) << at.why_not;
  EXPECT_EQ(at.radius, HUGE_VAL);
  EXPECT_EQ(at.uniqueness, 0);
  EXPECT_NE(fold.certify(2.5, 0.1).why_not, "");  // no posture exists for x > 2
}

// ---- scenes without certificates

Callback circle() {
  Callback c;
  c.coordinates = {"P.x", "P.y"};
  c.equations = 1;
  c.residual = [](std::span<const double> x, std::span<double> phi) { phi[0] = x[0] * x[0] + x[1] * x[1] - 1; };
  c.jacobian = [](std::span<const double> x, std::span<double> j) {
    j[0] = 2 * x[0];
    j[1] = 2 * x[1];
  };
  c.curvature = [](std::span<const double>, std::span<const double> rate, std::span<double> out) {
    out[0] = 2 * (rate[0] * rate[0] + rate[1] * rate[1]);
  };
  return c;
}

// A callback holds P on a circle. Q is connected to P and to a fixed point. R is connected to another fixed point only.
TEST(Certificate, FailsForCallbacksAndGroupsAfterThem) {
  const Scene scene = SceneBuilder("circle", 2)
                          .point("P", {1, 0, 0})
                          .constrain("circle", circle())
                          .drive("lift", DrivenCoordinate{"P.y", Law::harmonics({{0.3, 1, 0}})})
                          .fixed_point("A", {2, 1, 0})
                          .point("Q", {1, 1, 0})
                          .constrain("rod", Distance{"P", "Q", std::nullopt})
                          .constrain("arm", Distance{"A", "Q", std::nullopt})
                          .point("R", {3, 1, 0})
                          .constrain("crank", Distance{"A", "R", 1.0})
                          .drive("lever", PointAngle{"A", "R", "", Law::harmonics({{0.2, 1, 0}})})
                          .time(0, 0.1, 0.01)
                          .build();
  const Prepared prepared = prepare(scene, {"global/eigen", {}});
  Certifier certifier(preparation(prepared));
  const Certificate certificate = certifier.certify(SimulatorAccess::posture(Simulator(prepared)), 0);
  EXPECT_NE(certificate.why_not.find("quadratic: false"), std::string::npos) << certificate.why_not;
  EXPECT_NE(certificate.why_not.find("circle"), std::string::npos) << certificate.why_not;
  EXPECT_NE(certificate.group.find("P"), std::string::npos) << certificate.group;
  EXPECT_EQ(certificate.radius, HUGE_VAL);
  const System& s = certifier.system();
  const auto radius = [&](const char* point, int component) {
    const Index form = s.item(point).form[component];
    return certifier.coordinates()[static_cast<std::size_t>(s.form(form)[0].coordinate)].radius();
  };
  EXPECT_EQ(radius("P", 0), HUGE_VAL);
  EXPECT_EQ(radius("Q", 0), HUGE_VAL);
  EXPECT_LE(radius("R", 0), 1e-14);
}

TEST(Certificate, FailsForControlledDrivers) {
  Simulator simulator = test::simulator(sample("four_bar"), "groups/eigen", {}, {"motor"});
  const Certificate certificate = certify(simulator);
  EXPECT_NE(certificate.why_not.find("driver"), std::string::npos) << certificate.why_not;
}

TEST(Certificate, FailsForTooLargeGroups) {
  const Simulator simulator = test::simulator(sample("rings:legs=1,n=420"), "irreducible/" + test::sparse());
  const Certificate certificate = certify(simulator);
  EXPECT_NE(certificate.why_not.find("420 unknowns"), std::string::npos) << certificate.why_not;
}

// ---- runs

TEST(Certificate, CertifiesEachRowOfARun) {
  const Scene scene = sample("four_bar:2").with_time({0, 0.02, 0.001});
  const Prepared prepared = prepare(scene, {"groups/eigen", {}});
  Simulator simulator(prepared);
  const Trajectory trajectory = simulator.run();
  const std::vector<Certificate> all = certify(prepared, trajectory);
  ASSERT_EQ(all.size(), trajectory.rows());
  double largest = 0, uniqueness = HUGE_VAL;
  for (std::size_t k = 0; k < all.size(); ++k) {
    EXPECT_EQ(all[k].why_not, "");
    EXPECT_EQ(all[k].time, trajectory.times()[k]);
    largest = std::max(largest, all[k].radius);
    uniqueness = std::min(uniqueness, all[k].uniqueness);
  }
  const Certificate worst = worst_of(all);
  EXPECT_EQ(worst.radius, largest);
  EXPECT_EQ(worst.uniqueness, uniqueness);
  EXPECT_EQ(certify(simulator).radius, all.back().radius);
  EXPECT_EQ(worst_of({}).why_not, "there is no posture to certify");
  EXPECT_TRUE(std::isinf(worst_of({}).radius));
}

TEST(Certificate, FailsForOtherStepSettings) {
  const Prepared prepared = prepare(sample("stewart").with_time({0, 0.1, 0.01}), {"groups/eigen+predict=taylor:0", {}});
  StepSettings settings;
  settings.iterations = 1;  // too few to converge
  const Trajectory trajectory = Simulator(prepared, settings).run();
  for (const Certificate& c : certify(prepared, trajectory, settings)) EXPECT_EQ(c.why_not, "") << c.time;
  const std::vector<Certificate> others = certify(prepared, trajectory);
  EXPECT_EQ(others.front().why_not, "");
  EXPECT_NE(others.back().why_not, "");
  EXPECT_EQ(worst_of(others).radius, HUGE_VAL);
}

TEST(Certificate, NeedsTheScene) {
  std::stringstream file;
  save_plan(file, prepare(sample("four_bar"), {"groups/eigen", {}}));
  try {
    (void)certify(Simulator(load_plan(file)));
    FAIL() << "a loaded plan has no scene";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::input);
  }
}

// Scaling every length by a power of two keeps the radius bitwise.
TEST(Certificate, DoesNotDependOnTheUnitOfLength) {
  const Scene scene = sample("andrews");
  const Certificate here = certify(test::simulator(scene, "groups/eigen"));
  const Certificate there = certify(test::simulator(references::scaled(scene, 10), "groups/eigen"));
  EXPECT_EQ(here.why_not, "");
  EXPECT_EQ(here.radius, there.radius);
  EXPECT_EQ(here.uniqueness, there.uniqueness);
}

}  // namespace
}  // namespace assur
