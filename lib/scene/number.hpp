// A double that records its operations if a tape is active on this thread. Code that computes constants of a mechanism
// from its scene uses it instead of double.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>

#include "assur/scene.hpp"
#include "scene/tape.hpp"

namespace assur {

class Number {
 public:
  Number() = default;
  // A double of the scene, or a literal.
  Number(double value) : value_(value), node_(Tape::active() != nullptr ? Tape::active()->find(value) : Tape::kNone) {}
  [[nodiscard]] double value() const { return value_; }
  [[nodiscard]] Tape::Node node() const { return node_; }

  friend Number operator+(const Number& a, const Number& b) { return {a.value_ + b.value_, Tape::Kind::add, a, b}; }
  friend Number operator-(const Number& a, const Number& b) {
    return {a.value_ - b.value_, Tape::Kind::subtract, a, b};
  }
  friend Number operator*(const Number& a, const Number& b) {
    return {a.value_ * b.value_, Tape::Kind::multiply, a, b};
  }
  friend Number operator/(const Number& a, const Number& b) { return {a.value_ / b.value_, Tape::Kind::divide, a, b}; }
  friend Number operator-(const Number& a) { return {-a.value_, Tape::Kind::negate, a}; }
  Number& operator+=(const Number& b) { return *this = *this + b; }
  Number& operator-=(const Number& b) { return *this = *this - b; }
  friend Number sqrt(const Number& a) { return {std::sqrt(a.value_), Tape::Kind::root, a}; }
  friend Number abs(const Number& a) { return {std::abs(a.value_), Tape::Kind::magnitude, a}; }
  friend Number fma(const Number& a, const Number& b, const Number& c) {
    return {std::fma(a.value_, b.value_, c.value_), Tape::Kind::fused, a, b, c};
  }
  friend Number hypot(const Number& a, const Number& b, const Number& c) {
    return {std::hypot(a.value_, b.value_, c.value_), Tape::Kind::length, a, b, c};
  }
  friend Number atan2(const Number& y, const Number& x) {
    return {std::atan2(y.value_, x.value_), Tape::Kind::angle, y, x};
  }
  friend Number ldexp(const Number& a, int exponent) {
    return a.node_ >= 0 ? a * std::ldexp(1.0, exponent) : Number(std::ldexp(a.value_, exponent));
  }
  // The tape replays only finite numbers, so that no guard is needed.
  friend bool isfinite(const Number& a) { return std::isfinite(a.value_); }

  friend bool operator<(const Number& a, const Number& b) { return compared(a, b, true, a.value_ < b.value_); }
  friend bool operator>(const Number& a, const Number& b) { return b < a; }
  // Not !(b < a), which differs for NaN.
  friend bool operator<=(const Number& a, const Number& b) {
    if (a.node_ < 0 && b.node_ < 0) return a.value_ <= b.value_;
    return !(b < a) && a.value_ <= b.value_;
  }
  friend bool operator>=(const Number& a, const Number& b) { return b <= a; }
  friend bool operator==(const Number& a, const Number& b) { return compared(a, b, false, a.value_ == b.value_); }

 private:
  Number(double value, Tape::Kind kind, const Number& a) : value_(value) {
    if (a.node_ >= 0) node_ = Tape::active()->record(kind, value, {kind, a.node_});
  }
  Number(double value, Tape::Kind kind, const Number& a, const Number& b) : value_(value) {
    if ((a.node_ & b.node_) >= 0) node_ = Tape::active()->record(kind, value, {kind, a.place(), b.place()});
  }
  Number(double value, Tape::Kind kind, const Number& a, const Number& b, const Number& c) : value_(value) {
    if ((a.node_ & b.node_ & c.node_) >= 0) {
      node_ = Tape::active()->record(kind, value, {kind, a.place(), b.place(), c.place()});
    }
  }
  [[nodiscard]] Tape::Node place() const { return node_ >= 0 ? node_ : Tape::active()->literal(value_); }
  static bool compared(const Number& a, const Number& b, bool is_less, bool outcome) {
    if ((a.node_ & b.node_) >= 0) Tape::active()->compare({a.place(), b.place(), is_less, outcome});
    return outcome;
  }

  double value_ = 0;
  Tape::Node node_ = Tape::kNone;
};

// A position or direction in numbers.
using Numbers = std::array<Number, 3>;
[[nodiscard]] inline Numbers numbers(const Triple& a) { return {a[0], a[1], a[2]}; }
[[nodiscard]] inline Triple values(const Numbers& a) { return {a[0].value(), a[1].value(), a[2].value()}; }

}  // namespace assur
