#include "joints/random_joints.hpp"

#include <cmath>
#include <numbers>
#include <optional>

namespace assur::test {
namespace {

using mechanisms::PlainEquations;
using mechanisms::PlainMotion;
using triple::add;
using triple::cross;
using triple::norm;
using triple::scale;
using triple::subtract;

constexpr double kRegular = 100, kCalm = 300;  // largest conditions of the plain equations, as written and in motion

Triple unit(const Triple& a) { return scale(1 / norm(a), a); }

Triple place(const PlainEquations& scene, const std::string& name) {
  const mechanisms::Spatial<mechanisms::Real> at = scene.written(name).first;
  return {static_cast<double>(at.x), static_cast<double>(at.y), static_cast<double>(at.z)};
}

// The error of a direction of a body, for an error of 1 m of its base.
double turning_error(const PlainEquations& scene, const Body& b, double unit_of_length) {
  if (!b.frame.empty()) return 1 / unit_of_length;
  double shortest = unit_of_length, sine = 1;
  std::vector<Triple> ways;
  for (std::size_t k = 1; k < b.base.size(); ++k) {
    const bool is_point = scene.written(b.base[k]).second;
    const Triple at = place(scene, b.base[k]);
    ways.push_back(is_point ? subtract(at, place(scene, b.base[0])) : at);
    if (is_point) shortest = std::min<double>(shortest, norm(ways.back()));
  }
  if (ways.size() == 2) sine = norm(cross(ways[0], ways[1])) / (norm(ways[0]) * norm(ways[1]));
  return 1 / (shortest * sine);
}

// An axis of the plain frame of a body.
std::string axis_of(const JointMechanism::Solid& s, std::size_t k) {
  return s.has_frame ? s.frame[k] : s.name + "_" + "xyz"[k];
}

QuadJet quad(const mechanisms::TimeJet<long double>& j) { return {Quad(j.value), Quad(j.rate), Quad(j.curve)}; }

}  // namespace

Law Curve::law(double sign, double begin) const {
  const Law law =
      Law::harmonics({{sign * amplitude, frequency, phase}}, begin + sign * (offset - amplitude * std::sin(phase))) +
      Law::polynomial({0, sign * speed});
  return by_function ? Law::function([law](double t) { return law(t); }) : law;
}

// ---- drawing

JointMechanism::JointMechanism(Draw& draw, int dimension) : draw_(draw), dimension_(dimension) {
  size_ = std::pow(10, draw.real(-2, 2));
  origin_ = draw.below(3) == 0 ? spot({}, 5 * size_) : Triple{};
  solids_.push_back({.name = "ground"});
}

Triple JointMechanism::spot(const Triple& centre, double reach) {
  const double x = draw_.real(-reach, reach), y = draw_.real(-reach, reach), z = draw_.real(-reach, reach);
  return add(centre, {x, y, dimension_ == 3 ? z : 0});
}

Triple JointMechanism::direction() {
  for (;;) {
    const Triple v = spot({}, 1);
    if (const double n = norm(v); n > 0.3 && n < 1) return scale(draw_.real(0.5, 3) / n, v);
  }
}

Triple JointMechanism::square_to(const Triple& axis) {
  while (dimension_ == 3) {
    const Triple other = cross(axis, direction());
    if (norm(other) > 0.3 * norm(axis)) return other;
  }
  return {};
}

Curve JointMechanism::swinging(double most) {
  Curve c{most * draw_.real(0.3, 1), draw_.real(0.3, 1), draw_.real(0, 2 * std::numbers::pi)};
  if (draw_.below(6) == 0) c.offset = 0.1 * c.amplitude;
  c.by_function = draw_.below(4) == 0;
  return c;
}

Curve JointMechanism::angle() {
  if (draw_.below(3) == 0) return {.speed = 2 * draw_.sign() * std::numbers::pi};
  return swinging(0.6);
}

std::size_t JointMechanism::body() {
  Solid s{fresh(), units()};
  for (int i = 0; i < 2; ++i) s.tracers.emplace_back(fresh(), spot());
  solids_.push_back(std::move(s));
  return solids_.size() - 1;
}

std::size_t JointMechanism::rod(const Triple& middle) {
  solids_.push_back({fresh(), units(), {{fresh(), middle}}, true});
  return solids_.size() - 1;
}

std::size_t JointMechanism::platform() {
  const std::size_t s = body();
  Solid& p = solids_[s];
  p.has_frame = true;
  p.origin = fresh(), p.frame = {fresh(), fresh(), fresh()}, p.origin_at = spot();
  return s;
}

std::size_t JointMechanism::connect(char letter, std::size_t a, std::size_t b, const Triple& at, const Triple& axis,
                                    const Triple& second, bool spins) {
  Link j{letter, a, b, at, axis, second, fresh(), units(), spins};
  if (draw_.maybe()) std::swap(j.a, j.b), std::swap(j.axis, j.second);
  if (letter != 'U' && !spins) j.axis = axis;
  links_.push_back(std::move(j));
  return links_.size() - 1;
}

void JointMechanism::drive_pose(std::size_t solid) {
  const Curve x = shift(), y = shift(), z = shift();
  const Curve psi = swinging(0.4), theta = swinging(0.4), phi = swinging(0.4);
  poses_.push_back({solid, {x, y, z, psi, theta, phi}});
}

bool JointMechanism::keep(const std::string& kind) {
  PlainMotion motion(plainly());
  const bool good = begin(motion) && motion.condition() < kRegular;
  if (good) {
    kinds_.push_back(kind);
    kept_ = {solids_.size(), links_.size(), motors_.size(), poses_.size()};
  } else {
    solids_.resize(kept_[0]), links_.resize(kept_[1]), motors_.resize(kept_[2]), poses_.resize(kept_[3]);
  }
  return good;
}

// ---- plainly

Pose JointMechanism::pose(const Posed& p) const {
  Pose out{solids_[p.solid].name, {}, {}};
  for (std::size_t k = 0; k < 3; ++k) {
    out.translation.push_back(p.curves[k].law(1, solids_[p.solid].origin_at[k]));
    out.rotation.push_back(p.curves[3 + k].law(1));
  }
  return out;
}

Scene JointMechanism::plainly() const {
  SceneBuilder b("plainly", dimension_);
  std::vector<Body> bodies;
  for (const Solid& s : solids_) {
    Body& body = bodies.emplace_back(Body{.name = s.name});
    for (const auto& [name, at] : s.tracers) body.points.push_back({name, subtract(at, s.origin_at)});
    const bool is_ground = bodies.size() == 1;
    if (!is_ground) body.origin = s.has_frame ? s.origin : s.name + "_o", b.point(body.origin, s.origin_at);
    for (std::size_t k = 0; k < (dimension_ == 3 ? 3 : 1); ++k) {
      Triple e{};
      e[k] = 1;
      const std::string name = axis_of(s, k);
      is_ground ? b.fixed_vector(name, e) : b.vector(name, e);
      if (!is_ground) body.frame.push_back(name);
    }
  }
  for (const Link& j : links_) add_plainly(b, bodies, j);
  for (Body& body : bodies) b.add(std::move(body));
  for (const Motor& m : motors_) {
    const std::string& n = links_[m.joint].name;
    const Law law = m.curve.law(m.sign);
    if (m.is_angle) {
      b.drive("drive_" + n, RelativeAngle{n + "_ea", n + "_eb", dimension_ == 3 ? n + "_ua" : "", law});
    } else {
      b.drive("push_" + n, DrivenCoordinate{n + "_line.lambda", law});
    }
  }
  for (const Posed& p : poses_) b.drive("pose_" + solids_[p.solid].name, pose(p));
  return b.time(0, 1, 1).build();
}

void JointMechanism::add_plainly(SceneBuilder& b, std::vector<Body>& bodies, const Link& j) const {
  const std::string& n = j.name;
  const auto member = [&](const char* part, bool is_point, const Triple& on_a, const Triple& on_b) {
    for (const bool first : {true, false}) {
      const std::size_t s = first ? j.a : j.b;
      const Triple& at = first ? on_a : on_b;
      const std::string name = n + part + (first ? "a" : "b");
      if (is_point) {
        bodies[s].points.push_back({name, subtract(at, solids_[s].origin_at)});
      } else {
        bodies[s].vectors.push_back({name, unit(at)});
      }
    }
  };
  const auto equal = [&](const std::string& what, const std::string& p, const std::string& q) {
    b.constrain(n + what, Linear{{{p, 1}, {q, -1}}, {}});
  };
  const bool in_space = dimension_ == 3, slides = has(j, false), turns = has(j, true);
  const char letter = j.spins ? 'U' : j.letter;
  member("_p", true, j.at, j.at);
  if (letter == 'U') {
    member("_u", false, j.axis, j.second);
    b.constrain(n + "_square", Dot{n + "_ua", n + "_ub"});
  } else if (letter != 'S' && (in_space || slides)) {
    member("_u", false, j.axis, j.axis);
  }
  if (letter == 'P') {
    for (std::size_t k = 0; k < (in_space ? 2 : 1); ++k) {
      equal(std::string("_same_") + "xyz"[k], axis_of(solids_[j.a], k), axis_of(solids_[j.b], k));
    }
  } else if (in_space && letter != 'S' && letter != 'U') {
    equal("_axes", n + "_ua", n + "_ub");
  }
  if (slides) b.constrain(n + "_line", OnLine{n + "_pb", n + "_pa", n + "_ua"});
  if (letter == 'E') b.constrain(n + "_flat", Dot{Direction(n + "_pa", n + "_pb"), n + "_ua", 0.0});
  if (!slides && letter != 'E') equal("_meet", n + "_pa", n + "_pb");
  if (slides) b.measure(measure_of(j, false), MeasuredCoordinate{n + "_line.lambda"});
  if (!turns) return;
  const Triple e = in_space ? across(j.axis) : Triple{1, 0, 0};
  member("_e", false, e, e);
  b.measure(measure_of(j, true), AngleBetween{n + "_ea", n + "_eb", in_space ? n + "_ua" : ""});
}

std::vector<JointMechanism::Jet> JointMechanism::laws_as_written() const {
  std::vector<Jet> out(motors_.size(), Jet(0));
  for (const Posed& p : poses_) {
    for (std::size_t k = 0; k < 6; ++k) out.emplace_back(k < 3 ? solids_[p.solid].origin_at[k].value() : 0.0);
  }
  return out;
}

bool JointMechanism::begin(PlainMotion& motion) const {
  double figure = 0;
  return motion.start_as_written(laws_as_written(), figure) == PlainMotion::Start::right;
}

// Returns false if a posture comes close to a singular one.
bool JointMechanism::follow(const TimeGrid& grid) {
  PlainMotion motion(plainly());
  const PlainEquations& equations = motion.equations();
  const std::vector<Jet> written = laws_as_written(), first = mechanisms::laws_at(equations, grid.start);
  const auto from_drawing = [&](long double s) {
    std::vector<Jet> out;
    for (std::size_t i = 0; i < first.size(); ++i) {
      const long double way = first[i].value - written[i].value;
      out.emplace_back(written[i].value + s * way, way, 0);
    }
    return out;
  };
  if (!begin(motion) || motion.advance(from_drawing) < 1) return false;
  std::vector<PlainEquations::Column> columns, angles;
  for (const Solid& s : solids_) {
    for (const auto& [name, at] : s.tracers) {
      for (int k = 0; k < dimension_; ++k) columns.push_back(equations.column(name + "." + "xyz"[k]));
    }
  }
  for (const Link& j : links_) {
    if (has(j, false)) columns.push_back(equations.column(measure_of(j, false)));
    if (has(j, true)) angles.push_back(equations.column(measure_of(j, true)));
  }
  rows_.clear();
  for (std::int64_t k = 0; k <= grid.steps(); ++k) {
    const double t = grid.time(k);
    if (k > 0 && motion.advance(grid.time(k - 1), t) < 1) return false;
    if (!motion.settle(mechanisms::laws_at(equations, t)) || motion.condition() > kCalm) return false;
    if (k == 0) motion.follow(angles);
    auto& row = rows_.emplace_back();
    const std::vector<Jet> now = motion.show(columns), turned = motion.turned();
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const auto& c = columns[i];
      row[c.measure >= 0 ? c.output : c.output + "." + "xyz"[c.component]] = now[i];
    }
    for (std::size_t i = 0; i < angles.size(); ++i) row[angles[i].output] = turned[i];
  }
  return true;
}

bool JointMechanism::calm(const TimeGrid& grid) {
  const auto smaller = [](Curve& c) {
    if (c.speed != 0) c = {0.6, 0.5, 0.3};
    c.amplitude *= 0.5, c.offset *= 0.5;
  };
  for (int attempt = 0; attempt < 8; ++attempt) {
    if (follow(grid)) return true;
    for (Motor& m : motors_) smaller(m.curve);
    for (Posed& p : poses_) {
      for (Curve& c : p.curves) smaller(c);
    }
  }
  return false;
}

// ---- with joints

Scene JointMechanism::write(const TimeGrid& grid) {
  std::vector<std::function<void(SceneBuilder&)>> items;
  for (std::size_t s = 1; s < solids_.size(); ++s) {
    items.emplace_back([&solid = solids_[s]](SceneBuilder& b) {
      Body body{.name = solid.name, .origin = solid.origin, .frame = solid.frame};
      for (const auto& [name, at] : solid.tracers) body.points.push_back({name, at, true});
      if (solid.has_frame) b.point(solid.origin, solid.origin_at);
      for (std::size_t k = 0; k < solid.frame.size(); ++k) {
        Triple e{};
        e[k] = 1;
        b.vector(solid.frame[k], e);
      }
      b.add(std::move(body));
    });
  }
  const auto coordinate = [](const Link& j, bool is_angle) { return j.name + (is_angle ? ".angle" : ".displacement"); };
  for (const Link& j : links_) {
    items.emplace_back([this, &j](SceneBuilder& b) {
      test::add(b, {j.letter, j.name, solids_[j.a].name, solids_[j.b].name, j.at, j.axis, j.second}, dimension_);
    });
    for (const bool is_angle : {true, false}) {
      if (!has(j, is_angle)) continue;
      items.emplace_back([&, is_angle](SceneBuilder& b) {
        b.measure(measure_of(j, is_angle), MeasuredCoordinate{coordinate(j, is_angle)});
      });
    }
  }
  for (const Motor& m : motors_) {
    const std::string n = fresh();
    drivers_[n] = solids_[std::max(links_[m.joint].a, links_[m.joint].b)].unit;
    items.emplace_back([&, n](SceneBuilder& b) {
      b.drive(n, DrivenCoordinate{coordinate(links_[m.joint], m.is_angle), m.curve.law(m.sign)});
    });
  }
  for (const Posed& p : poses_) {
    items.emplace_back([&, n = fresh()](SceneBuilder& b) { b.drive(n, pose(p)); });
  }
  for (std::size_t i = items.size(); i > 1; --i) std::swap(items[i - 1], items[draw_.below(i)]);
  SceneBuilder b("joints", dimension_);
  for (const auto& item : items) item(b);
  return std::move(b.time(grid.start, grid.end, grid.step)).build();
}

void JointMechanism::expect_motion(const Scene& scene) const {
  const double unit_of_length = std::ldexp(1, group_equations(scene).system->length_exponent);
  const PlainEquations written(scene);
  std::map<std::string, double> turns;  // of bodies
  double gain = 1;
  for (const Body& b : scene.bodies()) {
    turns[b.name] = turning_error(written, b, unit_of_length);
    const Triple at = place(written, b.base.empty() ? b.origin : b.base[0]);
    for (const Solid& s : solids_) {
      if (s.name != b.name) continue;
      for (const auto& [name, p] : s.tracers) {
        gain = std::max<double>(gain, 1 + norm(subtract(p, at)) * turns[b.name]);
      }
    }
  }
  const TimeGrid grid = scene.time();
  const Scene short_run = scene.with_outputs({"all"}).with_time({grid.start, grid.start + grid.step, grid.step});
  const std::vector<std::string> columns = run(short_run).trajectory.columns();
  auto row = rows_.begin();
  ClosedForm motion(scene, gain, [&](double) {
    Expected e;
    for (const Solid& s : solids_) {
      for (const auto& [name, at] : s.tracers) {
        Point3 p = references::exactly<QuadJet>({});
        for (std::size_t k = 0; k < static_cast<std::size_t>(dimension_); ++k) {
          p[k] = quad(row->at(name + "." + "xyz"[k]));
        }
        if (std::find(columns.begin(), columns.end(), name + ".x") != columns.end()) {
          e.points[name] = p;
          continue;
        }
        // Not an output, because it rests.
        const Point3 off = p - references::exactly<QuadJet>(at);
        EXPECT_LE(static_cast<double>(norm(off).value), 16 * kEps * (size_ + norm(at))) << name;
      }
    }
    for (const Link& j : links_) {
      const double turn = (turns[solids_[j.a].name] + turns[solids_[j.b].name] + 1 / unit_of_length) / gain;
      if (has(j, true)) e.measures[measure_of(j, true)] = {quad(row->at(measure_of(j, true))), turn};
      if (has(j, false)) e.measures[measure_of(j, false)] = {quad(row->at(measure_of(j, false)))};
    }
    ++row;
    return e;
  });
  motion.expect("auto");
}

bool JointMechanism::rests(int unit) const {
  const auto moves = [&](const Link& j, bool is_angle) {
    const double least = 1e-9 * (is_angle ? 1 : size_);
    return j.unit == unit && has(j, is_angle) && std::any_of(rows_.begin(), rows_.end(), [&](const auto& row) {
             return std::abs(row.at(measure_of(j, is_angle)).value) > least;
           });
  };
  return std::none_of(links_.begin(), links_.end(), [&](const Link& j) { return moves(j, true) || moves(j, false); });
}

std::vector<int> JointMechanism::groups_of_units(const GroupedSystem& s) const {
  std::map<std::string, int> bodies = drivers_;
  for (const Solid& b : solids_) {
    bodies[b.name] = bodies[b.origin] = b.unit;
    for (const std::string& n : b.frame) bodies[n] = b.unit;
    for (const auto& [name, at] : b.tracers) bodies[name] = b.unit;
  }
  std::vector<int> count(kinds_.size(), 0);
  for (const SolvedGroup& g : s.groups) {
    std::set<int> units;
    for (const std::int32_t u : g.unknowns) units.insert(unit_of(s.system->coordinate_name(u), bodies));
    EXPECT_EQ(units.size(), 1u) << g.name;
    if (units.size() == 1 && *units.begin() >= 0) ++count[static_cast<std::size_t>(*units.begin())];
  }
  return count;
}

// The unit that determines an unknown. A joint's point and directions belong to both bodies, so that the earlier one
// determines them; a slide and the point on its second body, to the later one.
int JointMechanism::unit_of(const std::string& unknown, const std::map<std::string, int>& bodies) const {
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

}  // namespace assur::test
