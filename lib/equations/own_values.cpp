#include "equations/own_values.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <numbers>

#include "equations/drive.hpp"
#include "index.hpp"
#include "numbers.hpp"
#include "scene/names.hpp"

namespace assur {
namespace {

using Kind = DriverInput::Kind;

// If a direction is within this angle of the axis, in rad, postures do not determine its angle about the axis.
constexpr double kNoLever = 1e-6;
constexpr double kNoLength = 1e-12;  // length relative to the coordinates whose difference is the direction

// N: double, or Number for the posture as written
template <class N>
using Three = std::array<N, 3>;
template <class N>
using Posture = std::span<const N>;
template <class N>
N dot(const Three<N>& a, const Three<N>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
template <class N>
Three<N> cross(const Three<N>& a, const Three<N>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
template <class N>
Three<N> scale(const N& s, const Three<N>& a) {
  return {s * a[0], s * a[1], s * a[2]};
}
template <class N>
N norm(const Three<N>& a) {
  using std::hypot;
  return hypot(a[0], a[1], a[2]);
}

template <class N>
N constant(const System& s, Index c) {
  if constexpr (std::same_as<N, double>) {
    return s.constants[idx(c)];
  } else {
    return s.constant(c);
  }
}

template <class N>
N value_of(const System& s, Index form, Posture<N> q) {
  N sum = 0;
  for (const Term& t : s.form(form)) sum += constant<N>(s, t.constant) * q[idx(t.coordinate)];
  return sum;
}

template <class N>
N size_of(const System& s, Index form, Posture<N> q) {
  using std::abs;
  N sum = 0;
  for (const Term& t : s.form(form)) sum += abs(constant<N>(s, t.constant) * q[idx(t.coordinate)]);
  return sum;
}

template <class N>
struct Direction {
  Three<N> at{};
  N size = 0;  // of its terms
};

template <class N>
Direction<N> direction(const System& s, const DriverInput& in, std::size_t first, Posture<N> q) {
  Direction<N> out;
  for (std::size_t k = 0; k < idx(s.dimension); ++k) {
    const Index f = in.own[first + k];
    out.at[k] = value_of<N>(s, f, q);
    out.size = std::max(out.size, size_of<N>(s, f, q));
  }
  return out;
}

template <class N>
struct Arms {
  Direction<N> d, e;
  Three<N> axis;
  N cosine, sine;  // times |d||e|
  N d_length, e_length, lever;
};

template <class N>
Arms<N> arms(const System& s, const DriverInput& in, Posture<N> q) {
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

template <class N>
N scalar(const System& s, const DriverInput& in, Posture<N> q, N& size) {
  if (in.own.size() > 1) {
    const Direction<N> d = direction<N>(s, in, 0, q);
    size = d.size;
    return norm(d.at);
  }
  size = size_of<N>(s, in.own[0], q);
  return value_of<N>(s, in.own[0], q);
}

// Columns of the body's frame, with their uncertainty.
template <class N>
struct Axes {
  Three<N> column[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  N slack = 1;  // times the relative slack
};

template <class N>
Axes<N> own_axes(const System& s, const DriverInput& in, Posture<N> q) {
  const std::size_t dim = idx(s.dimension), count = in.own.size() / dim - 1;
  Axes<N> out;
  Three<N> a[3];
  for (std::size_t j = 0; j < count; ++j) {
    const Direction<N> d = direction<N>(s, in, (j + 1) * dim, q);
    const N length = norm(d.at);
    a[j] = scale<N>(1 / length, d.at);
    out.slack += d.size / length;
  }
  if (dim == 2) {
    out.column[0] = a[0];
    out.column[1] = {-a[0][1], a[0][0], 0};
  } else if (count == 3) {
    std::copy_n(a, 3, out.column);
  } else {  // a base of three points
    const Three<N> normal = cross(a[0], a[1]);
    out.slack = out.slack / norm(normal);
    out.column[0] = a[0];
    out.column[2] = scale<N>(1 / norm(normal), normal);
    out.column[1] = cross(out.column[2], out.column[0]);
  }
  return out;
}

Axes<double> wanted_axes(const System& s, const DriverInput& in, std::span<const double> q) {
  Axes<double> out;
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
template <class N>
void append_angles(const System& s, const Axes<N>& axes, std::vector<N>& out) {
  using std::atan2;
  using std::hypot;
  const Three<N>&a = axes.column[0], &b = axes.column[1], &c = axes.column[2];
  out.push_back(atan2(a[1], a[0]));
  if (s.dimension == 2) return;
  out.push_back(atan2(-a[2], hypot(a[0], a[1], N(0))));
  out.push_back(atan2(b[2], c[2]));
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
bool has_angle(const DriverInput& in, const Arms<double>& a, std::span<const double> q, double slack) {
  const double* const x = q.data() + in.first;
  const double off = std::remainder(std::atan2(a.sine, a.cosine) - std::atan2(x[1], x[0]), 2 * std::numbers::pi);
  return std::abs(off) <= slack * (1 + (a.d.size * a.e_length + a.d_length * a.e.size) / a.lever);
}

template <class N>
std::vector<N> values_of(const System& s, const DriverInput& in, Posture<N> q) {
  using std::atan2;
  N size = 0;
  if (in.kind == Kind::scalar) return {scalar(s, in, q, size) * s.unit(in.dimension)};
  if (in.kind == Kind::direction) {
    const Arms<N> a = arms(s, in, q);
    return {atan2(a.sine, a.cosine)};
  }
  std::vector<N> out;
  for (Index k = 0; k < s.dimension; ++k) out.push_back(value_of(s, in.own[idx(k)], q) * s.unit(1));
  if (turns(s, in)) append_angles(s, own_axes(s, in, q), out);
  return out;
}

// The law whose value differs most from the prescribed one, as mismatch(); empty: none does.
std::optional<std::size_t> wrong_law(const System& s, const DriverInput& in, std::span<const double> q, double slack) {
  const double* const x = q.data() + in.first;
  if (in.kind == Kind::direction)
    return has_angle(in, arms<double>(s, in, q), q, slack) ? std::nullopt : std::optional(std::size_t{0});
  if (in.kind == Kind::scalar) {
    double size = 0;
    const double unit = s.unit(in.dimension), wanted = x[0] * unit, off = scalar(s, in, q, size) * unit - wanted;
    const double rounding = 16 * kEps * unit;  // a coordinate may be 0 but for rounding
    const bool is_right = std::abs(off) <= slack * (size * unit + std::abs(wanted)) + rounding;
    return is_right ? std::nullopt : std::optional(std::size_t{0});
  }
  const double unit = s.unit(1);
  for (std::size_t k = 0; k < idx(s.dimension); ++k) {
    const double has = value_of<double>(s, in.own[k], q) * unit, wanted = x[k] * unit;
    if (!(std::abs(has - wanted) <= slack * (unit + std::abs(has) + std::abs(wanted)))) return k;
  }
  if (!turns(s, in)) return {};
  // Compares axes, because close to theta = pi / 2 the angles are badly determined.
  const Axes<double> own = own_axes(s, in, q), asked = wanted_axes(s, in, q);
  double worst = 0;
  for (int j = 0; j < 3; ++j) {
    const Three<double>&a = own.column[j], &b = asked.column[j];
    const double apart = std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
    if (!(apart <= worst)) worst = apart;
  }
  if (worst <= slack * own.slack) return {};
  const std::vector<double> off = difference(s, in, values_of(s, in, q), wanted_values(s, in, q));
  std::size_t most = idx(s.dimension);
  for (std::size_t k = most + 1; k < off.size(); ++k) {
    if (std::abs(off[k]) > std::abs(off[most])) most = k;
  }
  return most;
}

}  // namespace

std::vector<double> own_values(const System& s, const DriverInput& in, std::span<const double> q) {
  return values_of(s, in, q);
}

std::vector<Number> own_values(const System& s, const DriverInput& in, std::span<const Number> q) {
  return values_of(s, in, q);
}

std::vector<Number> written_values(const System& s, const DriverInput& in, std::span<const Number> q) {
  std::vector<Number> out = own_values(s, in, q);
  Number size = 0;
  if (in.kind == Kind::direction && !why_undefined(s, in, q).empty()) out[0] = kNan;
  if (in.must_not_vanish && !(scalar(s, in, q, size) > kNoLength * size)) out[0] = kNan;
  if (turns(s, in) && s.dimension == 3) {
    const Triple a = own_axes(s, in, q).column[0];
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
  return in.kind == DriverInput::Kind::direction ? why_undefined(arms(s, in, q)) : "";
}

std::string why_undefined(const System& s, const DriverInput& in, std::span<const Number> q) {
  return in.kind == DriverInput::Kind::direction ? why_undefined(arms(s, in, q)) : "";
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
  const Arms<double> a = arms(s, in, q);
  return why_undefined(a).empty() && has_angle(in, a, q, slack);
}

}  // namespace assur
