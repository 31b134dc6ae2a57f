#include "pictures/drawing.hpp"

#include <algorithm>
#include <map>
#include <unordered_map>
#include <utility>
#include <variant>

#include "assur/structure.hpp"
#include "scene/system.hpp"

namespace assur::pictures {
namespace {

using Kind = Drawing::Kind;

// For each coordinate the group that solves it, or Point::kFixed, kDriven, kResting.
std::vector<int> solvers(const Structure& structure) {
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
  explicit Draughtsman(const Scene& scene) : scene_(scene) { out_.dimension = scene.dimension(); }

  Drawing draw() {
    add_points();
    for (const Constraint& c : scene_.constraints()) {
      c.visit([&](const auto& kind) { relate(c.name, kind); });
    }
    for (const Driver& d : scene_.drivers()) std::visit([&](const auto& kind) { drive(d.name, kind); }, d.kind);
    add_bodies();
    for (const auto& [pair, link] : links_) out_.links.push_back(link);
    return std::move(out_);
  }

 private:
  void add_points() {
    const Structure structure = analyze(scene_.with_outputs({}));
    const System& system = *structure.system;
    for (const assur::Group& g : structure.groups) out_.groups.push_back({g.name, g.level});
    const std::vector<int> solver = solvers(structure);
    std::vector<Drawing::Point> fixed;
    const auto add = [&](const std::string& name, const Triple& at, bool is_fixed) {
      const Item& item = system.item(name);
      (is_fixed ? fixed : out_.points).push_back({name, solver_of(system, solver, item), false, at});
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

  void relate(const std::string& name, const Distance& c) { link(c.p, c.q, Kind::rod, name); }
  void relate(const std::string& name, const EqualDistance& c) {
    link(c.p, c.q, Kind::relation, name);
    link(c.r, c.s, Kind::relation, name);
  }
  void relate(const std::string& name, const Dot& c) {
    link(c.d, name);
    link(c.e, name);
  }
  void relate(const std::string& name, const Parallel& c) {
    link(c.d, name);
    link(c.e, name);
  }
  // "P - Q = vector" is a rod. If more points are related, each is linked to the first.
  void relate(const std::string& name, const Linear& c) {
    std::vector<std::pair<int, double>> points;
    std::size_t vectors = 0;
    for (const auto& [term, factor] : c.terms) {
      const int point = find(term);
      if (point >= 0) {
        points.emplace_back(point, factor);
      } else {
        ++vectors;
      }
    }
    const bool is_rod = points.size() == 2 && vectors == 1 && points[0].second == -points[1].second;
    for (std::size_t i = 1; i < points.size(); ++i) {
      link(points[0].first, points[i].first, is_rod ? Kind::rod : Kind::relation, name);
    }
  }
  void relate(const std::string&, const FixedCoordinate&) {}
  void relate(const std::string& name, const OnLine& c) { slide(name, c.p, c.a); }
  void relate(const std::string& name, const OnPlane& c) { slide(name, c.p, c.a); }
  void slide(const std::string& name, const std::string& p, const std::string& a) {
    link(a, p, Kind::rail, name);
    if (const int point = find(p); point >= 0) out_.points[static_cast<std::size_t>(point)].slides = true;
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
  void drive(const std::string& name, const PointAngle& d) { link(d.a, d.b, Kind::rod, name); }
  void drive(const std::string& name, const RelativeAngle& d) {
    link(d.d, name);
    link(d.e, name);
  }
  void drive(const std::string& name, const DrivenDistance& d) { link(d.a, d.b, Kind::actuator, name); }
  void drive(const std::string&, const DrivenCoordinate&) {}
  void drive(const std::string&, const Pose&) {}

  void add_bodies() {
    for (const assur::Body& b : scene_.bodies()) {
      if (b.name == "ground") continue;
      Drawing::Body body{b.name, {}};
      const auto add = [&](const std::string& name) {
        const int point = find(name);
        if (point >= 0 && std::find(body.points.begin(), body.points.end(), point) == body.points.end()) {
          body.points.push_back(point);
        }
      };
      if (!b.origin.empty()) add(b.origin);
      for (const std::string& p : b.base) add(p);
      for (const Member& m : b.points) add(m.name);
      if (body.points.size() > 1) out_.bodies.push_back(std::move(body));
    }
  }

  const Scene& scene_;
  Drawing out_;
  std::unordered_map<std::string, int> index_;
  std::map<std::pair<int, int>, Drawing::Link> links_;
};

}  // namespace

Drawing drawing_of(const Scene& scene) { return Draughtsman(scene).draw(); }

}  // namespace assur::pictures
