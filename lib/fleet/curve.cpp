#include "assur/curve.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <string>

#include "assur/status.hpp"
#include "numbers.hpp"

namespace assur {
namespace {

using Curve = std::span<const PlanePoint>;
using Complex = std::complex<double>;

Complex number(const PlanePoint& p) { return {p[0], p[1]}; }

void check_numbers(Curve a, Curve b) {
  if (a.size() == b.size()) return;
  throw Error(Error::Kind::input, "curves of " + std::to_string(a.size()) + " and " + std::to_string(b.size()) +
                                      " points have no distance at equal times");
}

Complex mean_of(Curve curve) {
  Complex sum = 0;
  for (const PlanePoint& p : curve) sum += number(p);
  return sum / static_cast<double>(curve.size());
}

// Sum of the squared distances of the points of a from the nearest points of b.
double nearest_squares(Curve a, Curve b) {
  double sum = 0;
  for (const PlanePoint& p : a) {
    double nearest = kInfinity;
    for (const PlanePoint& q : b) {
      const double dx = p[0] - q[0], dy = p[1] - q[1];
      nearest = std::min(nearest, dx * dx + dy * dy);
    }
    sum += nearest;
  }
  return sum;
}

bool finite(Curve curve) {
  return std::all_of(curve.begin(), curve.end(),
                     [](const PlanePoint& p) { return std::isfinite(p[0]) && std::isfinite(p[1]); });
}

}  // namespace

double timed_distance(Curve a, Curve b) {
  check_numbers(a, b);
  if (!finite(a) || !finite(b)) return kNan;
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::norm(number(a[i]) - number(b[i]));
  return std::sqrt(sum / static_cast<double>(a.size()));
}

double nearest_distance(Curve a, Curve b) {
  if (a.empty() || b.empty() || !finite(a) || !finite(b)) return kNan;
  return std::sqrt((nearest_squares(a, b) + nearest_squares(b, a)) / static_cast<double>(a.size() + b.size()));
}

// In complex numbers: b - mean(b) = factor * (a - mean(a)), in the sense of least squares.
double fitted_distance(Curve a, Curve b) {
  check_numbers(a, b);
  if (a.empty() || !finite(a) || !finite(b)) return kNan;
  const Complex of_a = mean_of(a), of_b = mean_of(b);
  Complex product = 0;
  double square = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    product += std::conj(number(a[i]) - of_a) * (number(b[i]) - of_b);
    square += std::norm(number(a[i]) - of_a);
  }
  const Complex factor = square > 0 ? product / square : 0;
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::norm(number(b[i]) - of_b - factor * (number(a[i]) - of_a));
  return std::sqrt(sum / static_cast<double>(a.size()));
}

// Relative to the first point, so that equal points have the radius 0.
CurveFrame frame_of(Curve curve) {
  if (curve.empty()) return {{kNan, kNan}, kNan, kNan};
  const Complex first = number(curve[0]);
  Complex sum = 0;
  for (const PlanePoint& p : curve) sum += number(p) - first;
  const Complex mean = sum / static_cast<double>(curve.size()), center = first + mean;
  double square = 0;
  Complex twice = 0;  // its angle is twice that of the longest direction
  for (const PlanePoint& p : curve) {
    const Complex z = number(p) - first - mean;
    square += std::norm(z);
    twice += z * z;
  }
  return {{center.real(), center.imag()}, std::sqrt(square / static_cast<double>(curve.size())), std::arg(twice) / 2};
}

void normalize(Curve curve, const CurveFrame& frame, std::span<PlanePoint> to) {
  const Complex center = number(frame.center);
  const Complex factor = frame.radius == 0 ? 0 : std::polar(1 / frame.radius, -frame.angle);
  for (std::size_t i = 0; i < curve.size(); ++i) {
    const Complex z = (number(curve[i]) - center) * factor;
    to[i] = {z.real(), z.imag()};
  }
}

double shape_distance(Curve a, Curve b) {
  std::vector<PlanePoint> p(a.size()), q(b.size());
  normalize(a, frame_of(a), p);
  normalize(b, frame_of(b), q);
  const double as_is = nearest_distance(p, q);
  for (PlanePoint& point : q) point = {-point[0], -point[1]};
  return std::min(as_is, nearest_distance(p, q));
}

}  // namespace assur
