// Random mechanisms of bodies and joints whose motion is known without solving: first the posture as written, then a
// unit of bodies after the other, each with a closed form or with a motion that was chosen before its drivers.
#pragma once

#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "scene/triple.hpp"
#include "simulation/random_mechanisms.hpp"
#include "simulation/shipped.hpp"

namespace assur::test {

using Real = Jet<long double>;
using Place3 = references::Vec<Real>;

inline Place3 exact(const Triple& a) { return references::exactly<Real>(a); }
inline Triple values(const Place3& a) {
  return {static_cast<double>(a[0].value), static_cast<double>(a[1].value), static_cast<double>(a[2].value)};
}
inline QuadJet quad(const Real& a) { return {a.value, a.rate, a.acceleration}; }
inline Real length_of(const Place3& a) { return sqrt(references::dot(a, a)); }

// The motion of a body from the posture as written: the point that was at p is at o + p0 x + p1 y + p2 z.
struct Frame {
  Place3 o = exact({0, 0, 0}), x = exact({1, 0, 0}), y = exact({0, 1, 0}), z = exact({0, 0, 1});

  [[nodiscard]] Place3 turn(const Place3& v) const { return v[0] * x + v[1] * y + v[2] * z; }
  [[nodiscard]] Place3 turn_back(const Place3& v) const {
    return {references::dot(v, x), references::dot(v, y), references::dot(v, z)};
  }
  [[nodiscard]] Place3 turn(const Triple& v) const { return turn(exact(v)); }
  [[nodiscard]] Place3 at(const Place3& p) const { return o + turn(p); }
  [[nodiscard]] Place3 at(const Triple& p) const { return at(exact(p)); }
  // This motion after the other one.
  [[nodiscard]] Frame after(const Frame& f) const { return {at(f.o), turn(f.x), turn(f.y), turn(f.z)}; }
  // The same rotation, with the point that was at p at `now`.
  void put(const Place3& p, const Place3& now) { o = now - turn(p); }
};

// A rotation about a unit axis through a point.
inline Frame turned(const Triple& at, const Triple& axis, const Real& angle) {
  const Place3 u = references::unit(exact(axis));
  const Real c = cos(angle), s = sin(angle);
  const auto column = [&](const Place3& e) {
    return c * e + s * references::cross(u, e) + ((1 - c) * references::dot(u, e)) * u;
  };
  Frame f{exact({0, 0, 0}), column(exact({1, 0, 0})), column(exact({0, 1, 0})), column(exact({0, 0, 1}))};
  f.put(exact(at), exact(at));
  return f;
}
inline Frame moved(const Triple& axis, const Real& by) {
  Frame f;
  f.o = by * references::unit(exact(axis));
  return f;
}
// The rotation that takes d to the direction of D, and e to the side of E.
inline Frame aligned(const Triple& d, const Triple& e, const Place3& D, const Place3& E) {
  const auto axes = [](const Place3& along, const Place3& side) {
    const Place3 a = references::unit(along), c = references::unit(references::cross(a, side));
    return std::array<Place3, 3>{a, references::cross(c, a), c};
  };
  const auto from = axes(exact(d), exact(e)), to = axes(D, E);
  const auto column = [&](std::size_t k) { return from[0][k] * to[0] + from[1][k] * to[1] + from[2][k] * to[2]; };
  return {exact({0, 0, 0}), column(0), column(1), column(2)};
}

// The motion of a driver or of a free coordinate; 0 in the posture as written.
struct Curve {
  double amplitude = 0, frequency = 0.5, phase = 0, speed = 0, offset = 0;

  [[nodiscard]] double constant() const { return offset - amplitude * std::sin(phase); }
  [[nodiscard]] Real at(long double t) const {
    const long double turn = 2 * std::numbers::pi_v<long double> * frequency;
    const Real time{t, 1, 0};
    return amplitude * sin(turn * time + phase) + constant() + speed * time;
  }
  [[nodiscard]] Law law(double sign) const {
    return Law::harmonics({{sign * amplitude, frequency, phase}}, sign * constant()) +
           Law::polynomial({0, sign * speed});
  }
};

constexpr int kNoUnit = -1;

class JointMechanism : public std::enable_shared_from_this<JointMechanism> {
 public:
  using Frames = std::vector<Frame>;
  // Sets the frames of the bodies of a unit from those of earlier bodies. Returns the distance from its singular
  // postures, as a sine or cosine; negative: there is no such posture.
  using Unit = std::function<double(long double t, Frames& f)>;

  struct Solid {
    std::string name;
    int unit = kNoUnit;
    std::vector<std::pair<std::string, Triple>> tracers = {};
    bool spins = false;      // it may turn about itself, so that nothing can be attached to it
    bool has_frame = false;  // its own origin and frame, for a driver of its pose
    std::string origin = {};
    std::vector<std::string> frame = {};
    Triple origin_at{};
  };
  // Letters of joints: R, P, C, S, U, E (planar), and F (fixed).
  struct Link {
    char letter;
    std::size_t a, b;
    Triple at{}, axis{}, second{};  // second: the second axis of a universal joint
    std::string name = {};
    int unit = kNoUnit;
    bool measured = true;
  };

  JointMechanism(Draw& draw, int dimension) : draw_(draw), dimension_(dimension) {
    size_ = std::pow(10, draw.real(-2, 2));
    origin_ = draw.below(3) == 0 ? spot({}, 5 * size_) : Triple{};
    solids_.push_back({.name = "ground"});
  }

  Draw& draw() { return draw_; }
  [[nodiscard]] double size() const { return size_; }
  [[nodiscard]] std::size_t solids() const { return solids_.size(); }
  [[nodiscard]] int units() const { return static_cast<int>(units_.size()); }
  [[nodiscard]] const std::vector<Link>& links() const { return links_; }
  [[nodiscard]] const Solid& solid(std::size_t s) const { return solids_[s]; }

  std::string fresh() { return std::string(1, static_cast<char>('a' + draw_.below(26))) + std::to_string(++names_); }
  Triple spot() { return spot(origin_, size_); }
  Triple direction() {
    for (;;) {
      const Triple v = spot({}, 1);
      if (const double n = triple::norm(v); n > 0.3 && n < 1) return triple::scale(draw_.real(0.5, 3) / n, v);
    }
  }
  Curve swinging(double most) {
    Curve c{most * draw_.real(0.3, 1), draw_.real(0.3, 1), draw_.real(0, 2 * std::numbers::pi)};
    if (draw_.below(6) == 0) c.offset = 0.1 * c.amplitude;
    return c;
  }
  Curve angle() {
    if (draw_.below(3) == 0) return {0, 0.5, 0, (draw_.maybe() ? 2 : -2) * std::numbers::pi};
    return swinging(0.6);
  }
  Curve shift() { return swinging(0.3 * size_); }

  // A body, with two points whose motion is compared, or with one point at a given place.
  std::size_t body() {
    Solid s{fresh(), units()};
    for (int i = 0; i < 2; ++i) s.tracers.emplace_back(fresh(), spot());
    solids_.push_back(std::move(s));
    return solids_.size() - 1;
  }
  std::size_t rod(const Triple& middle) {
    solids_.push_back({fresh(), units(), {{fresh(), middle}}, true});
    return solids_.size() - 1;
  }
  std::size_t platform() {
    const std::size_t s = body();
    Solid& p = solids_[s];
    p.has_frame = true;
    p.origin = fresh(), p.frame = {fresh(), fresh(), fresh()}, p.origin_at = spot();
    return s;
  }

  // Either body may come first.
  std::size_t connect(char letter, std::size_t a, std::size_t b, const Triple& at, const Triple& axis = {},
                      const Triple& second = {}) {
    Link j{letter, a, b, at, axis, second, fresh(), units()};
    if (draw_.maybe()) {
      std::swap(j.a, j.b);
      if (letter == 'U') std::swap(j.axis, j.second);
    }
    links_.push_back(std::move(j));
    return links_.size() - 1;
  }
  // Drives the angle or the displacement of a joint, of body `b` relative to the other one.
  void drive(std::size_t joint, std::size_t b, bool is_angle, std::size_t curve) {
    motors_.push_back({joint, is_angle, links_[joint].b == b ? 1.0 : -1.0, curve});
  }
  // Drives the displacement of a joint as the motion of the units says.
  void follow(std::size_t joint) { followers_.push_back(joint); }
  void drive_pose(std::size_t solid) { poses_.push_back(solid); }

  std::size_t curve(const Curve& c) {
    curves_.push_back(c);
    return curves_.size() - 1;
  }
  [[nodiscard]] Real value(std::size_t curve, long double t) const { return curves_[curve].at(t); }

  // Keeps the unit whose bodies and joints were added since the last call, if it is regular as written.
  bool keep(const Unit& unit, double least) {
    Frames f(solids_.size());
    const std::vector<Curve> all = std::exchange(curves_, std::vector<Curve>(curves_.size()));
    const bool good = unit(0, f) > least;
    curves_ = all;
    if (good) {
      units_.push_back(unit);
      kept_ = {solids_.size(), links_.size(), motors_.size(), followers_.size(), poses_.size(), curves_.size()};
    } else {
      solids_.resize(kept_[0]), links_.resize(kept_[1]), motors_.resize(kept_[2]), followers_.resize(kept_[3]);
      poses_.resize(kept_[4]), curves_.resize(kept_[5]);
    }
    return good;
  }

  [[nodiscard]] Frames frames(long double t) const {
    Frames f(solids_.size());
    for (const Unit& u : units_) u(t, f);
    return f;
  }

  // Makes all motions smaller until no unit comes closer to a singular posture than this.
  bool calm(double least, const TimeGrid& grid) {
    for (int attempt = 0; attempt < 8; ++attempt) {
      double worst = 1;
      for (std::int64_t k = 0; k <= grid.steps() && worst > least; ++k) {
        Frames f(solids_.size());
        for (const Unit& u : units_) {
          const double margin = u(grid.time(k), f);
          worst = margin > least ? std::min(worst, margin) : -1;
          if (worst < 0) break;
        }
      }
      if (worst > least) return true;
      for (Curve& c : curves_) {
        if (c.speed != 0) c = {0.6, 0.5, 0.3};
        c.amplitude *= 0.5, c.offset *= 0.5;
      }
    }
    return false;
  }

  // Angle and displacement of a joint from the posture as written; only those that it has.
  [[nodiscard]] std::pair<Real, Real> coordinates(const Link& j, const Frames& f) const {
    const Frame &a = f[j.a], &b = f[j.b];
    const Triple axis = dimension_ == 3 ? j.axis : Triple{0, 0, 1};
    const Place3 u = references::unit(exact(axis));
    const Place3 e = references::unit(exact(across(axis)));
    const Place3 now = a.turn_back(b.turn(e));
    const Real angle = atan2(references::dot(references::cross(u, e), now), references::dot(e, now));
    const Place3 way = a.turn_back(b.at(j.at) - a.at(j.at));
    return {angle, references::dot(references::unit(exact(j.axis)), way)};
  }

  [[nodiscard]] Scene write(const TimeGrid& grid) {
    std::vector<std::function<void(SceneBuilder&)>> items;
    for (const Solid& s : solids_) {
      if (s.name != "ground") items.emplace_back([&s](SceneBuilder& b) { add(b, s); });
    }
    for (const Link& j : links_) {
      items.emplace_back([this, &j](SceneBuilder& b) { add(b, j); });
      if (!j.measured) continue;
      for (const bool is_angle : {true, false}) {
        if (!has(j, is_angle)) continue;
        items.emplace_back([&j, is_angle](SceneBuilder& b) {
          b.measure(measure_of(j, is_angle), MeasuredCoordinate{coordinate_of(j, is_angle)});
        });
      }
    }
    for (const Motor& m : motors_) {
      const std::string n = fresh();
      drivers_[n] = solids_[std::max(links_[m.joint].a, links_[m.joint].b)].unit;
      items.emplace_back([this, &m, n](SceneBuilder& b) {
        b.drive(n, DrivenCoordinate{coordinate_of(links_[m.joint], m.is_angle), curves_[m.curve].law(m.sign)});
      });
    }
    const std::shared_ptr<const JointMechanism> self = shared_from_this();
    const auto law = [](const std::function<Real(double)>& of) {
      return Law::function([of](double t) {
        const Real r = of(t);
        return Motion{static_cast<double>(r.value), static_cast<double>(r.rate), static_cast<double>(r.acceleration)};
      });
    };
    for (const std::size_t j : followers_) {
      const Law way = law([self, j](double t) { return self->coordinates(self->links_[j], self->frames(t)).second; });
      items.emplace_back([this, j, way, n = fresh()](SceneBuilder& b) {
        b.drive(n, DrivenCoordinate{coordinate_of(links_[j], false), way});
      });
    }
    for (const std::size_t s : poses_) {
      Pose pose{solids_[s].name, {}, {}};
      for (std::size_t k = 0; k < 3; ++k) {
        pose.translation.push_back(
            law([self, s, k](double t) { return self->frames(t)[s].at(self->solids_[s].origin_at)[k]; }));
        pose.rotation.push_back(law([self, s, k](double t) { return angles(self->frames(t)[s])[k]; }));
      }
      items.emplace_back([pose, n = fresh()](SceneBuilder& b) { b.drive(n, pose); });
    }
    for (std::size_t i = items.size(); i > 1; --i) std::swap(items[i - 1], items[draw_.below(i)]);
    SceneBuilder b("joints", dimension_);
    for (const auto& item : items) item(b);
    return std::move(b.time(grid.start, grid.end, grid.step)).build();
  }

  // The motion of all tracers and measures. `scene` is the written one, whose bases bound how errors of unknowns grow.
  void expect_motion(const Scene& scene, const std::string& strategy = "auto") const {
    const double unit = std::ldexp(1, group_equations(scene).system->length_exponent);
    std::map<std::string, double> turns;  // of bodies: error of a direction, for an error of 1 m of the base
    double gain = 1;
    for (const Body& b : scene.bodies()) {
      const double turn = turning_error(scene, b, unit);
      turns[b.name] = turn;
      const Triple at = place(scene, b.base.empty() ? b.origin : b.base[0]).first;
      for (const Solid& s : solids_) {
        if (s.name != b.name) continue;
        for (const auto& [name, p] : s.tracers) {
          gain = std::max<double>(gain, 1 + triple::norm(triple::subtract(p, at)) * turn);
        }
      }
    }
    const TimeGrid grid = scene.time();
    const Scene short_run = scene.with_outputs({"all"}).with_time({grid.start, grid.start + grid.step, grid.step});
    const std::vector<std::string> columns = run(short_run).trajectory.columns();
    const auto has_column = [&](const std::string& name) {
      return std::find(columns.begin(), columns.end(), name) != columns.end();
    };
    std::map<std::string, long double> last;  // angles, through whole turns
    ClosedForm form(scene, gain, [&](double t) {
      Expected e;
      const Frames f = frames(t);
      for (std::size_t s = 1; s < solids_.size(); ++s) {
        for (const auto& [name, at] : solids_[s].tracers) {
          const Place3 p = f[s].at(at);
          if (!has_column(name + ".x")) {  // not an output, because it rests
            EXPECT_LE(triple::norm(triple::subtract(values(p), at)), 16 * kEps * (size_ + triple::norm(at))) << name;
            continue;
          }
          e.points[name] = {quad(p[0]), quad(p[1]), quad(p[2])};
        }
      }
      for (const Link& j : links_) {
        if (!j.measured) continue;
        auto [angle, way] = coordinates(j, f);
        if (has(j, true)) {
          const std::string name = measure_of(j, true);
          constexpr long double kTurn = 2 * std::numbers::pi_v<long double>;
          const auto before = last.find(name);
          if (before != last.end()) angle.value += kTurn * std::round((before->second - angle.value) / kTurn);
          last[name] = angle.value;
          e.measures[name] = {quad(angle), (turns[solids_[j.a].name] + turns[solids_[j.b].name] + 1 / unit) / gain};
        }
        if (has(j, false)) e.measures[measure_of(j, false)] = {quad(way)};
      }
      return e;
    });
    form.expect(strategy);
  }

  // Each group solves one unit. Returns the number of groups of each unit.
  [[nodiscard]] std::vector<int> groups_of_units(const GroupedSystem& s) const {
    std::map<std::string, int> bodies = drivers_;
    for (const Solid& b : solids_) {
      bodies[b.name] = b.unit;
      bodies[b.origin] = b.unit;
      for (const std::string& n : b.frame) bodies[n] = b.unit;
      for (const auto& [name, at] : b.tracers) bodies[name] = b.unit;
    }
    std::vector<int> count(units_.size(), 0);
    for (const SolvedGroup& g : s.groups) {
      std::set<int> units;
      for (const std::int32_t u : g.unknowns) units.insert(unit_of(s.system->coordinate_name(u), bodies));
      EXPECT_EQ(units.size(), 1u) << g.name;
      if (units.size() == 1 && *units.begin() >= 0) ++count[static_cast<std::size_t>(*units.begin())];
    }
    return count;
  }

 private:
  struct Motor {
    std::size_t joint;
    bool is_angle;
    double sign;
    std::size_t curve;
  };

  [[nodiscard]] Triple spot(const Triple& centre, double reach) {
    const double x = draw_.real(-reach, reach), y = draw_.real(-reach, reach), z = draw_.real(-reach, reach);
    return triple::add(centre, {x, y, dimension_ == 3 ? z : 0});
  }
  static Triple across(const Triple& axis) {
    const Triple x = triple::cross(axis, {1, 0, 0}), y = triple::cross(axis, {0, 1, 0});
    return triple::norm(x) > triple::norm(y) ? x : y;
  }
  [[nodiscard]] static bool has(const Link& j, bool is_angle) {
    return j.letter == 'C' || j.letter == (is_angle ? 'R' : 'P');
  }
  static std::string coordinate_of(const Link& j, bool is_angle) {
    return j.name + (is_angle ? ".angle" : ".displacement");
  }
  static std::string measure_of(const Link& j, bool is_angle) { return j.name + (is_angle ? "_angle" : "_way"); }

  // psi, theta, phi of Rz(psi) Ry(theta) Rx(phi).
  static Place3 angles(const Frame& f) {
    return {atan2(f.x[1], f.x[0]), atan2(-f.x[2], sqrt(f.x[0] * f.x[0] + f.x[1] * f.x[1])), atan2(f.y[2], f.z[2])};
  }

  static void add(SceneBuilder& b, const Solid& s) {
    Body body{.name = s.name};
    for (const auto& [name, at] : s.tracers) body.points.push_back({name, at, true});
    if (s.has_frame) {
      body.origin = s.origin, body.frame = s.frame;
      b.point(s.origin, s.origin_at);
      for (std::size_t k = 0; k < 3; ++k) {
        Triple e{};
        e[k] = 1;
        b.vector(s.frame[k], e);
      }
    }
    b.add(std::move(body));
  }
  void add(SceneBuilder& b, const Link& j) const {
    const std::string &a = solids_[j.a].name, &c = solids_[j.b].name;
    switch (j.letter) {
      case 'R':
        b.joint(j.name, dimension_ == 3 ? Revolute{a, c, j.at, j.axis} : Revolute{a, c, j.at});
        break;
      case 'P':
        b.joint(j.name, Prismatic{a, c, j.axis});
        break;
      case 'C':
        b.joint(j.name, Cylindrical{a, c, j.at, j.axis});
        break;
      case 'S':
        b.joint(j.name, Spherical{a, c, j.at});
        break;
      case 'U':
        b.joint(j.name, Universal{a, c, j.at, j.axis, j.second});
        break;
      case 'E':
        b.joint(j.name, Planar{a, c, j.axis});
        break;
      default:
        b.joint(j.name, Fixed{a, c});
    }
  }

  // The unit that determines an unknown. A joint's point and directions belong to both bodies, so that the earlier one
  // determines them; a slide and the point on its second body, to the later one.
  [[nodiscard]] int unit_of(const std::string& unknown, const std::map<std::string, int>& bodies) const {
    const std::size_t dot = unknown.find('.');
    const std::string stem = unknown.substr(0, dot), rest = unknown.substr(dot + 1);
    if (const auto b = bodies.find(stem); b != bodies.end()) return b->second;
    for (const Link& j : links_) {
      if (j.name != stem) continue;
      const int a = solids_[j.a].unit, b = solids_[j.b].unit;
      if (rest.starts_with("origin.") || rest.starts_with("from.") || rest.starts_with("axis_a.")) return a;
      if (rest.starts_with("to.") || rest.starts_with("axis_b.")) return b;
      const bool slides = j.letter == 'P' || j.letter == 'C' || j.letter == 'E';
      if (rest.starts_with("slide.") || rest.starts_with("meet")) return std::max(a, b);
      if (slides && rest.size() == 1) return b;
      return a < 0 ? b : b < 0 ? a : std::min(a, b);
    }
    ADD_FAILURE() << "unknown " << unknown;
    return kNoUnit;
  }

  // Position of a point, or direction of a vector, as written; true: a point.
  static std::pair<Triple, bool> place(const Scene& scene, const std::string& name) {
    for (const Point& p : scene.points()) {
      if (p.name == name) return {p.at, true};
    }
    for (const Vector& v : scene.vectors()) {
      if (v.name == name) return {v.at, false};
    }
    for (const Body& b : scene.bodies()) {
      const auto find = [&](const std::vector<Member>& members) {
        return std::find_if(members.begin(), members.end(), [&](const Member& m) { return m.name == name; });
      };
      const auto p = find(b.points), v = find(b.vectors);
      if (p == b.points.end() && v == b.vectors.end()) continue;
      if (b.base.empty() && b.origin.empty())
        return p != b.points.end() ? std::pair(p->local, true) : std::pair(v->local, false);
      // In the frame of the base.
      const Triple o = place(scene, b.base.empty() ? b.origin : b.base[0]).first;
      std::vector<Triple> ways;
      for (std::size_t k = 1; k < b.base.size(); ++k) {
        const auto [at, is_point] = place(scene, b.base[k]);
        ways.push_back(is_point ? triple::subtract(at, o) : at);
      }
      for (const std::string& n : b.frame) ways.push_back(place(scene, n).first);
      const auto unit = [](const Triple& a) { return triple::scale(1 / triple::norm(a), a); };
      Triple x = unit(ways[0]), y = {-x[1], x[0], 0}, z = {0, 0, 1};
      if (ways.size() > 1) z = unit(triple::cross(x, ways[1])), y = triple::cross(z, x);
      const Triple& l = p != b.points.end() ? p->local : v->local;
      const Triple way =
          triple::add(triple::scale(l[0], x), triple::add(triple::scale(l[1], y), triple::scale(l[2], z)));
      return p != b.points.end() ? std::pair(triple::add(o, way), true) : std::pair(way, false);
    }
    ADD_FAILURE() << "no place " << name;
    return {};
  }

  static double turning_error(const Scene& scene, const Body& b, double unit) {
    if (!b.frame.empty()) return 1 / unit;
    const Triple o = place(scene, b.base[0]).first;
    double shortest = unit, sine = 1;
    std::vector<Triple> ways;
    for (std::size_t k = 1; k < b.base.size(); ++k) {
      const auto [at, is_point] = place(scene, b.base[k]);
      ways.push_back(is_point ? triple::subtract(at, o) : at);
      if (is_point) shortest = std::min<double>(shortest, triple::norm(ways.back()));
    }
    if (ways.size() == 2) {
      sine = triple::norm(triple::cross(ways[0], ways[1])) / (triple::norm(ways[0]) * triple::norm(ways[1]));
    }
    return 1 / (shortest * sine);
  }

  Draw& draw_;
  int dimension_;
  double size_ = 1;
  Triple origin_{};
  std::vector<Solid> solids_;
  std::vector<Link> links_;
  std::vector<Motor> motors_;
  std::vector<std::size_t> followers_, poses_;
  std::vector<Curve> curves_;
  std::vector<Unit> units_;
  std::map<std::string, int> drivers_;  // their units
  std::array<std::size_t, 6> kept_{1, 0, 0, 0, 0, 0};
  int names_ = 0;
};

}  // namespace assur::test
