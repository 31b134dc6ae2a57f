#include "pictures/drawing.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <unordered_map>
#include <utility>
#include <variant>

#include "equations/system.hpp"
#include "index.hpp"
#include "scene/axes.hpp"
#include "structure/grouped_system.hpp"

namespace assur::pictures {
namespace {

using Kind = Drawing::Kind;

// For each coordinate the group that solves it, or Point::kFixed, kDriven, kResting.
std::vector<int> solvers(const GroupedSystem& structure) {
  const System& system = *structure.system;
  using Point = Drawing::Point;
  std::vector<int> solver;
  for (const Coordinate& c : system.coordinates) {
    const bool is_driven = c.role == Role::driven && c.moving;
    solver.push_back(c.role == Role::one ? Point::kFixed : is_driven ? Point::kDriven : Point::kResting);
  }
  for (std::size_t g = 0; g < structure.groups.size(); ++g) {
    for (const Index u : structure.groups[g].unknowns) solver[static_cast<std::size_t>(u)] = static_cast<int>(g);
  }
  return solver;
}

// The last group that a point depends on, by its own coordinates or those of the base of its body.
int solver_of(const System& system, const std::vector<int>& solver, const Item& item) {
  int last = Drawing::Point::kFixed;
  for (int k = 0; k < item.components; ++k) {
    for (const Term& t : system.form(item.form[k])) {
      last = std::max(last, solver[static_cast<std::size_t>(t.coordinate)]);
    }
  }
  return last;
}

class Draughtsman {
 public:
  Draughtsman(const Scene& scene, std::set<std::string> left_out) : scene_(scene), left_out_(std::move(left_out)) {
    out_.dimension = scene.dimension();
  }

  Drawing draw() {
    add_points();
    for (const Constraint& c : scene_.constraints()) {
      c.visit([&](const auto& kind) { relate(c.name, kind); });
    }
    for (const Driver& d : scene_.drivers()) std::visit([&](const auto& kind) { drive(d.name, kind); }, d.kind);
    add_bodies();
    for (auto& [pair, link] : links_) {
      link.inside = is_inside(link);
      out_.links.push_back(link);
    }
    for (const assur::Joint& j : scene_.joints())
      std::visit([&](const auto& kind) { add_joint(j.name, kind); }, j.kind);
    add_sliders();
    add_pins();
    mark_driven();
    return std::move(out_);
  }

 private:
  void add_points() {
    const GroupedSystem structure = group_equations(scene_.with_outputs({}));
    const System& system = *structure.system;
    for (const assur::SolvedGroup& g : structure.groups) out_.groups.push_back({g.name, g.level});
    const std::vector<int> solver = solvers(structure);
    std::vector<Drawing::Point> fixed;
    const auto add = [&](const std::string& name, const Triple& at, bool is_fixed) {
      // The displacement of a joint that cannot slide is measured by NAME.zero.
      if (left_out_.count(name) != 0 || name.ends_with(".zero")) return;
      const Item& item = system.item(name);
      (is_fixed ? fixed : out_.points).push_back({name, solver_of(system, solver, item), at});
    };
    for (const assur::Point& p : scene_.points()) add(p.name, p.at, p.fixed);
    for (const assur::Body& b : scene_.bodies()) {
      for (const Member& m : b.points) add(m.name, m.local, b.name == "ground");
    }
    out_.moving = out_.points.size();
    out_.points.insert(out_.points.end(), fixed.begin(), fixed.end());
    for (std::size_t i = 0; i < out_.points.size(); ++i) index_.emplace(out_.points[i].name, static_cast<int>(i));
  }

  // Index of the point with this name; -1 if there is none.
  [[nodiscard]] int find(const std::string& name) const {
    const auto found = index_.find(name);
    return found == index_.end() ? -1 : found->second;
  }

  // Links a pair once: the more specific kind replaces the other, else the first one stays.
  void link(int from, int to, Kind kind, const std::string& name) {
    if (from < 0 || to < 0 || from == to) return;
    const std::pair pair(std::min(from, to), std::max(from, to));
    const auto [at, is_new] = links_.try_emplace(pair, Drawing::Link{from, to, kind, name});
    if (!is_new && kind < at->second.kind) at->second = {from, to, kind, name};
  }
  void link(const std::string& from, const std::string& to, Kind kind, const std::string& name) {
    link(find(from), find(to), kind, name);
  }
  void link(const Direction& pair, const std::string& name) {
    if (pair.is_pair()) link(pair.first, pair.second, Kind::relation, name);
  }
  // "P.x"
  [[nodiscard]] int point_of(const std::string& coordinate) const {
    return find(coordinate.substr(0, coordinate.rfind('.')));
  }

  // ---- links

  void relate(const std::string& name, const Distance& c) { link(c.p, c.q, Kind::rod, name); }
  void relate(const std::string& name, const EqualDistance& c) {
    link(c.p, c.q, Kind::relation, name);
    link(c.r, c.s, Kind::relation, name);
  }
  void relate(const std::string& name, const Dot& c) {
    link(c.d, name);
    link(c.e, name);
    if (c.value && *c.value == 0) squares_.emplace_back(c.d, c.e);
    if (c.d.is_pair()) slides_.emplace(name, Slide{find(c.d.second), find(c.d.first), {}});
  }
  void relate(const std::string& name, const Parallel& c) {
    link(c.d, name);
    link(c.e, name);
  }
  // "P - Q = 0" is a pin, "P - Q = vectors" a rod. If more points are related, each is linked to the first.
  void relate(const std::string& name, const Linear& c) {
    std::vector<std::pair<int, double>> points;
    std::vector<std::string> vectors;
    for (const auto& [term, factor] : c.terms) {
      const int point = find(term);
      if (point >= 0) {
        points.emplace_back(point, factor);
      } else {
        vectors.push_back(term);
      }
    }
    const bool is_difference = points.size() == 2 && points[0].second == -points[1].second;
    if (is_difference && vectors.empty() && c.value == Triple{}) {
      same_.emplace_back(std::min(points[0].first, points[1].first), std::max(points[0].first, points[1].first));
      return;
    }
    const bool is_rod = is_difference && !vectors.empty();
    for (std::size_t i = 1; i < points.size(); ++i) {
      link(points[0].first, points[i].first, is_rod ? Kind::rod : Kind::relation, name);
    }
    if (is_rod && vectors.size() == 1) rod_along_.emplace(vectors[0], std::pair(points[0].first, points[1].first));
  }
  void relate(const std::string&, const FixedCoordinate& c) {
    const int point = point_of(c.coordinate);
    if (point >= 0) held_[point].insert(c.coordinate.back());
  }
  void relate(const std::string& name, const OnLine& c) {
    slides_.emplace(name, Slide{find(c.p), find(c.a), {axis(c.d)}});
    sliding_.push_back(name);
  }
  void relate(const std::string& name, const OnPlane& c) {
    slides_.emplace(name, Slide{find(c.p), find(c.a), {axis(c.d), axis(c.e)}});
    sliding_.push_back(name);
  }
  void relate(const std::string&, const Gear&) {}  // a Callback in every scene that was built
  void relate(const std::string& name, const Callback& c) {
    int before = -1;
    for (const std::string& coordinate : c.coordinates) {
      const int point = point_of(coordinate);
      if (point < 0) continue;
      link(before, point, Kind::relation, name);
      before = point;
    }
  }

  // An angle driver keeps the distance of its points constant.
  void drive(const std::string& name, const PointAngle& d) {
    link(d.a, d.b, Kind::rod, name);
    driven_points_.insert(find(d.a));
    if (!axis_of(d).empty()) hinges_.emplace(find(d.a), direction(axis_of(d)));
  }
  // A joint between two moving bodies is driven by the angle between its vectors NAME.from and NAME.to; else the angle
  // is that of two links, which may meet in a point.
  void drive(const std::string& name, const RelativeAngle& d) {
    link(d.d, name);
    link(d.e, name);
    if (d.d.first.ends_with(".from")) driven_turns_.insert(d.d.first.substr(0, d.d.first.rfind('.')));
    if (!d.d.is_pair() || !d.e.is_pair()) return;
    for (const std::string& p : {d.d.first, d.d.second}) {
      if (p == d.e.first || p == d.e.second) driven_points_.insert(find(p));
    }
  }
  void drive(const std::string& name, const DrivenDistance& d) { link(d.a, d.b, Kind::actuator, name); }
  // "S.slide.lambda" of a joint, "slide.lambda" of a constraint, "P.x" of a point.
  void drive(const std::string&, const DrivenCoordinate& d) {
    const std::string slide = d.coordinate.substr(0, d.coordinate.rfind('.'));
    driven_slides_.insert(slide.substr(0, slide.rfind(".slide")));
  }
  void drive(const std::string&, const Pose&) {}

  // ---- bodies

  void add_bodies() {
    bodies_at_.resize(out_.points.size());
    for (const assur::Body& b : scene_.bodies()) {
      if (b.name == "ground") continue;
      Drawing::Body body{b.name, {}};
      const auto add = [&](const std::string& name) {
        const int point = find(name);
        // The end of an arm that only carries a driven angle, and the origin of a pose, are no parts of the body.
        if (point < 0 || name.ends_with(".arm") || name == b.name + ".origin") return;
        if (std::find(body.points.begin(), body.points.end(), point) == body.points.end()) body.points.push_back(point);
      };
      if (!b.origin.empty()) add(b.origin);
      for (const std::string& p : b.base) add(p);
      for (const Member& m : b.points) add(m.name);
      if (body.points.size() < 2) continue;
      for (const int p : body.points) bodies_at_[idx(p)].push_back(static_cast<int>(out_.bodies.size()));
      out_.bodies.push_back(std::move(body));
    }
  }

  [[nodiscard]] bool is_inside(const Drawing::Link& l) const {
    if (idx(l.from) >= out_.moving && idx(l.to) >= out_.moving) return true;
    const std::vector<int>&a = bodies_at_[idx(l.from)], &b = bodies_at_[idx(l.to)];
    return std::any_of(a.begin(), a.end(), [&](int i) { return std::find(b.begin(), b.end(), i) != b.end(); });
  }

  // ---- directions

  // Index of the direction of a vector; -1 if the scene has no such vector.
  int direction(const std::string& name) {
    if (!indexed_) index_vectors();
    const auto found = directions_.find(name);
    if (found == directions_.end() || left_out_.count(name) != 0) return -1;
    auto& [index, is] = found->second;
    if (index < 0) {
      index = static_cast<int>(out_.directions.size());
      out_.directions.push_back(is);
    }
    return index;
  }
  void index_vectors() {
    indexed_ = true;
    for (const Vector& v : scene_.vectors()) {
      directions_.emplace(v.name, std::pair(-1, Drawing::Direction{v.name, v.fixed, v.at}));
    }
    for (const assur::Body& b : scene_.bodies()) {
      for (const Member& m : b.vectors) {
        directions_.emplace(m.name, std::pair(-1, Drawing::Direction{m.name, b.name == "ground", m.local}));
      }
    }
  }
  Drawing::Axis axis(const Direction& d) {
    if (d.is_pair()) return {-1, find(d.first), find(d.second)};
    return {direction(d.first), -1, -1};
  }

  // ---- joints

  static std::string name_of(const Anchor& anchor, std::string otherwise) {
    const auto* given = std::get_if<std::string>(&anchor);
    return given != nullptr ? *given : std::move(otherwise);
  }
  template <class Kind>
  void add_joint(const std::string& name, const Kind& j, Drawing::Symbol symbol, int point,
                 std::vector<Drawing::Axis> axes, int origin = -1) {
    if (point < 0) return;
    std::erase_if(axes, [](const Drawing::Axis& a) { return a.direction < 0 && (a.from < 0 || a.to < 0); });
    jointed_.insert(point);
    out_.joints.push_back({name, symbol, point, std::move(axes), origin, {j.a, j.b}});
  }
  void add_joint(const std::string& name, const Revolute& j) {
    std::vector<Drawing::Axis> axes;
    if (out_.dimension == 3) axes.push_back(axis(name_of(j.axis, name + ".axis")));
    add_joint(name, j, Drawing::Symbol::revolute, find(name_of(j.at, name)), axes);
  }
  void add_joint(const std::string& name, const Prismatic& j) { add_slide(name, j, Drawing::Symbol::prismatic); }
  void add_joint(const std::string& name, const Cylindrical& j) { add_slide(name, j, Drawing::Symbol::cylindrical); }
  void add_joint(const std::string& name, const Spherical& j) {
    add_joint(name, j, Drawing::Symbol::spherical, find(name_of(j.at, name)), {});
  }
  void add_joint(const std::string& name, const Universal& j) {
    add_joint(name, j, Drawing::Symbol::universal, find(name_of(j.at, name)),
              {axis(name_of(j.axis_a, name + ".axis_a")), axis(name_of(j.axis_b, name + ".axis_b"))});
  }
  void add_joint(const std::string& name, const Planar& j) {
    const auto slide = slides_.find(name + ".slide");
    if (slide == slides_.end()) return;
    add_joint(name, j, Drawing::Symbol::planar, slide->second.point, {axis(name_of(j.normal, name + ".normal"))},
              slide->second.origin);
  }
  void add_joint(const std::string&, const Fixed&) {}
  template <class Kind>
  void add_slide(const std::string& name, const Kind& j, Drawing::Symbol symbol) {
    const auto slide = slides_.find(name + ".slide");
    if (slide == slides_.end()) return;
    add_joint(name, j, symbol, slide->second.point, slide->second.axes, slide->second.origin);
    std::erase(sliding_, slide->first);
  }

  // Points on lines and planes, and points of which all coordinates but one are constant.
  void add_sliders() {
    for (const std::string& name : sliding_) {
      const Slide& s = slides_.at(name);
      if (s.point < 0 || s.origin < 0) continue;
      const auto symbol = s.axes.size() == 2 ? Drawing::Symbol::planar : Drawing::Symbol::prismatic;
      jointed_.insert(s.point);
      out_.joints.push_back({name, symbol, s.point, s.axes, s.origin, {}});
    }
    for (const auto& [point, held] : held_) {
      const auto dimension = static_cast<std::size_t>(out_.dimension);
      if (held.size() + 1 != dimension || idx(point) >= out_.moving || !jointed_.insert(point).second) continue;
      std::size_t along = 0;
      while (held.count("xyz"[along]) != 0) ++along;
      Drawing::Direction d{"", true, {}};
      d.at[along] = 1;
      out_.directions.push_back(d);
      const int last = static_cast<int>(out_.directions.size()) - 1;
      out_.joints.push_back(
          {out_.points[idx(point)].name, Drawing::Symbol::prismatic, point, {{last, -1, -1}}, -1, {}});
    }
  }

  // Points where links and bodies meet, or stand on the ground.
  void add_pins() {
    for (const auto& [d, e] : squares_) {
      add_hinge(d, e);
      add_hinge(e, d);
    }
    std::vector<std::size_t> parts(out_.points.size());
    for (const Drawing::Link& l : out_.links) {
      if (l.inside || l.kind == Kind::relation) continue;
      ++parts[idx(l.from)], ++parts[idx(l.to)];
    }
    for (std::size_t i = 0; i < parts.size(); ++i) parts[i] += bodies_at_[i].size();
    for (const auto& [one, other] : same_) {  // the ground is the other one
      parts[idx(other)] += parts[idx(one)];
      if (jointed_.count(one) != 0) jointed_.insert(other);
      jointed_.insert(one);
    }
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const bool is_fixed = i >= out_.moving;
      const int point = static_cast<int>(i);
      if (parts[i] < (is_fixed ? 1U : 2U) || jointed_.count(point) != 0) continue;
      Drawing::Joint pin{out_.points[i].name, Drawing::Symbol::revolute, point};
      const auto hinge = hinges_.find(point);
      if (hinge != hinges_.end() && hinge->second >= 0) {
        pin.axes = {{hinge->second, -1, -1}};
      } else if (out_.dimension == 3) {
        pin.symbol = Drawing::Symbol::spherical;
      }
      out_.joints.push_back(std::move(pin));
    }
  }
  // A rod on the ground at right angles to a fixed vector turns about it.
  void add_hinge(const Direction& rod, const Direction& vector) {
    if (out_.dimension == 2 || vector.is_pair()) return;
    const auto by_vector = rod_along_.find(rod.first);
    const bool is_rod = rod.is_pair() || by_vector != rod_along_.end();
    if (!is_rod) return;
    const auto [a, b] = rod.is_pair() ? std::pair(find(rod.first), find(rod.second)) : by_vector->second;
    if (a < 0 || b < 0) return;
    const int fixed = idx(a) >= out_.moving ? a : idx(b) >= out_.moving ? b : -1;
    const int along = direction(vector.first);
    if (fixed >= 0 && along >= 0 && out_.directions[idx(along)].fixed) hinges_.emplace(fixed, along);
  }

  void mark_driven() {
    for (Drawing::Joint& j : out_.joints) {
      using enum Drawing::Symbol;
      const bool turns = j.symbol == revolute || j.symbol == cylindrical;
      const bool slides = j.symbol == prismatic || j.symbol == cylindrical;
      j.driven = (turns && (driven_points_.count(j.point) != 0 || driven_turns_.count(j.name) != 0)) ||
                 (slides && driven_slides_.count(j.name) != 0);
    }
  }

  struct Slide {
    int point = -1, origin = -1;
    std::vector<Drawing::Axis> axes;
  };

  const Scene& scene_;
  std::set<std::string> left_out_;
  Drawing out_;
  std::unordered_map<std::string, int> index_;
  std::unordered_map<std::string, std::pair<int, Drawing::Direction>> directions_;  // index, or -1 if not drawn
  bool indexed_ = false;                                                            // `directions_` is filled
  std::map<std::pair<int, int>, Drawing::Link> links_;
  std::unordered_map<std::string, std::pair<int, int>> rod_along_;  // rods that are multiples of a vector
  std::vector<std::pair<Direction, Direction>> squares_;            // directions at right angles
  std::vector<std::pair<int, int>> same_;                           // points at one place, in ascending order
  std::map<int, int> hinges_;                                       // points, directions
  std::map<int, std::set<char>> held_;                              // points and their constant coordinates
  std::map<std::string, Slide> slides_;                             // by constraint
  std::vector<std::string> sliding_;                                // of these: points on lines and planes
  std::vector<std::vector<int>> bodies_at_;                         // of each point
  std::set<int> jointed_;                                           // points
  std::set<std::string> driven_turns_, driven_slides_;              // names of joints
  std::set<int> driven_points_;                                     // points about which a driver turns a part
};

}  // namespace

Drawing drawing_of(const Scene& scene, std::set<std::string> left_out) {
  return Draughtsman(scene, std::move(left_out)).draw();
}

}  // namespace assur::pictures
