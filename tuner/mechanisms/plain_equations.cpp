#include "mechanisms/plain_equations.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <variant>

#include "median.hpp"

namespace assur::mechanisms {
namespace {

// build() has replaced coordinates by the name of a vector.
const std::string& axis_name(const Anchor& axis) { return std::get<std::string>(axis); }

struct LawAt {
  Real t;
  TimeJet<Real> operator()(const Law::Polynomial& p) const {
    const TimeJet<Real> time(t, 1, 0);
    TimeJet<Real> sum;
    for (std::size_t i = p.coefficients.size(); i-- > 0;) sum = sum * time + TimeJet<Real>(p.coefficients[i]);
    return sum;
  }
  TimeJet<Real> operator()(const Law::Harmonics& h) const {
    TimeJet<Real> sum(h.offset);
    for (const Harmonic& term : h.terms) {
      const Real omega = kTwoPi * term.frequency, angle = omega * t + term.phase;
      const Real s = term.amplitude * std::sin(angle), c = term.amplitude * std::cos(angle);
      sum = sum + TimeJet<Real>(s, omega * c, -omega * omega * s);
    }
    return sum;
  }
  // The cubic with these values and second derivatives at both ends.
  TimeJet<Real> operator()(const Law::Spline& s) const {
    Real at = t;
    const Real first = s.time.front(), last = s.time.back();
    if (s.periodic) at -= std::floor((t - first) / (last - first)) * (last - first);
    std::size_t k = 0;
    while (k + 2 < s.time.size() && static_cast<Real>(s.time[k + 1]) <= at) ++k;
    const auto [left, right] = s.bends(k);
    const Real begin = s.time[k], h = s.time[k + 1] - begin, y0 = s.value[k], m0 = left, m1 = right;
    const Real slope = (s.value[k + 1] - y0) / h - h * (2 * m0 + m1) / 6;
    const TimeJet<Real> u(at - begin, 1, 0);
    return TimeJet<Real>(y0) +
           u * (TimeJet<Real>(slope) + u * (TimeJet<Real>(m0 / 2) + u * TimeJet<Real>((m1 - m0) / (6 * h))));
  }
  TimeJet<Real> operator()(const Law::Function& f) const {
    const Motion m = f.motion(static_cast<double>(t));
    return {m.value, m.rate, m.acceleration};
  }
};

std::set<std::string> key(const std::string& p, const std::string& q) { return {p, q}; }

TimeJet<Real> arc(const TimeJet<Real>& y, const TimeJet<Real>& x) {
  const TimeJet<Real> square = x * x + y * y;
  // The derivative of atan2 is (x y' - y x') / (x^2 + y^2).
  const Real turn = x.value * y.rate - y.value * x.rate, square_rate = square.rate;
  const Real turn_rate = x.value * y.curve - y.value * x.curve;
  return {std::atan2(y.value, x.value), turn / square.value,
          (turn_rate - turn / square.value * square_rate) / square.value};
}

// A length that is zero within rounding has no derivatives, unless it is at rest.
// size: magnitude of the numbers that v is computed from; fastest: largest rate of the motion.
TimeJet<Real> length_of(const Spatial<TimeJet<Real>>& v, Real size, Real fastest) {
  constexpr Real kNothing = 1e-12L;  // relative; doubles in the scene leave 1e-16 times the sizes
  const TimeJet<Real> square = dot(v, v);
  if (square.value > kNothing * size * kNothing * size) return sqrt(square);
  const auto norm = [&](Real TimeJet<Real>::*of) {
    return std::sqrt(v.x.*of * v.x.*of + v.y.*of * v.y.*of + v.z.*of * v.z.*of);
  };
  const Real none = std::numeric_limits<Real>::quiet_NaN();
  if (norm(&TimeJet<Real>::rate) > kNothing * size * fastest) return {0, none, none};
  return {0, 0, norm(&TimeJet<Real>::curve)};
}

}  // namespace

TimeJet<Real> value_of(const Law& law, Real t) {
  TimeJet<Real> sum;
  for (const Law::Part& part : law.parts()) sum = sum + std::visit(LawAt{t}, part);
  return sum;
}

PlainEquations::PlainEquations(const Scene& scene) : scene_(scene), dimension_(scene.dimension()) {
  for (const Point& p : scene.points()) add_item(p.name, p.at, p.fixed, true, dimension_);
  for (const Vector& v : scene.vectors()) add_item(v.name, v.at, v.fixed, false, dimension_);
  add_bodies(scene);
  for (const Constraint& c : scene.constraints()) {
    const bool plane = c.as<OnPlane>() != nullptr;
    if (!plane && c.as<OnLine>() == nullptr && c.as<Parallel>() == nullptr) continue;
    const int i = add_item(c.name, {}, false, false, plane ? 2 : 1);
    names_.erase(c.name);
    names_[c.name + ".lambda"] = i;
    const auto first = static_cast<std::size_t>(items_[static_cast<std::size_t>(i)].first);
    unknown_names_[first] = c.name + ".lambda";
    if (plane) unknown_names_[first + 1] = c.name + ".mu", names_[c.name + ".mu"] = i;
  }
  at_guess_ = places(as_written().data());
  // Auxiliary scalars along unit vectors are lengths.
  for (const Constraint& c : scene.constraints()) {
    const auto mark = [&](const std::string& name, bool length) {
      const auto it = std::find(unknown_names_.begin(), unknown_names_.end(), name);
      if (it != unknown_names_.end()) is_length_[static_cast<std::size_t>(it - unknown_names_.begin())] = length;
    };
    if (const auto* l = c.as<OnLine>()) mark(c.name + ".lambda", !l->d.is_pair());
    if (const auto* p = c.as<OnPlane>())
      mark(c.name + ".lambda", !p->d.is_pair()), mark(c.name + ".mu", !p->e.is_pair());
    if (const auto* p = c.as<Parallel>()) mark(c.name + ".lambda", p->e.is_pair() && !p->d.is_pair());
  }
  // The typical length: median of the lengths that the scene shows.
  std::vector<double> lengths;
  const auto see = [&](Real l) {
    if (l > 0) lengths.push_back(static_cast<double>(l));
  };
  for (const Body& b : scene.bodies()) {
    for (const Member& m : b.points) see(std::hypot(m.local[0], m.local[1], m.local[2]));
  }
  for (const Constraint& c : scene.constraints()) {
    if (const auto* d = c.as<Distance>()) see(d->value ? d->value->value() : between(d->p, d->q));
    if (const auto* l = c.as<OnLine>()) see(between(l->p, l->a));
  }
  for (const Driver& d : scene.drivers()) {
    if (const auto* a = std::get_if<PointAngle>(&d.kind)) see(between(a->a, a->b));
    if (const auto* a = std::get_if<DrivenDistance>(&d.kind)) see(between(a->a, a->b));
  }
  if (!lengths.empty()) length_ = median(std::move(lengths));

  // The norms of the vectors of frames are equations of their bodies.
  std::set<std::string> framed;
  for (const Body& b : scene.bodies()) {
    if (b.frame.size() == 3) framed.insert(b.frame.begin(), b.frame.end());
  }
  for (const Vector& v : scene.vectors()) {
    if (v.fixed || !v.unit || framed.count(v.name) != 0) continue;
    Equation q(Kind::norm);
    q.a = item(v.name);
    add(std::move(q), 1);
  }
  for (const Body& b : scene.bodies()) add_base_lengths(scene, b);
  for (const Constraint& c : scene.constraints()) add_constraint(scene, c);
  for (const Driver& d : scene.drivers()) add_driver(scene, d);
  for (const Measure& m : scene.measures()) {
    Shown s;
    s.name = m.name;
    if (const auto* a = std::get_if<AbsoluteAngle>(&m.kind)) {
      s.kind = 0, s.d = ray({a->a, a->b});
    } else if (const auto* b = std::get_if<AngleBetween>(&m.kind)) {
      s.kind = dimension_ == 3 && axis_name(b->axis).empty() ? 1 : 2, s.d = ray(b->d), s.e = ray(b->e);
      if (!axis_name(b->axis).empty()) s.axis = item(axis_name(b->axis));
    } else if (const auto* l = std::get_if<MeasuredDistance>(&m.kind)) {
      s.kind = 3, s.d = ray({l->a, l->b});
    } else if (const auto* c = std::get_if<MeasuredCoordinate>(&m.kind)) {
      s.kind = 4;
      std::tie(s.axis, s.component) = scalar(c->coordinate);
    }
    shown_.push_back(std::move(s));
  }
}

std::vector<Real> PlainEquations::as_written() const {
  std::vector<Real> out(unknowns());
  for (const Item& it : items_) {
    for (int k = 0; it.first >= 0 && k < it.count; ++k)
      out[static_cast<std::size_t>(it.first + k)] = it.at[static_cast<std::size_t>(k)];
  }
  return out;
}

int PlainEquations::add_item(const std::string& name, const Triple& at, bool fixed, bool is_point, int components) {
  Item it;
  it.at = at;
  it.is_point = is_point;
  it.known = fixed;
  it.count = components;
  if (!fixed) {
    it.first = static_cast<int>(unknown_names_.size());
    for (int k = 0; k < components; ++k) {
      unknown_names_.push_back(name + "." + "xyz"[k]);
      is_length_.push_back(is_point);
    }
  }
  items_.push_back(it);
  return names_[name] = static_cast<int>(items_.size()) - 1;
}

int PlainEquations::item(const std::string& name) const { return names_.at(name); }

PlainEquations::Ray PlainEquations::ray(const Direction& d) const {
  return {item(d.first), d.is_pair() ? item(d.second) : -1};
}

std::pair<int, int> PlainEquations::scalar(const std::string& text) const {
  const std::string part = text.substr(text.rfind('.') + 1);
  if (part == "lambda") return {item(text), 0};
  if (part == "mu") return {item(text), 1};
  return {item(text.substr(0, text.rfind('.'))), part[0] - 'x'};
}

Spatial<Real> PlainEquations::guess(const Ray& r) const { return look(at_guess_, r); }

Real PlainEquations::between(const std::string& p, const std::string& q) const {
  const Spatial<Real> d = guess(ray({p, q}));
  return std::sqrt(dot(d, d));
}

void PlainEquations::add(Equation equation, int rows) {
  equations_.push_back(std::move(equation));
  count_ += static_cast<std::size_t>(rows);
}

void PlainEquations::add_bodies(const Scene& scene) {
  for (const Body& b : scene.bodies()) {
    Solid s;
    if (b.name == "ground") {
      for (const Member& m : b.points) add_item(m.name, m.local, true, true, dimension_);
      for (const Member& m : b.vectors) add_item(m.name, m.local, true, false, dimension_);
    } else {
      if (!b.origin.empty()) s.origin = item(b.origin);
      for (const std::string& name : b.frame) s.frame.push_back(item(name));
      for (const std::string& name : b.base) s.base.push_back(item(name));
      const auto grow = [&](const Member& m, bool is_point) {
        Item it;
        it.is_point = is_point;
        items_.push_back(it);
        names_[m.name] = static_cast<int>(items_.size()) - 1;
        grown_.push_back({names_[m.name], static_cast<int>(solids_.size()), m.local, is_point});
      };
      for (const Member& m : b.points) grow(m, true);
      for (const Member& m : b.vectors) grow(m, false);
    }
    solids_.push_back(std::move(s));
  }
  std::set<std::vector<std::string>> framed;
  for (const Body& b : scene.bodies()) {
    if (b.frame.size() != 3 || !framed.insert(b.frame).second) continue;
    for (int k : {0, 1}) {
      Equation q(Kind::norm);
      q.a = item(b.frame[static_cast<std::size_t>(k)]);
      if (!items_[static_cast<std::size_t>(q.a)].known) add(std::move(q), 1);
    }
    Equation q(Kind::across);
    q.a = item(b.frame[0]), q.b = item(b.frame[1]);
    add(q, 1);
    q.kind = Kind::frame, q.c = item(b.frame[2]);
    add(std::move(q), 3);
  }
}

void PlainEquations::add_base_lengths(const Scene& scene, const Body& body) {
  const auto is_point = [&](std::size_t i) { return items_[static_cast<std::size_t>(item(body.base[i]))].is_point; };
  const auto way = [&](std::size_t i) {
    return ray(is_point(i) ? Direction(body.base[0], body.base[i]) : Direction(body.base[i]));
  };
  for (std::size_t i = 0; i < body.base.size(); ++i) {
    for (std::size_t j = i + 1; j < body.base.size(); ++j) {
      if (!is_point(j) || !is_point(i)) {
        if (i == 0) continue;  // the length of a vector is an equation of its own
        Equation q(Kind::dot, way(i));
        q.e = way(j);
        q.value = dot(guess(q.d), guess(q.e));
        add(std::move(q), 1);
        continue;
      }
      const auto is_given = [&](const Constraint& c) {
        const auto* d = c.as<Distance>();
        return d != nullptr && key(d->p, d->q) == key(body.base[i], body.base[j]);
      };
      if (std::any_of(scene.constraints().begin(), scene.constraints().end(), is_given)) continue;
      Equation q(Kind::distance, ray({body.base[i], body.base[j]}));
      q.value = static_cast<double>(between(body.base[i], body.base[j]));
      add(std::move(q), 1);
    }
  }
}

void PlainEquations::add_constraint(const Scene&, const Constraint& c) {
  Equation q(Kind::distance);
  if (const auto* d = c.as<Distance>()) {
    q.d = ray({d->p, d->q});
    q.value = d->value ? Real(*d->value) : between(d->p, d->q);
    add(std::move(q), 1);
  } else if (const auto* e = c.as<EqualDistance>()) {
    q.kind = Kind::equal, q.d = ray({e->p, e->q}), q.e = ray({e->r, e->s});
    add(std::move(q), 1);
  } else if (const auto* o = c.as<Dot>()) {
    q.kind = Kind::dot, q.d = ray(o->d), q.e = ray(o->e);
    q.value = o->value ? Real(*o->value) : dot(guess(q.d), guess(q.e));
    add(std::move(q), 1);
  } else if (const auto* p = c.as<Parallel>()) {
    q.kind = Kind::parallel, q.d = ray(p->d), q.e = ray(p->e), q.a = item(c.name + ".lambda");
    add(std::move(q), dimension_);
  } else if (const auto* l = c.as<Linear>()) {
    q.kind = Kind::linear, q.constant = l->value;
    for (const auto& [name, factor] : l->terms) q.terms.emplace_back(item(name), factor);
    add(std::move(q), dimension_);
  } else if (const auto* f = c.as<FixedCoordinate>()) {
    q.kind = Kind::coordinate, q.value = f->value;
    std::tie(q.a, q.b) = scalar(f->coordinate);
    add(std::move(q), 1);
  } else if (const auto* s = c.as<OnLine>()) {
    q.kind = Kind::on_line, q.d = ray({s->a, s->p}), q.e = ray(s->d), q.a = item(c.name + ".lambda");
    add(std::move(q), dimension_);
  } else if (const auto* w = c.as<OnPlane>()) {
    q.kind = Kind::on_plane, q.d = ray({w->a, w->p}), q.e = ray(w->d), q.a = item(c.name + ".lambda");
    std::tie(q.b, q.c) = std::pair(ray(w->e).first, ray(w->e).second);
    add(std::move(q), dimension_);
  } else {
    throw Error(Error::Kind::input, c.name + ": a constraint of this kind has no plain equations");
  }
}

int PlainEquations::add_law(const Driver& d, const Law& law) {
  laws_.push_back(&law);
  law_names_.push_back(d.name);
  return static_cast<int>(laws_.size()) - 1;
}

void PlainEquations::add_driver(const Scene& scene, const Driver& driver) {
  Equation q(Kind::driven);
  if (const auto* a = std::get_if<PointAngle>(&driver.kind)) {
    q.d = ray({a->a, a->b});
    q.law = add_law(driver, a->law);
    // If no constraint gives the distance of the two points, the driver keeps it constant.
    Real length = between(a->a, a->b);
    bool written = false;
    for (const Constraint& c : scene.constraints()) {
      const auto* d = c.as<Distance>();
      if (d == nullptr || key(d->p, d->q) != key(a->a, a->b)) continue;
      written = true;
      if (d->value) length = *d->value;
    }
    // A driver of the distance has an equation of its own.
    for (const Driver& other : scene.drivers()) {
      const auto* d = std::get_if<DrivenDistance>(&other.kind);
      written = written || (d != nullptr && key(d->a, d->b) == key(a->a, a->b));
    }
    Equation radius(Kind::distance, q.d);
    radius.value = length;
    if (!written) add(std::move(radius), 1);
    if (dimension_ == 2) {
      q.kind = Kind::turned_flat;
      return add(std::move(q), 1);
    }
    q.kind = Kind::turned_about, q.a = item(axis_name(a->axis));
    const Spatial<Real> d = guess(q.d), n = unit(at_guess_[static_cast<std::size_t>(q.a)]);
    q.value = dot(d, n);
    const Spatial<Real> zero = unit(d - q.value * n);
    q.zero = {static_cast<double>(zero.x), static_cast<double>(zero.y), static_cast<double>(zero.z)};
    add(std::move(q), 2);
  } else if (const auto* r = std::get_if<RelativeAngle>(&driver.kind)) {
    q.kind = Kind::relative, q.d = ray(r->d), q.e = ray(r->e);
    if (!axis_name(r->axis).empty()) q.a = item(axis_name(r->axis));
    q.law = add_law(driver, r->law);
    add(std::move(q), 1);
  } else if (const auto* l = std::get_if<DrivenDistance>(&driver.kind)) {
    q.kind = Kind::reach, q.d = ray({l->a, l->b}), q.law = add_law(driver, l->law);
    add(std::move(q), 1);
  } else if (const auto* c = std::get_if<DrivenCoordinate>(&driver.kind)) {
    std::tie(q.a, q.b) = scalar(c->coordinate);
    q.law = add_law(driver, c->law);
    add(std::move(q), 1);
  } else if (const auto* p = std::get_if<Pose>(&driver.kind)) {
    for (const Law& law : p->translation) {
      const int i = add_law(driver, law);
      if (q.law < 0) q.law = i;
    }
    for (const Law& law : p->rotation) add_law(driver, law);
    const Body& b =
        *std::find_if(scene.bodies().begin(), scene.bodies().end(), [&](const Body& x) { return x.name == p->body; });
    const auto point = [&](const std::string& name, Real along, Real across) {
      Equation e = q;
      e.kind = Kind::posed_point, e.a = item(name);
      e.zero = {static_cast<double>(along), static_cast<double>(across), 0};
      e.radius = along != 0 || across != 0 ? 1 : 0;
      add(std::move(e), dimension_);
    };
    if (b.base.empty()) {
      point(b.origin, 0, 0);
      for (std::size_t k = 0; k < b.frame.size(); ++k) {
        Equation e = q;
        e.kind = Kind::posed_axis, e.a = item(b.frame[k]), e.b = static_cast<int>(k);
        add(std::move(e), dimension_);
      }
      return;
    }
    // The lengths of a base are given, or taken from the guess.
    const auto side = [&](std::size_t i, std::size_t j) {
      for (const Constraint& c2 : scene.constraints()) {
        const auto* d = c2.as<Distance>();
        if (d != nullptr && d->value && key(d->p, d->q) == key(b.base[i], b.base[j])) return Real(*d->value);
      }
      return between(b.base[i], b.base[j]);
    };
    point(b.base[0], 0, 0);
    point(b.base[1], side(0, 1), 0);
    if (b.base.size() > 2) {
      const Real along =
          (side(0, 1) * side(0, 1) + side(0, 2) * side(0, 2) - side(1, 2) * side(1, 2)) / (2 * side(0, 1));
      point(b.base[2], along, std::sqrt(side(0, 2) * side(0, 2) - along * along));
    }
  }
}

std::vector<Real> PlainEquations::angles_off(const Real* x, const Input<Real>* in) const {
  const std::vector<Spatial<Real>> at = places(x);
  std::vector<Real> off;
  for (const Equation& q : equations_) {
    Real y = 0, c = 0;
    if (q.kind == Kind::turned_flat) {
      const Spatial<Real> d = look(at, q.d);
      y = d.y, c = d.x;
    } else if (q.kind == Kind::turned_about) {
      const Spatial<Real> d = look(at, q.d), n = at[static_cast<std::size_t>(q.a)], e{q.zero[0], q.zero[1], q.zero[2]};
      y = dot(d, cross(n, e)), c = dot(d, e);
    } else if (q.kind == Kind::relative) {
      const Spatial<Real> d = look(at, q.d), e = look(at, q.e), both = cross(d, e);
      y = q.a < 0 ? both.z : dot(at[static_cast<std::size_t>(q.a)], both), c = dot(d, e);
    } else {
      continue;
    }
    const auto& l = in[q.law];
    off.push_back(std::atan2(y * l.cosine - c * l.sine, c * l.cosine + y * l.sine));
  }
  return off;
}

PlainEquations::Column PlainEquations::column(const std::string& name) const {
  Column out;
  const auto measure_of = [&](const std::string& m) {
    for (std::size_t i = 0; i < shown_.size(); ++i) {
      if (shown_[i].name == m) return static_cast<int>(i);
    }
    return -1;
  };
  std::string rest = name;
  for (const auto& [suffix, derivative] : {std::pair<std::string, int>{".rate", 1}, {".acceleration", 2}}) {
    if (rest.ends_with(suffix)) rest.resize(rest.size() - suffix.size()), out.derivative = derivative;
  }
  out.output = rest;
  out.measure = measure_of(rest);
  if (out.measure >= 0) {
    const Shown& s = shown_[static_cast<std::size_t>(out.measure)];
    out.known = true;
    out.signed_angle = (s.kind == 0 || s.kind == 2) && out.derivative == 0;
    const auto is_length = [&] {
      const Item& it = items_[static_cast<std::size_t>(s.axis)];
      return it.first < 0 ? it.is_point : bool(is_length_[static_cast<std::size_t>(it.first + s.component)]);
    };
    out.length = s.kind == 3 || (s.kind == 4 && is_length());
    return out;
  }
  if (const auto found = names_.find(rest); found != names_.end() && rest.find('.') != std::string::npos) {
    out.item = found->second, out.known = true;
    out.component = rest.ends_with(".mu") ? 1 : 0;
    out.length = is_length_[static_cast<std::size_t>(items_[static_cast<std::size_t>(out.item)].first + out.component)];
    return out;
  }
  const std::size_t period = rest.rfind('.');
  if (period == std::string::npos) return out;
  out.output = rest.substr(0, period);
  const auto found = names_.find(out.output);
  std::string part = rest.substr(period + 1);
  if (found == names_.end() || part.empty() || part.size() > 2) return out;
  if (part.size() == 2) out.derivative = part[0] == 'v' ? 1 : part[0] == 'a' ? 2 : 3, part.erase(0, 1);
  if (part[0] < 'x' || part[0] > 'z' || out.derivative > 2) return out;
  out.item = found->second, out.component = part[0] - 'x', out.known = true;
  out.length = items_[static_cast<std::size_t>(out.item)].is_point;
  return out;
}

std::vector<TimeJet<Real>> PlainEquations::show(std::span<const Column> columns, const TimeJet<Real>* x) const {
  const auto at = places(x);
  std::vector<TimeJet<Real>> out;
  for (const Column& c : columns) out.push_back(show(c, at, x));
  return out;
}

TimeJet<Real> PlainEquations::show(const Column& column, const std::vector<Spatial<TimeJet<Real>>>& at,
                                   const TimeJet<Real>* x) const {
  using Jet = TimeJet<Real>;
  if (!column.known) return {NAN, NAN, NAN};
  const auto component = [&](int i, int k) { return at[static_cast<std::size_t>(i)][k]; };
  if (column.measure < 0) return component(column.item, column.component);
  const Shown& s = shown_[static_cast<std::size_t>(column.measure)];
  if (s.kind == 4) return component(s.axis, s.component);
  const Spatial<Jet> d = look(at, s.d);
  if (s.kind == 0) return arc(d.y, d.x);
  if (s.kind == 3) return sqrt(dot(d, d));
  const Spatial<Jet> e = look(at, s.e), both = cross(d, e);
  if (s.kind == 1) {
    Real fastest = 0;
    for (std::size_t i = 0; i < unknowns(); ++i) {
      fastest = std::max(fastest, std::abs(x[i].rate) / (is_length_[i] ? static_cast<Real>(length()) : 1));
    }
    return arc(length_of(both, std::sqrt(dot(d, d).value * dot(e, e).value), fastest), dot(d, e));
  }
  return arc(s.axis < 0 ? both.z : dot(at[static_cast<std::size_t>(s.axis)], both), dot(d, e));
}

}  // namespace assur::mechanisms
