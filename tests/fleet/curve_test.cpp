// Distances between curves, against closed forms and against what must not change them.
#include "assur/curve.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "assur/status.hpp"
#include "numbers.hpp"

namespace assur::test {
namespace {

using Curve = std::vector<PlanePoint>;

Curve ellipse(double width, double height, int points = 200) {
  Curve out;
  for (int i = 0; i < points; ++i) {
    const double t = kTurn * i / points;
    out.push_back({width * std::cos(t), height * std::sin(t)});
  }
  return out;
}

// Without symmetry.
Curve snail(int points = 150) {
  Curve out;
  for (int i = 0; i < points; ++i) {
    const double t = kTurn * i / points, r = 1 + 0.4 * std::cos(t) + 0.2 * std::sin(3 * t);
    out.push_back({r * std::cos(t), 0.6 * r * std::sin(t)});
  }
  return out;
}

Curve moved(const Curve& curve, double scale, double angle, PlanePoint by) {
  Curve out;
  for (const PlanePoint& p : curve) {
    const std::complex<double> z = std::complex<double>(p[0], p[1]) * std::polar(scale, angle);
    out.push_back({z.real() + by[0], z.imag() + by[1]});
  }
  return out;
}

TEST(Curve, TimedDistance) {
  EXPECT_NEAR(timed_distance(ellipse(2, 2), ellipse(3, 3)), 1, 1e-14);
  // (1 - cos)^2 + sin^2 with a quarter of a turn between them
  Curve later = ellipse(1, 1);
  std::rotate(later.begin(), later.begin() + 50, later.end());
  EXPECT_NEAR(timed_distance(ellipse(1, 1), later), std::sqrt(2), 1e-14);
  EXPECT_THROW((void)timed_distance(ellipse(1, 1), ellipse(1, 1, 20)), Error);
}

TEST(Curve, NearestDistanceDoesNotDependOnTimes) {
  Curve later = ellipse(1, 1);
  std::rotate(later.begin(), later.begin() + 77, later.end());
  EXPECT_EQ(nearest_distance(ellipse(1, 1), later), 0);
  EXPECT_NEAR(nearest_distance(ellipse(2, 2), ellipse(3, 3)), 1, 1e-14);
  // One point at distance 1 from each of two: their own nearest one is that point.
  EXPECT_NEAR(nearest_distance(Curve{{0, 0}}, Curve{{1, 0}, {-3, 0}}), std::sqrt((1. + 1 + 9) / 3), 1e-15);
}

TEST(Curve, FittedDistance) {
  const Curve target = snail();
  EXPECT_NEAR(fitted_distance(moved(target, 0.3, 2.5, {4, -7}), target), 0, 1e-14);
  // A circle onto an ellipse: 2 and 1 are 1.5 +- 0.5, and the part that turns backwards remains.
  EXPECT_NEAR(fitted_distance(ellipse(1, 1), ellipse(2, 1)), 0.5, 1e-14);
  // A point onto an ellipse: its radius.
  EXPECT_NEAR(fitted_distance(Curve(200, {1, 1}), ellipse(2, 1)), std::sqrt(2.5), 1e-14);
  EXPECT_THROW((void)fitted_distance(target, ellipse(1, 1)), Error);
}

TEST(Curve, NormalPlaces) {
  const Curve curve = moved(ellipse(3, 1), 2, 0.7, {5, 6});
  const CurveFrame frame = frame_of(curve);
  EXPECT_NEAR(frame.center[0], 5, 1e-14);
  EXPECT_NEAR(frame.center[1], 6, 1e-14);
  EXPECT_NEAR(frame.angle, 0.7, 1e-14);
  EXPECT_NEAR(frame.radius, 2 * std::sqrt(5), 1e-13);
  Curve normal = curve;
  normalize(normal, frame, normal);  // in place
  const CurveFrame again = frame_of(normal);
  EXPECT_NEAR(again.radius, 1, 1e-14);
  EXPECT_NEAR(again.angle, 0, 1e-14);
  EXPECT_NEAR(std::hypot(again.center[0], again.center[1]), 0, 1e-14);
  Curve point(3, {2, 2});
  normalize(point, frame_of(point), point);
  EXPECT_EQ(point[1], (PlanePoint{0, 0}));
  const Curve inexact(7, {0.1, 0.3});
  EXPECT_EQ(frame_of(inexact).radius, 0);
  EXPECT_EQ(shape_distance(inexact, Curve(3, {1, 1})), 0);
}

TEST(Curve, ShapesDoNotDependOnPlaces) {
  const Curve target = snail();
  for (const double angle : {0., 1., 2., 3., 4., 6.}) {
    EXPECT_NEAR(shape_distance(moved(target, 0.2, angle, {3, 1}), target), 0, 1e-7) << angle;
  }
  Curve mirrored = target;
  for (PlanePoint& p : mirrored) p[1] = -p[1];
  EXPECT_GT(shape_distance(mirrored, target), 0.02);
  EXPECT_GT(shape_distance(ellipse(2, 1), target), 0.02);
}

TEST(Curve, NoFigureWithoutPoints) {
  const Curve none, unknown = {{kNan, 0}};
  EXPECT_TRUE(std::isnan(timed_distance(none, none)));
  EXPECT_TRUE(std::isnan(nearest_distance(none, snail())));
  EXPECT_TRUE(std::isnan(timed_distance(Curve{{kInfinity, 0}}, Curve{{0, 0}})));
  EXPECT_TRUE(std::isnan(nearest_distance(unknown, snail())));
  EXPECT_TRUE(std::isnan(nearest_distance(snail(), unknown)));
  EXPECT_TRUE(std::isnan(fitted_distance(none, none)));
  EXPECT_TRUE(std::isnan(fitted_distance(unknown, unknown)));
  EXPECT_TRUE(std::isnan(shape_distance(none, snail())));
  EXPECT_TRUE(std::isnan(shape_distance(unknown, snail())));
}

}  // namespace
}  // namespace assur::test
