#include "joints/expansion.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "joints/joint_kinds.hpp"
#include "joints/levels_of_unknowns.hpp"

namespace assur::joints {

Index Expansion::turns_of(const Solid& s) const {
  if (s.is_rigid()) return 3;
  const auto point =
      std::find_if(s.features.begin(), s.features.end(), [&](std::size_t i) { return features_[i].is_point; });
  if (point == s.features.end()) return 3;
  const Triple at = features_[*point].at;
  std::optional<Triple> along;
  for (const std::size_t i : s.features) {
    const Feature& f = features_[i];
    if (f.is_point && is_same(f.at, at)) continue;
    const Triple way = f.is_point ? unit(minus(f.at, at)) : f.at;
    if (!along) along = way;
    if (!is_on_line(f, at, *along)) return 3;
  }
  return along ? 2 : 0;
}

void Expansion::set_levels() {
  const Index along = p_.dimension, turns = in_space() ? 3 : 1;
  std::vector<std::vector<Index>> equations;
  std::vector<Index> first(solids_.size()), end(solids_.size()), of_feature(features_.size(), kNobody);
  Index unknowns = 0;
  for (std::size_t s = 0; s < solids_.size(); ++s) {
    first[s] = unknowns;
    if (!solids_[s].is_ground) unknowns += along + (in_space() ? turns_of(solids_[s]) : turns);
    end[s] = unknowns;
    for (const std::size_t f : solids_[s].features) {
      if (of_feature[f] == kNobody || solids_[s].is_ground) of_feature[f] = static_cast<Index>(s);
    }
  }
  std::map<std::size_t, Index> loose;  // features: first unknown
  const auto read_solid = [&](std::vector<Index>& reads, int s, bool turns_only) {
    if (solids_[idx(s)].is_ground) return;
    for (Index u = first[idx(s)] + (turns_only ? along : 0); u < end[idx(s)]; ++u) reads.push_back(u);
  };
  const auto require = [&](Index count, const std::vector<Index>& reads) {
    if (!reads.empty()) equations.insert(equations.end(), idx(count), reads);
  };
  const auto connect = [&](const Joint& j, Index count, bool turns_only) {
    const auto [a, b] = bodies_of(j);
    std::vector<Index> reads;
    read_solid(reads, solid(a), turns_only), read_solid(reads, solid(b), turns_only);
    require(count, reads);
  };
  for (const Joint& j : p_.joints) {
    const bool slides = std::holds_alternative<Prismatic>(j.kind), fixes = std::holds_alternative<Fixed>(j.kind);
    auto [ways, angles] = in_space() ? std::pair<Index, Index>{kind_of(j).translations, kind_of(j).turns}
                          : slides   ? std::pair<Index, Index>{1, 1}
                          : fixes    ? std::pair<Index, Index>{0, 0}
                                     : std::pair<Index, Index>{2, 0};
    if (is_held(j)) continue;
    const auto [a, b] = bodies_of(j);
    const auto is_rod = [&](const std::string& body) { return turns_of(solids_[idx(solid(body))]) < turns; };
    if (in_space() && slides && (is_rod(a) || is_rod(b))) angles = 2;  // see share_sides()
    connect(j, angles, true), connect(j, ways, false);
  }
  // `name`: of a point or vector, also with a coordinate, or the displacement of a joint.
  const auto read = [&](std::vector<Index>& reads, const std::string& name) {
    if (const auto j = joint_of_.find(name.substr(0, name.find('.')));
        j != joint_of_.end() && name.find(".slide.") != std::string::npos) {
      const auto [a, b] = bodies_of(*j->second);
      return read_solid(reads, solid(a), false), read_solid(reads, solid(b), false);
    }
    const auto found = feature_of_.find(name.substr(0, name.find('.')));
    if (found == feature_of_.end() || features_[found->second].fixed) return;
    const Feature& f = features_[found->second];
    if (const Index s = of_feature[found->second]; s != kNobody) return read_solid(reads, s, !f.is_point);
    const auto [at, is_new] = loose.emplace(found->second, unknowns);
    if (is_new) unknowns += along;
    for (Index k = 0; k < along; ++k) reads.push_back(at->second + k);
    if (is_new && !f.is_point) require(1, reads);
  };
  const auto require_of = [&](Index count, std::initializer_list<const std::string*> names) {
    std::vector<Index> reads;
    for (const std::string* name : names) read(reads, *name);
    require(count, reads);
  };
  for (const Constraint& c : p_.constraints) {
    c.visit(Overloaded{[&](const Distance& k) {
                         require_of(1, {&k.p, &k.q});
                       },
                       [&](const EqualDistance& k) {
                         require_of(1, {&k.p, &k.q, &k.r, &k.s});
                       },
                       [&](const Dot& k) {
                         require_of(1, {&k.d.first, &k.d.second, &k.e.first, &k.e.second});
                       },
                       [&](const Parallel& k) {
                         require_of(along - 1, {&k.d.first, &k.d.second, &k.e.first, &k.e.second});
                       },
                       [&](const Linear& k) {
                         std::vector<Index> reads;
                         for (const auto& term : k.terms) read(reads, term.first);
                         require(along, reads);
                       },
                       [&](const FixedCoordinate& k) { require_of(1, {&k.coordinate}); },
                       [&](const OnLine& k) {
                         require_of(along - 1, {&k.p, &k.a, &k.d.first, &k.d.second});
                       },
                       [&](const OnPlane& k) {
                         require_of(along - 2, {&k.p, &k.a, &k.d.first, &k.d.second, &k.e.first, &k.e.second});
                       },
                       [&](const Gear&) {},  // below
                       [&](const Callback& k) {
                         std::vector<Index> reads;
                         for (const std::string& name : k.coordinates) read(reads, name);
                         require(k.equations, reads);
                       }});
  }
  for (const Geared& g : geared_) {
    std::vector<Index> reads;
    for (const Coordinate& side : g.sides) {
      const auto [a, b] = bodies_of(*side.joint);
      read_solid(reads, solid(a), side.is_angle), read_solid(reads, solid(b), side.is_angle);
    }
    require(1, reads);
  }
  std::set<const Driver*> of_joints;
  for (const auto& [driver, of] : driven_) {
    of_joints.insert(driver);
    connect(*of.joint, 1, of.is_angle);
  }
  for (const Driver& d : p_.drivers) {
    std::visit(Overloaded{[&](const PointAngle& k) {
                            require_of(1, {&k.a, &k.b});
                          },
                          [&](const RelativeAngle& k) {
                            require_of(1, {&k.d.first, &k.d.second, &k.e.first, &k.e.second});
                          },
                          [&](const DrivenDistance& k) {
                            require_of(1, {&k.a, &k.b});
                          },
                          [&](const DrivenCoordinate& k) {
                            if (of_joints.count(&d) == 0) require_of(1, {&k.coordinate});
                          },
                          [&](const Pose& k) {
                            std::vector<Index> reads;
                            if (body_of_.count(k.body) != 0) read_solid(reads, solid(k.body), false);
                            require(along + turns, reads);
                          }},
               d.kind);
  }
  const std::vector<Index> level = levels_of_unknowns(unknowns, std::move(equations));
  for (std::size_t s = 0; s < solids_.size(); ++s) {
    if (solids_[s].is_ground) continue;
    const auto own = level.begin() + first[s], last = level.begin() + end[s];
    solids_[s].level = *std::max_element(own, last);
    solids_[s].turn_level = last == own + along ? 0 : *std::max_element(own + along, last);
  }
  for (const Solid& s : solids_) {
    for (const std::size_t f : s.features) features_[f].level = std::min(features_[f].level, s.level_of(features_[f]));
  }
}

}  // namespace assur::joints
