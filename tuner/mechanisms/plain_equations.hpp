// The plain equations of a scene: written a second time from its description, without the equations of the library, so
// that both can be compared. Each equation follows the words of the scene format, in vectors. Members of bodies follow
// from their local coordinates along the axes of the body. Callbacks are not supported.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <numbers>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "assur/scene.hpp"
#include "mechanisms/spatial.hpp"

namespace assur::mechanisms {

// 64 bits of mantissa: 2,048 times as fine as the tested doubles.
using Real = long double;

inline constexpr Real kTwoPi = 2 * std::numbers::pi_v<Real>;

// A value with two derivatives by time (or by any other parameter).
template <class T>
struct TimeJet {
  T value{}, rate{}, curve{};
  TimeJet() = default;
  TimeJet(T v) : value(v) {}  // NOLINT: a constant is a jet
  TimeJet(T v, T r, T c) : value(v), rate(r), curve(c) {}
  friend TimeJet operator+(const TimeJet& a, const TimeJet& b) {
    return {a.value + b.value, a.rate + b.rate, a.curve + b.curve};
  }
  friend TimeJet operator-(const TimeJet& a, const TimeJet& b) {
    return {a.value - b.value, a.rate - b.rate, a.curve - b.curve};
  }
  friend TimeJet operator*(const TimeJet& a, const TimeJet& b) {
    return {a.value * b.value, a.value * b.rate + a.rate * b.value,
            a.value * b.curve + T(2) * a.rate * b.rate + a.curve * b.value};
  }
  friend TimeJet operator/(const TimeJet& a, const TimeJet& b) {
    const T q = a.value / b.value, r = (a.rate - q * b.rate) / b.value;
    return {q, r, (a.curve - q * b.curve - T(2) * r * b.rate) / b.value};
  }
  friend TimeJet sqrt(const TimeJet& a) {
    using std::sqrt;
    const T s = sqrt(a.value), r = a.rate / (T(2) * s);
    return {s, r, (a.curve - T(2) * r * r) / (T(2) * s)};
  }
};

// A value with its derivatives with respect to some unknowns: a strip of the Jacobian.
struct Strip {
  static constexpr std::size_t kWidth = 8;
  double value = 0;
  std::array<double, kWidth> by{};
  Strip() = default;
  Strip(double v) : value(v) {}  // NOLINT: a constant is a strip
  template <class F>
  static Strip of(double value, const F& derivative) {
    Strip out(value);
    for (std::size_t i = 0; i < kWidth; ++i) out.by[i] = derivative(i);
    return out;
  }
  friend Strip operator+(const Strip& a, const Strip& b) {
    return of(a.value + b.value, [&](std::size_t i) { return a.by[i] + b.by[i]; });
  }
  friend Strip operator-(const Strip& a, const Strip& b) {
    return of(a.value - b.value, [&](std::size_t i) { return a.by[i] - b.by[i]; });
  }
  friend Strip operator*(const Strip& a, const Strip& b) {
    return of(a.value * b.value, [&](std::size_t i) { return a.value * b.by[i] + a.by[i] * b.value; });
  }
  friend Strip operator/(const Strip& a, const Strip& b) {
    const double q = a.value / b.value;
    return of(q, [&](std::size_t i) { return (a.by[i] - q * b.by[i]) / b.value; });
  }
  friend Strip sqrt(const Strip& a) {
    const double s = std::sqrt(a.value);
    return of(s, [&](std::size_t i) { return a.by[i] / (2 * s); });
  }
};

// The value of a law, evaluated anew from its parts; functions of a program are taken in double.
[[nodiscard]] TimeJet<Real> value_of(const Law& law, Real t);

class PlainEquations {
 public:
  // The value of a law; for an angle also its cosine and sine.
  template <class T>
  struct Input {
    T value{}, cosine{}, sine{};
  };

  // Throws Error (input) for a callback.
  explicit PlainEquations(const Scene& scene);

  [[nodiscard]] std::size_t unknowns() const { return unknown_names_.size(); }
  [[nodiscard]] std::size_t equations() const { return count_; }
  [[nodiscard]] const std::vector<std::string>& unknown_names() const { return unknown_names_; }  // "B.x", "s.lambda"
  [[nodiscard]] const std::vector<bool>& is_length() const { return is_length_; }                 // of each unknown
  [[nodiscard]] std::vector<Real> as_written() const;  // values of the unknowns; auxiliary scalars are 0
  // Place of a point, or direction of a vector, as written; true: a point.
  [[nodiscard]] std::pair<Spatial<Real>, bool> written(const std::string& name) const {
    const auto i = static_cast<std::size_t>(item(name));
    return {at_guess_[i], items_[i].is_point};
  }
  [[nodiscard]] double length() const { return length_; }  // a typical one, of the scene
  // All laws, driver after driver, and whether they are angles.
  [[nodiscard]] const std::vector<const Law*>& laws() const { return laws_; }
  [[nodiscard]] const std::vector<std::string>& law_names() const { return law_names_; }  // of the drivers

  // Residuals out[equations()] at x[unknowns()] with the laws in[laws().size()].
  template <class T>
  void evaluate(const T* x, const Input<T>* in, T* out) const;

  // For each driver of an angle: the angle measured from positions, minus the value of its law, in (-pi, pi].
  [[nodiscard]] std::vector<Real> angles_off(const Real* x, const Input<Real>* in) const;

  // A column of a trajectory ("C.x", "C.vy", "m.rate", "s.lambda"): quantity and derivative.
  struct Column {
    int item = -1, component = 0;  // of a point, vector or scalar
    int measure = -1;
    int derivative = 0;
    bool known = false;
    bool signed_angle = false;  // known up to whole turns
    bool length = false;        // has the unit of a length (times 1/s^derivative)
    std::string output;         // the name
  };
  [[nodiscard]] Column column(const std::string& name) const;
  // The values of columns at x with their derivatives; angles in (-pi, pi].
  [[nodiscard]] std::vector<TimeJet<Real>> show(std::span<const Column> columns, const TimeJet<Real>* x) const;

 private:
  enum class Kind {
    norm,
    across,
    frame,
    distance,
    equal,
    dot,
    parallel,
    linear,
    coordinate,
    on_line,
    on_plane,
    turned_flat,
    turned_about,
    relative,
    reach,
    driven,
    posed_point,
    posed_axis
  };
  struct Ray {
    int first = -1, second = -1;  // a vector, or from one point to another
  };
  struct Equation {
    explicit Equation(Kind k) : kind(k) {}
    Equation(Kind k, Ray along) : kind(k), d(along) {}
    Kind kind;
    Ray d, e;
    int a = -1, b = -1, c = -1;  // items
    int law = -1;                // index of its first law
    Real value = 0, radius = 0;
    Triple zero{};  // direction of the angle 0
    std::vector<std::pair<int, double>> terms;
    Triple constant{};
  };
  struct Item {
    int first = -1;  // unknown; -1: fixed or a member
    int count = 0;
    Triple at{};
    bool is_point = true;
    bool known = false;  // fixed
  };
  struct Grown {  // a member of a body
    int item = -1, body = -1;
    Triple local{};
    bool is_point = true;
  };
  struct Solid {
    int origin = -1;
    std::vector<int> frame, base;
  };

  int add_item(const std::string& name, const Triple& at, bool fixed, bool is_point, int components);
  [[nodiscard]] int item(const std::string& name) const;
  [[nodiscard]] Ray ray(const Direction& d) const;
  [[nodiscard]] std::pair<int, int> scalar(const std::string& text) const;       // item and component
  [[nodiscard]] Real between(const std::string& p, const std::string& q) const;  // |P - Q| of the guess
  Spatial<Real> guess(const Ray& r) const;
  void add(Equation equation, int rows);
  void add_bodies(const Scene& scene);
  void add_base_lengths(const Scene& scene, const Body& body);
  void add_constraint(const Scene& scene, const Constraint& c);
  void add_driver(const Scene& scene, const Driver& d);
  int add_law(const Driver& d, const Law& law);
  template <class T>
  std::vector<Spatial<T>> places(const T* x) const;
  [[nodiscard]] TimeJet<Real> show(const Column& column, const std::vector<Spatial<TimeJet<Real>>>& at,
                                   const TimeJet<Real>* x) const;
  // The columns u, v of the rotation of a pose, whose laws begin here; u alone in the plane.
  template <class T>
  std::array<Spatial<T>, 2> rotation(const Input<T>* in) const {
    const T zero(0);
    if (dimension_ == 2) return {{{in[0].cosine, in[0].sine, zero}, {}}};
    const Input<T>&psi = in[0], &theta = in[1], &phi = in[2];
    const Spatial<T> u{psi.cosine * theta.cosine, psi.sine * theta.cosine, zero - theta.sine};
    const Spatial<T> y{zero - psi.sine, psi.cosine, zero};
    return {u, phi.cosine * y + phi.sine * cross(u, y)};
  }
  template <class T>
  static Spatial<T> look(const std::vector<Spatial<T>>& at, const Ray& r) {
    return r.second < 0 ? at[static_cast<std::size_t>(r.first)]
                        : at[static_cast<std::size_t>(r.second)] - at[static_cast<std::size_t>(r.first)];
  }

  Scene scene_;  // keeps the laws
  int dimension_;
  std::map<std::string, int> names_;
  std::vector<Item> items_;
  std::vector<Solid> solids_;
  std::vector<Grown> grown_;
  std::vector<Equation> equations_;
  std::size_t count_ = 0;
  std::vector<std::string> unknown_names_;
  std::vector<bool> is_length_;
  double length_ = 1;
  std::vector<const Law*> laws_;
  std::vector<std::string> law_names_;
  struct Shown {
    std::string name;
    int kind = 0;  // 0 angle in the plane, 1 between directions, 2 about an axis, 3 distance, 4 coordinate
    Ray d, e;
    int axis = -1, component = 0;
  };
  std::vector<Shown> shown_;
  std::vector<Spatial<Real>> at_guess_;
};

// ---- templates

template <class T>
std::vector<Spatial<T>> PlainEquations::places(const T* x) const {
  std::vector<Spatial<T>> at(items_.size());
  for (std::size_t i = 0; i < items_.size(); ++i) {
    const Item& it = items_[i];
    if (it.first < 0) {
      at[i] = {T(it.at[0]), T(it.at[1]), T(it.at[2])};
    } else {
      at[i].x = x[it.first];
      if (it.count > 1) at[i].y = x[it.first + 1];
      if (it.count > 2) at[i].z = x[it.first + 2];
    }
  }
  int now = -1;
  Spatial<T> origin, axes[3];
  for (const Grown& m : grown_) {
    if (m.body != now) {
      now = m.body;
      const Solid& s = solids_[static_cast<std::size_t>(now)];
      const auto of = [&](int i) { return at[static_cast<std::size_t>(i)]; };
      axes[0] = {T(1), T(0), T(0)}, axes[1] = {T(0), T(1), T(0)}, axes[2] = {T(0), T(0), T(1)};
      origin = of(s.base.empty() ? s.origin : s.base[0]);
      const auto way = [&](int i) { return items_[static_cast<std::size_t>(i)].is_point ? of(i) - origin : of(i); };
      if (!s.base.empty()) axes[0] = unit(way(s.base[1]));
      if (!s.frame.empty()) axes[0] = of(s.frame[0]);
      if (dimension_ == 2 && !(s.base.empty() && s.frame.empty())) axes[1] = {T(0) - axes[0].y, axes[0].x, T(0)};
      if (s.frame.size() == 3) axes[1] = of(s.frame[1]), axes[2] = of(s.frame[2]);
      if (s.base.size() == 3) {
        axes[2] = unit(cross(axes[0], way(s.base[2])));
        axes[1] = cross(axes[2], axes[0]);
      }
    }
    Spatial<T> v = T(m.local[0]) * axes[0] + T(m.local[1]) * axes[1];
    if (dimension_ == 3) v = v + T(m.local[2]) * axes[2];
    at[static_cast<std::size_t>(m.item)] = m.is_point ? origin + v : v;
  }
  return at;
}

template <class T>
void PlainEquations::evaluate(const T* x, const Input<T>* in, T* out) const {
  const std::vector<Spatial<T>> at = places(x);
  const auto of = [&](int i) -> const Spatial<T>& { return at[static_cast<std::size_t>(i)]; };
  const auto give = [&](const Spatial<T>& v) {
    *out++ = v.x;
    *out++ = v.y;
    if (dimension_ == 3) *out++ = v.z;
  };
  for (const Equation& q : equations_) {
    switch (q.kind) {
      case Kind::norm:
        *out++ = dot(of(q.a), of(q.a)) - T(1);
        break;
      case Kind::across:
        *out++ = dot(of(q.a), of(q.b));
        break;
      case Kind::frame:
        give(of(q.c) - cross(of(q.a), of(q.b)));
        break;
      case Kind::distance: {
        const Spatial<T> d = look(at, q.d);
        *out++ = dot(d, d) - T(static_cast<double>(q.value)) * T(static_cast<double>(q.value));
        break;
      }
      case Kind::equal: {
        const Spatial<T> d = look(at, q.d), e = look(at, q.e);
        *out++ = dot(d, d) - dot(e, e);
        break;
      }
      case Kind::dot:
        *out++ = dot(look(at, q.d), look(at, q.e)) - T(static_cast<double>(q.value));
        break;
      case Kind::parallel:
        give(look(at, q.e) - of(q.a).x * look(at, q.d));
        break;
      case Kind::linear: {
        Spatial<T> sum{T(-q.constant[0]), T(-q.constant[1]), T(-q.constant[2])};
        for (const auto& [i, factor] : q.terms) sum = sum + T(factor) * of(i);
        give(sum);
        break;
      }
      case Kind::coordinate:
        *out++ = of(q.a)[q.b] - T(static_cast<double>(q.value));
        break;
      case Kind::on_line:
        give(look(at, q.d) - of(q.a).x * look(at, q.e));
        break;
      case Kind::on_plane:  // look(d): from A to P; e: first direction; b, c: the second one
        give(look(at, q.d) - of(q.a).x * look(at, q.e) - of(q.a).y * look(at, Ray{q.b, q.c}));
        break;
      case Kind::turned_flat: {
        const Spatial<T> d = look(at, q.d);
        const Input<T>& l = in[q.law];
        *out++ = l.cosine * d.y - l.sine * d.x;
        break;
      }
      case Kind::turned_about: {  // value: the height along the axis `a`
        const Spatial<T> d = look(at, q.d), n = of(q.a), e1{T(q.zero[0]), T(q.zero[1]), T(q.zero[2])},
                         e2 = cross(n, e1);
        const Input<T>& l = in[q.law];
        *out++ = l.cosine * dot(d, e2) - l.sine * dot(d, e1);
        *out++ = dot(d, n) - T(static_cast<double>(q.value));
        break;
      }
      case Kind::relative: {
        const Spatial<T> d = look(at, q.d), e = look(at, q.e), c = cross(d, e);
        const Input<T>& l = in[q.law];
        *out++ = l.cosine * (q.a < 0 ? c.z : dot(of(q.a), c)) - l.sine * dot(d, e);
        break;
      }
      case Kind::reach: {
        const Spatial<T> d = look(at, q.d);
        *out++ = dot(d, d) - in[q.law].value * in[q.law].value;
        break;
      }
      case Kind::driven:
        *out++ = of(q.a)[q.b] - in[q.law].value;
        break;
      case Kind::posed_point: {  // at the translation, plus `zero` in the axes of the rotation
        Spatial<T> p{in[q.law].value, in[q.law + 1].value, dimension_ == 3 ? in[q.law + 2].value : T(0)};
        if (q.radius != 0) {
          const auto [u, v] = rotation(in + q.law + dimension_);
          p = p + T(q.zero[0]) * u + T(q.zero[1]) * v;
        }
        give(of(q.a) - p);
        break;
      }
      case Kind::posed_axis: {  // b: column of the rotation
        const auto [u, v] = rotation(in + q.law + dimension_);
        give(of(q.a) - (q.b == 0 ? u : q.b == 1 ? v : cross(u, v)));
        break;
      }
    }
  }
}

}  // namespace assur::mechanisms
