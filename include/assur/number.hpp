// Numbers of a scene.
#pragma once

#include <array>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <type_traits>

namespace assur {

class Tape;  // for use inside the library

// A number of a scene: a double that may know how it was computed from the values of parameters. It computes like a
// double, and converts from and to one. A table of values (Ensemble) computes the numbers of its members again, without
// their scenes; a number that is converted to double on the way has lost its origin, so that each member of such a
// table is prepared alone.
class Number {
 public:
  // An operation on numbers.
  enum class Operation : std::uint8_t {
    add,
    subtract,
    multiply,
    divide,
    negate,
    fused,      // a b + c, rounded once
    root,       // square root
    length,     // (a^2 + b^2 + c^2)^1/2
    magnitude,  // |a|
    angle,      // atan2(a, b)
  };

  constexpr Number() = default;                      // zero
  constexpr Number(double value) : value_(value) {}  // NOLINT: a double is a number
  operator double() const {                          // NOLINT: a number is a double
    if (origin_ != 0) lose();
    return value_;
  }
  // The value. Unlike the conversion it says that the origin does not matter, e.g. for a message.
  [[nodiscard]] constexpr double value() const { return value_; }

  // True if it knows how it was computed from parameters.
  [[nodiscard]] bool has_origin() const { return origin_ != 0; }

  Number& operator+=(const Number& b) { return *this = Number(value_ + b.value_, Operation::add, *this, b); }
  Number& operator-=(const Number& b) { return *this = Number(value_ - b.value_, Operation::subtract, *this, b); }
  Number& operator*=(const Number& b) { return *this = Number(value_ * b.value_, Operation::multiply, *this, b); }
  Number& operator/=(const Number& b) { return *this = Number(value_ / b.value_, Operation::divide, *this, b); }
  friend Number operator-(const Number& a) { return {-a.value_, Operation::negate, a, 0, 0}; }
  friend Number operator+(const Number& a) { return a; }

  friend Number sqrt(const Number& a) { return {std::sqrt(a.value_), Operation::root, a, 0, 0}; }
  friend Number abs(const Number& a) { return {std::abs(a.value_), Operation::magnitude, a, 0, 0}; }
  friend Number fma(const Number& a, const Number& b, const Number& c) {
    return {std::fma(a.value_, b.value_, c.value_), Operation::fused, a, b, c};
  }
  friend Number hypot(const Number& a, const Number& b, const Number& c) {
    return {std::hypot(a.value_, b.value_, c.value_), Operation::length, a, b, c};
  }
  friend Number atan2(const Number& y, const Number& x) {
    return {std::atan2(y.value_, x.value_), Operation::angle, y, x};
  }
  friend Number ldexp(const Number& a, int exponent) {
    return a.origin_ != 0 ? Number(a) *= std::ldexp(1.0, exponent) : Number(std::ldexp(a.value_, exponent));
  }
  // A table repeats computations with finite numbers only.
  friend bool isfinite(const Number& a) { return std::isfinite(a.value_); }

  // a < b, or a == b. The outcome becomes a condition under which a table repeats the computation.
  static bool is_less(const Number& a, const Number& b) { return compared(a, b, true, a.value_ < b.value_); }
  static bool is_equal(const Number& a, const Number& b) { return compared(a, b, false, a.value_ == b.value_); }

 private:
  friend class Tape;
  Number(double value, std::uint64_t origin) : value_(value), origin_(origin) {}
  Number(double value, Operation op, const Number& a, const Number& b, const Number& c = 0) : value_(value) {
    if ((a.origin_ | b.origin_ | c.origin_) != 0) origin_ = record(op, a, b, c);
  }
  static bool compared(const Number& a, const Number& b, bool is_less, bool outcome) {
    if ((a.origin_ | b.origin_) != 0) note(a, b, is_less, outcome);
    return outcome;
  }
  static std::uint64_t record(Operation op, const Number& a, const Number& b, const Number& c);
  static void note(const Number& a, const Number& b, bool is_less, bool outcome);
  void lose() const;

  double value_ = 0;
  std::uint64_t origin_ = 0;  // which tape, and where on it; 0: none
};

// What computes with a Number in double precision.
template <class T>
concept FitsDouble = std::is_arithmetic_v<T> && !std::same_as<T, long double>;
template <class A, class B>
concept AreNumbers = (std::same_as<A, Number> && (std::same_as<B, Number> || FitsDouble<B>)) ||
                     (FitsDouble<A> && std::same_as<B, Number>);

template <class A, class B>
requires AreNumbers<A, B> Number operator+(const A& a, const B& b) { return Number(a) += b; }
template <class A, class B>
requires AreNumbers<A, B> Number operator-(const A& a, const B& b) { return Number(a) -= b; }
template <class A, class B>
requires AreNumbers<A, B> Number operator*(const A& a, const B& b) { return Number(a) *= b; }
template <class A, class B>
requires AreNumbers<A, B> Number operator/(const A& a, const B& b) { return Number(a) /= b; }
template <class A, class B>
requires AreNumbers<A, B>
bool operator<(const A& a, const B& b) { return Number::is_less(a, b); }
template <class A, class B>
requires AreNumbers<A, B>
bool operator>(const A& a, const B& b) { return Number::is_less(b, a); }
// Not !(b < a), which differs for NaN.
template <class A, class B>
requires AreNumbers<A, B>
bool operator<=(const A& a, const B& b) { return !Number::is_less(b, a) && Number(a).value() <= Number(b).value(); }
template <class A, class B>
requires AreNumbers<A, B>
bool operator>=(const A& a, const B& b) { return b <= a; }
template <class A, class B>
requires AreNumbers<A, B>
bool operator==(const A& a, const B& b) { return Number::is_equal(a, b); }

// A position or direction: x, y, z. In the plane z = 0, SceneBuilder::build() refuses another value.
using Triple = std::array<Number, 3>;

// The same in doubles.
[[nodiscard]] inline std::array<double, 3> values(const Triple& a) { return {a[0], a[1], a[2]}; }

}  // namespace assur
