#include "assur/law.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <concepts>
#include <span>
#include <utility>

#include "assur/status.hpp"
#include "scene/law_evaluate.hpp"

namespace assur {
namespace {

[[noreturn]] void refuse(std::string what) { throw Error(Error::Kind::input, std::move(what)); }

std::string text(double number) {  // the shortest text that reads back as the same number
  char digits[32];
  return {digits, std::to_chars(digits, digits + sizeof digits, number).ptr};
}

std::string at(std::string_view array, std::size_t i) { return std::string(array) + "[" + std::to_string(i) + "]"; }

template <class Numbers>
void check_finite(std::string_view array, const Numbers& numbers) {
  using std::isfinite;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (!isfinite(numbers[i])) refuse(at(array, i) + " of a law is not a finite number");
  }
}

void check_table(std::span<const double> time, std::span<const double> value) {
  if (time.size() != value.size()) {
    refuse("a table needs one value for each time, not " + std::to_string(value.size()) + " values for " +
           std::to_string(time.size()) + " times");
  }
  if (time.size() < 2) refuse("a table needs at least 2 rows, not " + std::to_string(time.size()));
  check_finite("time", time);
  check_finite("value", value);
  for (std::size_t i = 1; i < time.size(); ++i) {
    if (time[i] > time[i - 1]) continue;
    refuse("the times of a table must ascend, but " + at("time", i) + " = " + text(time[i]) + " follows " +
           text(time[i - 1]));
  }
}

// Checks that slopes and bends are finite, in the order of their evaluation: times are neither too close nor too far
// apart, and values are not too large.
void check_spline(const Law::Spline& spline) {
  const auto& [time, value, second, periodic, monotone] = spline;
  for (std::size_t i = 1; i < time.size(); ++i) {
    const double length = time[i] - time[i - 1], slope = (value[i] - value[i - 1]) / length;
    const auto [left, right] = spline.bends(i - 1);
    const double bend = length * length * (4 * (std::abs(left) + std::abs(right)));
    if (std::isfinite(slope) && std::isfinite(bend)) continue;
    refuse("no spline in doubles goes through this table between " + at("time", i - 1) + " and " + at("time", i) +
           ": the times are too close to each other or too far apart, or the values too large");
  }
}

// Rows i of lower[i] x[i-1] + diagonal[i] x[i] + upper[i] x[i+1] = right[i], diagonally dominant.
struct Tridiagonal {
  std::vector<double> lower, diagonal, upper, right;  // same size

  explicit Tridiagonal(std::size_t n) : lower(n), diagonal(n), upper(n), right(n) {}
};

// Solves the system by Thomas' algorithm. Each column of `more` is overwritten by its solution.
std::vector<double> solve(Tridiagonal system, std::vector<double>* more = nullptr) {
  const std::size_t n = system.diagonal.size();
  auto& [lower, diagonal, upper, x] = system;
  for (std::size_t i = 1; i < n; ++i) {
    const double factor = lower[i] / diagonal[i - 1];
    diagonal[i] -= factor * upper[i - 1];
    x[i] -= factor * x[i - 1];
    if (more) (*more)[i] -= factor * (*more)[i - 1];
  }
  for (std::size_t i = n; i-- > 0;) {
    x[i] = (x[i] - (i + 1 < n ? upper[i] * x[i + 1] : 0)) / diagonal[i];
    if (more) (*more)[i] = ((*more)[i] - (i + 1 < n ? upper[i] * (*more)[i + 1] : 0)) / diagonal[i];
  }
  return std::move(x);
}

// Length and slope of each interval of a table.
struct Intervals {
  std::vector<double> length, slope;  // points - 1

  Intervals(std::span<const double> time, std::span<const double> value) {
    for (std::size_t i = 0; i + 1 < time.size(); ++i) {
      length.push_back(time[i + 1] - time[i]);
      slope.push_back((value[i + 1] - value[i]) / length.back());
    }
  }
};

// Row of the continuous first derivative at the knot between intervals `left` and `right`.
void set_row(Tridiagonal& system, std::size_t row, const Intervals& in, std::size_t left, std::size_t right) {
  system.lower[row] = in.length[left];
  system.diagonal[row] = 2 * (in.length[left] + in.length[right]);
  system.upper[row] = in.length[right];
  system.right[row] = 6 * (in.slope[right] - in.slope[left]);
}

// Second derivatives at the knots; the third derivative is continuous at the second knot and the last but one.
std::vector<double> not_a_knot(std::span<const double> time, std::span<const double> value) {
  const std::size_t n = time.size();
  const Intervals in(time, value);
  const auto& h = in.length;
  if (n == 2) return {0, 0};
  if (n == 3) return std::vector<double>(3, 2 * (in.slope[1] - in.slope[0]) / (h[0] + h[1]));

  Tridiagonal inner(n - 2);  // knots 1 .. n-2; the end knots are eliminated, their rows scaled by h1 / (h0 + h1)
  for (std::size_t i = 0; i < n - 2; ++i) set_row(inner, i, in, i, i + 1);
  const double h0 = h[0], h1 = h[1], g0 = h[n - 2], g1 = h[n - 3];
  inner.diagonal.front() = 2 * h1 + h0;
  inner.upper.front() = h1 - h0;
  inner.right.front() *= h1 / (h0 + h1);
  inner.diagonal.back() = 2 * g1 + g0;
  inner.lower.back() = g1 - g0;
  inner.right.back() *= g1 / (g0 + g1);

  const std::vector<double> m = solve(std::move(inner));
  std::vector<double> second(n);
  std::copy(m.begin(), m.end(), second.begin() + 1);
  second[0] = second[1] + (second[1] - second[2]) * (h0 / h1);
  second[n - 1] = second[n - 2] + (second[n - 2] - second[n - 3]) * (g0 / g1);
  return second;
}

// Second derivatives of the closed spline: knots 1 .. n-1 as a + b * (that of knot 0), then the row of knot 0.
std::vector<double> closed(std::span<const double> time, std::span<const double> value) {
  const Intervals in(time, value);
  const std::size_t intervals = in.length.size();
  if (intervals == 1) return {0, 0};

  Tridiagonal inner(intervals - 1);
  for (std::size_t i = 0; i + 1 < intervals; ++i) set_row(inner, i, in, i, i + 1);
  std::vector<double> b(intervals - 1, 0.0);
  b.front() -= inner.lower.front();
  b.back() -= inner.upper.back();
  const std::vector<double> a = solve(std::move(inner), &b);

  const double last = in.length.back(), first = in.length.front();
  const double right = 6 * (in.slope.front() - in.slope.back()) - last * a.back() - first * a.front();
  const double m0 = right / (2 * (last + first) + last * b.back() + first * b.front());
  std::vector<double> second{m0};
  for (std::size_t i = 0; i < a.size(); ++i) second.push_back(a[i] + b[i] * m0);
  second.push_back(m0);
  return second;
}

// The slope at a knot between two intervals with these lengths and slopes: 0 where the table turns around, else their
// harmonic mean (Fritsch and Butland 1984, with the weights of Brodlie).
double monotone_slope(double h0, double h1, double s0, double s1) {
  if (!(s0 * s1 > 0)) return 0;
  const double w0 = 2 * h1 + h0, w1 = h1 + 2 * h0;
  return (w0 + w1) / (w0 / s0 + w1 / s1);
}

// The slope of the parabola through three knots at the first one, within the bounds of monotone cubics.
double slope_at_end(double h0, double h1, double s0, double s1) {
  const double slope = s0 + h0 / (h0 + h1) * (s0 - s1);
  if (!(slope * s0 > 0)) return 0;
  return s0 * s1 <= 0 && std::abs(slope) > 3 * std::abs(s0) ? 3 * s0 : slope;
}

// Second derivatives at both ends of each interval of the monotone interpolation.
std::vector<double> monotone_bends(std::span<const double> time, std::span<const double> value, bool periodic) {
  const Intervals in(time, value);
  const auto &h = in.length, &s = in.slope;
  const std::size_t n = time.size(), last = n - 2;
  std::vector<double> slope(n);
  for (std::size_t i = 1; i + 1 < n; ++i) slope[i] = monotone_slope(h[i - 1], h[i], s[i - 1], s[i]);
  if (periodic) {
    slope[0] = slope[n - 1] = monotone_slope(h[last], h[0], s[last], s[0]);
  } else if (n == 2) {
    slope[0] = slope[1] = s[0];
  } else {
    slope[0] = slope_at_end(h[0], h[1], s[0], s[1]);
    slope[n - 1] = slope_at_end(h[last], h[last - 1], s[last], s[last - 1]);
  }
  std::vector<double> second;
  for (std::size_t i = 0; i + 1 < n; ++i) {
    second.push_back((6 * s[i] - 4 * slope[i] - 2 * slope[i + 1]) / h[i]);
    second.push_back((4 * slope[i + 1] + 2 * slope[i] - 6 * s[i]) / h[i]);
  }
  return second;
}

struct IsConstant {
  bool operator()(const Law::Polynomial& p) const {
    return std::all_of(p.coefficients.begin() + (p.coefficients.empty() ? 0 : 1), p.coefficients.end(),
                       [](const Number& c) { return c == 0; });
  }
  bool operator()(const Law::Harmonics& h) const {
    return std::all_of(h.terms.begin(), h.terms.end(),
                       [](const Harmonic& term) { return term.amplitude == 0 || term.frequency == 0; });
  }
  bool operator()(const Law::Spline& s) const {
    return std::all_of(s.value.begin(), s.value.end(), [&](double v) { return v == s.value.front(); });
  }
  bool operator()(const Law::Function&) const { return false; }
};

}  // namespace

Law Law::constant(const Number& value) { return polynomial({value}); }

Law Law::polynomial(std::vector<Number> coefficients) {
  check_finite("polynomial", coefficients);
  return Law({Polynomial{std::move(coefficients)}});
}

Law Law::harmonics(std::vector<Harmonic> terms, const Number& offset) {
  check_finite("offset", std::span(&offset, 1));
  for (const Harmonic& term : terms) {
    if (!(isfinite(term.amplitude) && isfinite(term.frequency) && isfinite(term.phase))) {
      refuse(at("harmonics", static_cast<std::size_t>(&term - terms.data())) +
             " of a law has an amplitude, frequency or phase that is not a finite number");
    }
  }
  return Law({Harmonics{std::move(terms), offset}});
}

Law Law::table(std::vector<double> time, std::vector<double> value, bool periodic) {
  return table(std::move(time), std::move(value), periodic, false);
}

Law Law::table(std::vector<double> time, std::vector<double> value, bool periodic, bool monotone) {
  check_table(time, value);
  if (periodic) {
    double largest = 0;
    for (double v : value) largest = std::max(largest, std::abs(v));
    if (std::abs(value.back() - value.front()) > 1e-12 * largest) {
      refuse("a periodic table must end with its first value, " + text(value.front()) + ", not with " +
             text(value.back()));
    }
    value.back() = value.front();  // removes the rounding of a computed table
  }
  std::vector<double> second = monotone   ? monotone_bends(time, value, periodic)
                               : periodic ? closed(time, value)
                                          : not_a_knot(time, value);
  Spline spline{std::move(time), std::move(value), std::move(second), periodic, monotone};
  check_spline(spline);
  return Law({std::move(spline)});
}

Law Law::function(std::function<Motion(double)> motion, double tolerance) {
  if (!motion) refuse("the function of a law is empty");
  if (!(tolerance >= 0)) refuse("the tolerance of a law is a relative error such as 1e-5, not " + text(tolerance));
  return Law({Function{std::move(motion), tolerance}});
}

Law operator+(const Law& a, const Law& b) {
  std::vector<Law::Part> parts = a.parts();
  parts.insert(parts.end(), b.parts().begin(), b.parts().end());
  return Law(std::move(parts));
}

bool operator==(const Law& a, const Law& b) {
  const auto equal = [](const Law::Part& x, const Law::Part& y) {
    return std::visit(
        [](const auto& p, const auto& q) {
          if constexpr (std::equality_comparable_with<decltype(p), decltype(q)>) {
            return p == q;
          } else {
            return false;
          }
        },
        x, y);
  };
  return a.parts_ == b.parts_ ||
         std::equal(a.parts().begin(), a.parts().end(), b.parts().begin(), b.parts().end(), equal);
}

Motion Law::operator()(double t) const { return evaluate(*this, t); }

bool Law::is_constant() const {
  return std::all_of(parts().begin(), parts().end(), [](const Part& part) { return std::visit(IsConstant{}, part); });
}

bool Law::covers(double t) const {
  return std::all_of(parts().begin(), parts().end(), [&](const Part& part) {
    const auto* spline = std::get_if<Spline>(&part);
    return !spline || law_detail::covers(*spline, t);
  });
}

}  // namespace assur
