#include "scene/own_values.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "index.hpp"
#include "numbers.hpp"
#include "scene/drive.hpp"
#include "scene/names.hpp"
#include "scene/recorded.hpp"

namespace assur {
namespace {

using Kind = DriverInput::Kind;

// If a direction is within this angle of the axis, in rad, postures do not determine its angle about the axis.
constexpr double kNoLever = 1e-6;
constexpr double kNoLength = 1e-12;  // length relative to the coordinates whose difference is the direction

// N: a Number, or a double where no tape records
template <class N>
using Three = std::array<N, 3>;
template <class N>
N dot(const Three<N>& a, const Three<N>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
template <class N>
Three<N> cross(const Three<N>& a, const Three<N>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
template <class N>
N norm(const Three<N>& a) {
  using std::hypot;
  return hypot(a[0], a[1], a[2]);
}
double plain(double x) { return x; }
double plain(const Number& x) { return x.value(); }

template <class N>
N value_of(const System& s, Index form, std::span<const double> q) {
  N sum = 0;
  for (const Term& t : s.form(form)) sum += N(s.constants[idx(t.constant)]) * N(q[idx(t.coordinate)]);
  return sum;
}

template <class N>
N size_of(const System& s, Index form, std::span<const double> q) {
  using std::abs;
  N sum = 0;
  for (const Term& t : s.form(form)) sum += abs(N(s.constants[idx(t.constant)]) * N(q[idx(t.coordinate)]));
  return sum;
}

template <class N>
struct Direction {
  Three<N> at{};
  N size = 0;  // of its terms
};

template <class N = Number>
Direction<N> direction(const System& s, const DriverInput& in, std::size_t first, std::span<const double> q) {
  Direction<N> out;
  for (std::size_t k = 0; k < idx(s.dimension); ++k) {
    const Index f = in.own[first + k];
    out.at[k] = value_of<N>(s, f, q);
    out.size = std::max(out.size, size_of<N>(s, f, q));
  }
  return out;
}

template <class N = Number>
struct Arms {
  Direction<N> d, e;
  Three<N> axis;
  N cosine, sine;  // times |d||e|
  N d_length, e_length, lever;
};

template <class N = Number>
Arms<N> arms(const System& s, const DriverInput& in, std::span<const double> q) {
  using std::hypot;
  const std::size_t dim = idx(s.dimension);
  Arms<N> a{direction<N>(s, in, 0, q), direction<N>(s, in, dim, q), {0, 0, 1}, 0, 0, 0, 0, 0};
  if (dim == 3) a.axis = direction<N>(s, in, 2 * dim, q).at;
  a.cosine = dot(a.d.at, a.e.at);
  a.sine = dot(a.axis, cross(a.d.at, a.e.at));
  a.d_length = norm(a.d.at);
  a.e_length = norm(a.e.at);
  a.lever = hypot(a.cosine, a.sine, N(0));
  return a;
}

Number scalar(const System& s, const DriverInput& in, std::span<const double> q, Number& size) {
  if (in.own.size() > 1) {
    const Direction<Number> d = direction(s, in, 0, q);
    size = d.size;
    return recorded::norm(d.at);
  }
  size = size_of<Number>(s, in.own[0], q);
  return value_of<Number>(s, in.own[0], q);
}

// Columns of the body's frame, with their uncertainty.
struct Axes {
  Numbers column[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  Number slack = 1;  // times the relative slack
};

Axes own_axes(const System& s, const DriverInput& in, std::span<const double> q) {
  const std::size_t dim = idx(s.dimension), count = in.own.size() / dim - 1;
  Axes out;
  Numbers a[3];
  for (std::size_t j = 0; j < count; ++j) {
    const Direction<Number> d = direction(s, in, (j + 1) * dim, q);
    const Number length = recorded::norm(d.at);
    a[j] = recorded::scale(1 / length, d.at);
    out.slack += d.size / length;
  }
  if (dim == 2) {
    out.column[0] = a[0];
    out.column[1] = {-a[0][1], a[0][0], 0};
  } else if (count == 3) {
    std::copy_n(a, 3, out.column);
  } else {  // a base of three points
    const Numbers normal = recorded::cross(a[0], a[1]);
    out.slack = out.slack / recorded::norm(normal);
    out.column[0] = a[0];
    out.column[2] = recorded::scale(1 / recorded::norm(normal), normal);
    out.column[1] = recorded::cross(out.column[2], out.column[0]);
  }
  return out;
}

Axes wanted_axes(const System& s, const DriverInput& in, std::span<const double> q) {
  Axes out;
  const double* const r = q.data() + in.first + s.dimension;
  if (s.dimension == 2) {
    out.column[0] = {r[0], r[1], 0};
    out.column[1] = {-r[1], r[0], 0};
  } else {
    for (int j = 0; j < 3; ++j) out.column[j] = {r[3 * j], r[3 * j + 1], r[3 * j + 2]};
  }
  return out;
}

// psi, theta, phi of Rz(psi) Ry(theta) Rx(phi); in the plane the angle.
void append_angles(const System& s, const Axes& axes, std::vector<double>& out) {
  const Numbers &a = axes.column[0], &b = axes.column[1], &c = axes.column[2];
  out.push_back(atan2(a[1], a[0]).value());
  if (s.dimension == 2) return;
  out.push_back(atan2(-a[2], hypot(a[0], a[1], 0)).value());
  out.push_back(atan2(b[2], c[2]).value());
}

bool turns(const System& s, const DriverInput& in) { return in.kind == Kind::frame && in.count > s.dimension; }

template <class N>
std::string why_undefined(const Arms<N>& a) {
  using std::abs;
  const N &d = a.d_length, &e = a.e_length;
  if (!(d > kNoLength * a.d.size)) return "its first direction has no length";
  if (!(e > kNoLength * a.e.size)) return "its second direction has no length";
  if (!(abs(norm(a.axis) - 1) <= kNoLever)) return "its axis is not a unit vector";
  if (a.lever > kNoLever * d * e) return "";
  if (!(norm(cross(a.axis, a.d.at)) > kNoLever * d)) return "its axis is parallel to its first direction";
  if (!(norm(cross(a.axis, a.e.at)) > kNoLever * e)) return "its axis is parallel to its second direction";
  return "its directions are at right angles to each other, and its axis lies in their plane";
}

// True if the angle of a direction is the prescribed one.
template <class N>
bool has_angle(const DriverInput& in, const Arms<N>& a, std::span<const double> q, double slack) {
  using std::atan2;
  const double* const x = q.data() + in.first;
  const double off = std::remainder(plain(atan2(a.sine, a.cosine)) - std::atan2(x[1], x[0]), 2 * std::numbers::pi);
  return std::abs(off) <= slack * plain(1 + (a.d.size * a.e_length + a.d_length * a.e.size) / a.lever);
}

template <class N>
bool has_its_angle(const System& s, const DriverInput& in, std::span<const double> q, double slack) {
  const Arms<N> a = arms<N>(s, in, q);
  return why_undefined(a).empty() && has_angle(in, a, q, slack);
}

// The law whose value differs most from the prescribed one, as mismatch(); empty: none does.
std::optional<std::size_t> wrong_law(const System& s, const DriverInput& in, std::span<const double> q, double slack) {
  const double* const x = q.data() + in.first;
  if (in.kind == Kind::direction)
    return has_angle(in, arms(s, in, q), q, slack) ? std::nullopt : std::optional(std::size_t{0});
  if (in.kind == Kind::scalar) {
    Number size = 0;
    const double unit = s.unit(in.dimension), wanted = x[0] * unit,
                 off = (scalar(s, in, q, size) * unit).value() - wanted;
    const double rounding = 16 * kEps * unit;  // a coordinate may be 0 but for rounding
    const bool is_right = std::abs(off) <= slack * (size.value() * unit + std::abs(wanted)) + rounding;
    return is_right ? std::nullopt : std::optional(std::size_t{0});
  }
  const double unit = s.unit(1);
  for (std::size_t k = 0; k < idx(s.dimension); ++k) {
    const double has = (value_of<Number>(s, in.own[k], q) * unit).value(), wanted = x[k] * unit;
    if (!(std::abs(has - wanted) <= slack * (unit + std::abs(has) + std::abs(wanted)))) return k;
  }
  if (!turns(s, in)) return {};
  // Compares axes, because close to theta = pi / 2 the angles are badly determined.
  const Axes own = own_axes(s, in, q), asked = wanted_axes(s, in, q);
  double worst = 0;
  for (int j = 0; j < 3; ++j) {
    const double apart = recorded::norm(recorded::subtract(own.column[j], asked.column[j])).value();
    if (!(apart <= worst)) worst = apart;
  }
  if (worst <= slack * own.slack.value()) return {};
  const std::vector<double> off = difference(s, in, own_values(s, in, q), wanted_values(s, in, q));
  std::size_t most = idx(s.dimension);
  for (std::size_t k = most + 1; k < off.size(); ++k) {
    if (std::abs(off[k]) > std::abs(off[most])) most = k;
  }
  return most;
}

}  // namespace

bool is_angle(const System& s, const DriverInput& in, std::size_t law) {
  return in.kind == Kind::direction || (in.kind == Kind::frame && law >= idx(s.dimension));
}

std::vector<double> own_values(const System& s, const DriverInput& in, std::span<const double> q) {
  Number size = 0;
  if (in.kind == Kind::scalar) return {(scalar(s, in, q, size) * s.unit(in.dimension)).value()};
  if (in.kind == Kind::direction) {
    const Arms<Number> a = arms(s, in, q);
    return {atan2(a.sine, a.cosine).value()};
  }
  std::vector<double> out;
  for (Index k = 0; k < s.dimension; ++k) out.push_back((value_of<Number>(s, in.own[idx(k)], q) * s.unit(1)).value());
  if (turns(s, in)) append_angles(s, own_axes(s, in, q), out);
  return out;
}

std::vector<double> written_values(const System& s, const DriverInput& in, std::span<const double> q) {
  std::vector<double> out = own_values(s, in, q);
  Number size = 0;
  if (in.kind == Kind::direction && !why_undefined(s, in, q).empty()) out[0] = kNan;
  if (in.must_not_vanish && !(scalar(s, in, q, size) > kNoLength * size)) out[0] = kNan;
  if (turns(s, in) && s.dimension == 3) {
    const Numbers a = own_axes(s, in, q).column[0];
    if (!(hypot(a[0], a[1], 0) > kNoLever)) out[3] = out[5] = kNan;
  }
  return out;
}

std::vector<double> wanted_values(const System& s, const DriverInput& in, std::span<const double> q) {
  const double* const x = q.data() + in.first;
  if (in.kind == Kind::scalar) return {x[0] * s.unit(in.dimension)};
  if (in.kind == Kind::direction) return {std::atan2(x[1], x[0])};
  std::vector<double> out;
  for (Index k = 0; k < s.dimension; ++k) out.push_back(x[k] * s.unit(1));
  if (turns(s, in)) append_angles(s, wanted_axes(s, in, q), out);
  return out;
}

std::vector<double> difference(const System& s, const DriverInput& in, const std::vector<double>& a,
                               const std::vector<double>& b) {
  std::vector<double> out(a.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    out[k] = is_angle(s, in, k) ? std::remainder(a[k] - b[k], 2 * std::numbers::pi) : a[k] - b[k];
  }
  return out;
}

void drive_by_values(const System& s, const std::vector<std::vector<double>>& values, std::vector<double>& q) {
  drive<double>(
      s, all_driven(s),
      [&](std::size_t input, int k) {
        return Jet<double>{values[input][idx(k)], 0, 0};
      },
      q.data(), nullptr, nullptr);
}

std::string why_undefined(const System& s, const DriverInput& in, std::span<const double> q) {
  return in.kind == Kind::direction ? why_undefined(arms(s, in, q)) : "";
}

std::optional<Mismatch> mismatch(const System& s, const DriverInput& in, std::span<const double> q, double slack) {
  const std::optional<std::size_t> wrong = wrong_law(s, in, q, slack);
  if (!wrong) return {};
  const double has = own_values(s, in, q)[*wrong], wanted = wanted_values(s, in, q)[*wrong];
  if (in.kind == Kind::scalar) {
    return Mismatch{in.must_not_vanish ? "distance" : "coordinate", has, wanted, in.dimension == 1 ? "m" : ""};
  }
  if (in.kind == Kind::direction) return Mismatch{"angle", has, wanted, "rad"};
  return Mismatch{pose_part(*wrong, s.dimension), has, wanted, *wrong < idx(s.dimension) ? "m" : "rad"};
}

bool has_its_value(const System& s, const DriverInput& in, std::span<const double> q, double slack) {
  if (in.kind != Kind::direction) return !wrong_law(s, in, q, slack);
  return Tape::active() == nullptr ? has_its_angle<double>(s, in, q, slack) : has_its_angle<Number>(s, in, q, slack);
}

}  // namespace assur
