// Midpoint-radius arithmetic: a Ball contains every real number within `radius` of `middle`, and the result of an
// operation holds all results that its operands allow. Middles are rounded to nearest; the radius, a double rounded up,
// includes the rounding error (Rump, Fast and parallel interval arithmetic, BIT 39, 1999).
#pragma once

#include <cmath>
#include <limits>
#include <utility>

#include "numbers.hpp"

namespace assur {

// At least the next double after x >= 0: an upper bound of every number that rounds to x.
[[nodiscard]] constexpr double up(double x) { return x * (1 + kEps) + std::numeric_limits<double>::denorm_min(); }
// At most the double before x >= 0.
[[nodiscard]] constexpr double down(double x) { return x * (1 - kEps) - std::numeric_limits<double>::denorm_min(); }

// S: a binary floating-point type whose sums, products and quotients are exact up to a unit in the last place (double,
// quad). A NaN operand, or a division by a ball that holds 0, gives a radius that is infinite or NaN. Comparisons
// compare the middles.
template <class S>
class Ball {
 public:
  Ball(double exact = 0) : middle_(exact) {}  // NOLINT(google-explicit-constructor): a number like any other
  Ball(S middle, double radius) : middle_(std::move(middle)), radius_(radius) {}

  // Unit roundoff of S, with a factor of two to spare.
  static constexpr double unit() {
    double u = 2;
    for (int i = 0; i < std::numeric_limits<S>::digits; ++i) u /= 2;
    return u;
  }

  [[nodiscard]] const S& middle() const { return middle_; }
  [[nodiscard]] double radius() const { return radius_; }
  // An upper bound of |x| for every x in the ball.
  [[nodiscard]] double magnitude() const { return up(up_abs(middle_) + radius_); }
  explicit operator double() const { return static_cast<double>(middle_); }

  friend Ball operator-(const Ball& a) { return {-a.middle_, a.radius_}; }
  friend Ball operator+(const Ball& a, const Ball& b) { return rounded(a.middle_ + b.middle_, a.radius_ + b.radius_); }
  friend Ball operator-(const Ball& a, const Ball& b) { return rounded(a.middle_ - b.middle_, a.radius_ + b.radius_); }
  friend Ball operator*(const Ball& a, const Ball& b) {
    return rounded(a.middle_ * b.middle_, up(up_abs(a.middle_) * b.radius_) + up(a.radius_ * b.magnitude()));
  }
  // The radius is infinite if b holds 0.
  friend Ball operator/(const Ball& a, const Ball& b) {
    const S quotient = a.middle_ / b.middle_;
    const double least = down(down(std::abs(static_cast<double>(b.middle_))) - b.radius_);
    if (!(least > 0)) return {quotient, kInfinity};
    return rounded(quotient, up(up(a.radius_ + up(up_abs(quotient) * b.radius_)) / least));
  }
  Ball& operator+=(const Ball& b) { return *this = *this + b; }

  friend bool operator<(const Ball& a, const Ball& b) { return a.middle_ < b.middle_; }
  friend bool operator>(const Ball& a, const Ball& b) { return a.middle_ > b.middle_; }
  friend bool operator<=(const Ball& a, const Ball& b) { return a.middle_ <= b.middle_; }
  friend bool operator>=(const Ball& a, const Ball& b) { return a.middle_ >= b.middle_; }

 private:
  static double up_abs(const S& x) { return up(std::abs(static_cast<double>(x))); }
  static Ball rounded(S middle, double radius) {
    const double lost = up(unit() * up_abs(middle));
    return {std::move(middle), up(up(radius) + lost)};
  }

  S middle_;
  double radius_ = 0;
};

// Elementary functions. Assumption: the functions of S have errors of at most 2^13 units in the last place of the
// larger of 1 and the argument. No library proves a bound; known implementations are a thousand times more exact.
template <class S>
double elementary_error(const Ball<S>& a) {
  return up(0x1p13 * Ball<S>::unit() * up(1 + a.magnitude()));
}
template <class S>
Ball<S> sin(const Ball<S>& a) {
  using std::sin;
  return {sin(a.middle()), up(a.radius() + elementary_error(a))};
}
template <class S>
Ball<S> cos(const Ball<S>& a) {
  using std::cos;
  return {cos(a.middle()), up(a.radius() + elementary_error(a))};
}
// For exact arguments; for other ones the radius is infinite.
template <class S>
Ball<S> atan2(const Ball<S>& y, const Ball<S>& x) {
  using std::atan2;
  const bool exact = y.radius() == 0 && x.radius() == 0;
  return {atan2(y.middle(), x.middle()), exact ? elementary_error(Ball<S>(1)) : HUGE_VAL};
}
// An integer close to `a`, which counts the whole periods of a periodic function; any such integer serves.
template <class S>
Ball<S> floor(const Ball<S>& a) {
  using std::floor;
  return {floor(a.middle()), 0};
}

}  // namespace assur
