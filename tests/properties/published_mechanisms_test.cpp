// Mechanisms in space and with redundant equations against their published closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "errors/conditions.hpp"
#include "errors/deviation.hpp"
#include "references/planar.hpp"
#include "structure/grouped_system.hpp"

namespace assur {
namespace {

using test::Result;

constexpr double kDegree = std::numbers::pi / 180;

// Compares the angle of the link over ten turns and the displacement, with both derivatives. Lengths hold to 8 eps, and
// the condition is the largest distance of B from the origin over its smallest distance from Q. Accelerations have the
// third power of the condition.
void expect_quick_return(const std::string& text, const std::string& strategy, double pivot) {
  SCOPED_TRACE(text + " " + strategy);
  const Result r = test::run(sample(text), strategy);
  ASSERT_TRUE(r.report().status.ok()) << name(r.report().status.code);
  const Trajectory& t = r.trajectory;
  const double omega = 2 * std::numbers::pi, condition = 0.1 / std::abs(0.1 - pivot);
  const std::size_t angle = t.index("link_angle"), slide = t.index("displacement");
  double before = 0, turned = 0;
  for (std::size_t k = 0; k < t.rows(); ++k) {
    const long double c = std::cos(omega * t.times()[k]), s = std::sin(omega * t.times()[k]);
    const long double x = 0.1L * c - pivot, y = 0.1L * s, square = x * x + y * y;
    const auto direction = static_cast<double>(std::atan2(y, x));
    turned += std::remainder(direction - before, omega);
    before = direction;
    // The rate is the angular momentum of B about Q divided by the square of the distance.
    const long double moment = 0.1L * (0.1L - pivot * c), rate = omega * moment / square;
    const long double change = 2 * omega * 0.1L * pivot * s;  // derivative of `square` by time
    const long double acceleration = (omega * omega * 0.1L * pivot * s - rate * change) / square;
    // sin(omega t) includes the rounding of its argument, up to 63 eps after ten turns.
    const double of_angle = (64 + 16 * condition) * kEps * condition, largest = omega * condition;
    ASSERT_NEAR(t(k, angle), turned, of_angle + 100 * kEps * turned) << k;
    ASSERT_NEAR(t(k, slide), static_cast<double>(std::sqrt(square)), of_angle) << k;
    ASSERT_NEAR(t(k, angle + 1), static_cast<double>(rate), of_angle * condition * largest) << k;
    ASSERT_NEAR(t(k, angle + 2), static_cast<double>(acceleration),
                of_angle * condition * condition * largest * largest)
        << k;
  }
  EXPECT_NEAR(turned, 20 * std::numbers::pi, 1e-9);
}

TEST(Whitworth, FollowsItsClosedFormOverTenTurns) {
  for (const std::string& strategy :
       {std::string("groups/eigen"), "global/" + test::sparse(), std::string("irreducible/lanes")}) {
    expect_quick_return("whitworth", strategy, 0.05);
    expect_quick_return("whitworth:hinge=stated", strategy, 0.05);
    expect_quick_return("whitworth:pivot=0.09", strategy, 0.09);
  }
}

TEST(Whitworth, ExplicitHingeIsRedundant) {
  EXPECT_TRUE(group_equations(sample("whitworth")).redundant.empty());
  const GroupedSystem s = group_equations(sample("whitworth:hinge=stated"));
  EXPECT_EQ(s.redundant.size(), 1u);
  EXPECT_EQ(s.mobility, 1);
}

// The angles satisfy cos theta + cos phi + cos theta cos phi = 0 between folds at theta = -120 and +120 degrees. The
// cosine of a small phi hides its error, so the test measures the error of this relation.
TEST(Bricard, SatisfiesTheRelationOfItsAngles) {
  const Result r = test::run(sample("bricard"), "groups/eigen");
  ASSERT_TRUE(r.report().status.ok()) << name(r.report().status.code);
  const Trajectory& t = r.trajectory;
  ASSERT_EQ(t.rows(), 1001u);
  const std::vector<double> kappa = test::conditions(sample("bricard"), t.times(), 10);
  double least = 0, most = 0;
  for (std::size_t k = 0; k < t.rows(); ++k) {
    const double theta = t(k, t.index("theta")), phi = t(k, t.index("phi"));
    const double left = std::cos(theta) + std::cos(phi) + std::cos(theta) * std::cos(phi);
    EXPECT_NEAR(left, 0, 4 * 8 * kEps * kappa[k]) << k;
    const double hinge = 90 * kDegree + 115 * kDegree * std::sin(t.times()[k] - std::asin(90.0 / 115));
    EXPECT_NEAR(theta, hinge - 90 * kDegree, 8 * kEps * kappa[k]) << k;
    least = std::min(least, theta), most = std::max(most, theta);
  }
  EXPECT_NEAR(least, -115 * kDegree, 1e-3);  // rows are 0.01 s apart
  EXPECT_NEAR(most, 115 * kDegree, 1e-3);
}

// Tolerance: the resolution of a limit, 2^-10 of a step.
TEST(Bricard, EndsAtItsFold) {
  const Scene scene = sample("bricard", {{"swing", 120.1 * kDegree}});
  for (const std::string strategy : {"groups/eigen", "irreducible/lanes"}) {
    SCOPED_TRACE(strategy);
    const Result r = test::run(scene, strategy);
    EXPECT_EQ(r.report().status.code, Code::fold);
    ASSERT_EQ(r.report().events.size(), 1u);
    const Event& e = r.report().events[0];
    // 90 + 120.1 sin(t - asin(90 / 120.1)) = 210 degrees
    const double fold = std::asin(120 / 120.1) + std::asin(90 / 120.1);
    EXPECT_LE(e.time, fold);
    EXPECT_NEAR(e.time, fold, 0.01 / 1024);
    EXPECT_NEAR(e.until, fold, 0.01 / 1024);
  }
}

TEST(Parallelograms, EachHasARedundantRod) {
  const Scene scene = sample("parallelograms:5");
  const GroupedSystem s = group_equations(scene);
  EXPECT_EQ(s.redundant.size(), 5u);
  EXPECT_EQ(s.mobility, 1);
  const Result r = test::run(scene, "groups/eigen");
  ASSERT_TRUE(r.report().status.ok());
  test::Deviation deviation(r.trajectory);
  for (std::size_t k = 0; k < r.trajectory.rows(); ++k) {
    for (const auto& [point, at] : references::parallelograms(5, r.trajectory.times()[k])) deviation.add(k, point, at);
  }
  // The sine between rod and coupler is at least cos 1.2 = 0.36. The errors of five loops in series add up, relative to
  // 10 m.
  const double kappa = 5 / std::cos(1.2);
  EXPECT_LE(deviation.worst().value, 8 * kEps * kappa);
  EXPECT_LE(deviation.worst().rate, 8 * kEps * kappa * kappa * 10);
  EXPECT_LE(deviation.worst().acceleration, 8 * kEps * kappa * kappa * kappa * 10);
}

TEST(Parallelograms, ATooLongRodContradicts) {
  const GroupedSystem s = group_equations(sample("parallelograms:loops=2,excess=1e-4"));
  EXPECT_EQ(s.cannot_assemble.rfind("these equations contradict each other: ", 0), 0u) << s.cannot_assemble;
}

// With equal lengths C passes through O where the rod is perpendicular to the rail: the smooth continuation is
// x = 2 r cos.
TEST(SliderCrank, WithEqualLengthsPassesItsChangePoints) {
  const Scene scene = sample("slider_crank:crank_length=0.2,rod_length=0.2,step=0.0033,steps=300");
  const Result r = test::run(scene, "groups/eigen");
  ASSERT_TRUE(r.report().status.ok()) << name(r.report().status.code);
  ASSERT_EQ(r.report().events.size(), 2u);
  for (const Event& e : r.report().events) EXPECT_EQ(e.kind, Code::change_point_passed);
  const std::size_t x = r.trajectory.index("C.x"), acceleration = r.trajectory.index("C.ax");
  const std::size_t turning = r.trajectory.index("rod_angle.acceleration");  // the rod turns as evenly as the crank
  const double omega = 2 * std::numbers::pi, largest = 0.4 * omega * omega;
  const double estimated = r.report().error.estimated_acceleration.value();
  for (std::size_t k = 0; k < r.trajectory.rows(); ++k) {
    const double angle = omega * r.trajectory.times()[k];
    ASSERT_NEAR(r.trajectory(k, acceleration), -largest * std::cos(angle), estimated * largest) << k;
    ASSERT_NEAR(r.trajectory(k, turning), 0, estimated) << k;
    // Rows are at least 0.0008 s, 0.005 rad, from a change point.
    ASSERT_NEAR(r.trajectory(k, x), 0.4 * std::cos(angle), 8 * kEps / 0.005) << k;
  }
}

TEST(NFourBar, SwingsWithTheGivenAmplitude) {
  const Result r = test::run(sample("n_four_bar:loops=2,swing=0.5,steps=200"), "groups/eigen");
  const std::size_t x = r.trajectory.index("B2.x");
  for (std::size_t k = 0; k < r.trajectory.rows(); ++k) {
    const double f = std::numbers::pi / 2 + 0.5 * std::sin(r.trajectory.times()[k]);
    ASSERT_NEAR(r.trajectory(k, x), 2 + std::cos(f), 64 * kEps);
  }
}

}  // namespace
}  // namespace assur
