#include "start/redundant_sets.hpp"

#include <algorithm>
#include <cstddef>
#include <map>
#include <numeric>
#include <set>
#include <string_view>
#include <utility>
#include <variant>

namespace assur {
namespace {

constexpr std::string_view kBody = "body ", kGround = "ground";
constexpr std::size_t kMostNamed = 24;  // a choice: a message of a few lines

using Names = std::set<std::string>;

// The graph of bodies and joints.
class Loops {
 public:
  explicit Loops(const Scene& scene) {
    for (const Joint& j : scene.joints()) {
      const auto [a, b] = std::visit([](const auto& k) { return std::pair(k.a, k.b); }, j.kind);
      index_.emplace(j.name, edges_.size());
      edges_.push_back({j.name, a, b, std::holds_alternative<Fixed>(j.kind)});
      at_[a].push_back(edges_.size() - 1);
      at_[b].push_back(edges_.size() - 1);
    }
  }

  // The bodies that equations of joints connect, and the joints between other bodies.
  struct Core {
    Names bodies, joints, others;
  };
  [[nodiscard]] Core core(const std::vector<std::string>& names) const {
    Core out;
    for (const std::string& name : names) {
      const std::string stem = name.starts_with(kBody) ? name.substr(kBody.size()) : name.substr(0, name.rfind('.'));
      const bool is_made = name.starts_with(kBody) || name.find('.') != std::string::npos;
      if (is_made && index_.count(stem) != 0) {
        out.joints.insert(stem);
      } else if (is_made && stem != kGround && at_.count(stem) != 0) {
        out.bodies.insert(stem);
      } else {
        out.others.insert(name);
      }
    }
    return out;
  }

  // The bodies that the joints of a core touch, without the ground.
  [[nodiscard]] Names touched(const Core& core) const {
    Names out = core.bodies;
    for (const std::string& j : core.joints) {
      const Edge& e = edges_[index_.at(j)];
      out.insert(e.a), out.insert(e.b);
    }
    out.erase(std::string(kGround));
    return out;
  }

  // All joints at the bodies of a core, and the joints that lead from there to the ground.
  [[nodiscard]] std::vector<std::string> closed(const Core& core) const {
    std::set<std::size_t> edges;
    for (const std::string& b : core.bodies) edges.insert(at_.at(b).begin(), at_.at(b).end());
    for (const std::string& j : core.joints) edges.insert(index_.at(j));
    Names open;
    for (const std::size_t e : edges) open.insert(edges_[e].a), open.insert(edges_[e].b);
    for (const std::string& b : open) {
      if (core.bodies.count(b) == 0) add_way_to_ground(b, core.bodies, edges);
    }
    std::vector<std::string> out;
    for (const std::size_t e : edges) {
      if (!edges_[e].is_fixed) out.push_back(edges_[e].name);
    }
    return out;
  }

 private:
  struct Edge {
    std::string name, a, b;
    bool is_fixed;
  };

  // The shortest way that avoids these bodies and does not go back along the joints that are known; nothing if there is
  // none.
  void add_way_to_ground(const std::string& from, const Names& avoided, std::set<std::size_t>& edges) const {
    std::map<std::string, std::size_t> by;  // the joint that led to a body
    std::vector<std::string> reached = {from};
    for (std::size_t i = 0; i < reached.size() && reached[i] != kGround; ++i) {
      for (const std::size_t e : at_.at(reached[i])) {
        const std::string& next = edges_[e].a == reached[i] ? edges_[e].b : edges_[e].a;
        if (edges.count(e) != 0 || next == from || avoided.count(next) != 0 || !by.emplace(next, e).second) continue;
        reached.push_back(next);
      }
    }
    if (by.count(std::string(kGround)) == 0) return;
    for (std::string at(kGround); at != from;) {
      const Edge& e = edges_[by.at(at)];
      edges.insert(by.at(at));
      at = e.a == at ? e.b : e.a;
    }
  }

  std::vector<Edge> edges_;
  std::map<std::string, std::size_t> index_;
  std::map<std::string, std::vector<std::size_t>> at_;  // joints of each body
};

Named named(const Loops& loops, const Loops::Core& core) {
  return {loops.closed(core), {core.others.begin(), core.others.end()}};
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kMostNamed); ++i) text += (i == 0 ? "" : ", ") + names[i];
  return names.size() > kMostNamed ? text + ", ... (" + std::to_string(names.size()) + " in all)" : text;
}

}  // namespace

std::string Named::text() const {
  std::string out = joints.empty() ? "" : (joints.size() == 1 ? "joint " : "joints ") + joined(joints);
  if (!joints.empty() && !others.empty()) out += "; ";
  return out + joined(others);
}

Named in_words_of(const Scene& scene, const std::vector<std::string>& names) {
  const Loops loops(scene);
  return named(loops, loops.core(names));
}

std::vector<RedundantSet> redundant_sets(const Scene& scene, const std::vector<Redundancy>& redundant) {
  if (redundant.empty()) return {};
  const Loops loops(scene);
  std::vector<std::size_t> parent(redundant.size());
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  const auto root = [&](std::size_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  std::map<std::pair<Redundancy::Kind, std::string>, std::size_t> first;  // the first dependence with this equation
  for (std::size_t i = 0; i < redundant.size(); ++i) {
    const Loops::Core core = loops.core(redundant[i].constraints);
    Names shared = core.others;
    for (const std::string& b : loops.touched(core)) shared.insert(std::string(kBody) + b);
    for (const std::string& s : shared) {
      const auto [at, is_new] = first.try_emplace({redundant[i].kind, s}, i);
      if (!is_new) parent[std::max(root(i), root(at->second))] = std::min(root(i), root(at->second));
    }
  }
  std::map<std::size_t, std::vector<std::size_t>> members;
  for (std::size_t i = 0; i < redundant.size(); ++i) members[root(i)].push_back(i);
  std::vector<RedundantSet> out;
  for (const auto& [r, rows] : members) {
    RedundantSet set;
    set.kind = redundant[r].kind;
    set.worst = redundant[r];
    std::vector<std::string> names;
    for (const std::size_t i : rows) {
      const Redundancy& one = redundant[i];
      names.insert(names.end(), one.constraints.begin(), one.constraints.end());
      set.checked.push_back(one.dropped);
      if (one.violation > set.worst.violation) set.worst = one;
    }
    set.named = named(loops, loops.core(names));
    out.push_back(std::move(set));
  }
  return out;
}

}  // namespace assur
