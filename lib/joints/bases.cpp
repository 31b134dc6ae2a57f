#include "joints/expansion.hpp"

#include <algorithm>
#include <utility>

namespace assur::joints {
namespace {

constexpr double kWider = 1.1;  // a base is worth changing if it gets wider by this factor

}  // namespace

std::vector<std::size_t> Expansion::order() const {
  std::vector<std::size_t> all;
  for (std::size_t s = 0; s < solids_.size(); ++s) {
    if (!solids_[s].is_rigid() && !solids_[s].bodies.empty()) all.push_back(s);
  }
  const auto moving = [&](std::size_t s) {
    return std::count_if(solids_[s].features.begin(), solids_[s].features.end(),
                         [&](std::size_t f) { return !features_[f].fixed && features_[f].wanted; });
  };
  std::vector<std::pair<Index, std::ptrdiff_t>> key(solids_.size());
  for (const std::size_t s : all) key[s] = {solids_[s].level, -moving(s)};
  std::stable_sort(all.begin(), all.end(), [&](std::size_t a, std::size_t b) { return key[a] < key[b]; });
  return all;
}

void Expansion::choose_base(std::size_t s) {
  Solid& solid = solids_[s];
  std::vector<std::size_t> all = solid.features;
  // Among equally suitable features, directions of slides come first: if only the ends of a strut determine its
  // direction, the other features need not be solved together with it.
  const auto key = [&](std::size_t i) { return std::pair(rank(features_[i], solid), features_[i].slides ? 0 : 1); };
  std::stable_sort(all.begin(), all.end(), [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
  const auto first = std::find_if(all.begin(), all.end(), [&](std::size_t i) { return features_[i].is_point; });
  Body& body = p_.bodies[solid.bodies.front()];
  if (first == all.end()) {
    const std::string bad_name = why_no_name(body.name);  // no joint can name it
    report(Where("/bodies") / body.name,
           bad_name.empty() ? "no joint places this body; a body needs a base, joints, or \"rigid\" points" : bad_name);
    return;
  }
  base_.emplace(s, std::vector<std::size_t>{*first});
  std::vector<std::size_t>& base = base_.at(s);
  const Triple origin = features_[*first].at;
  const auto way = [&](std::size_t i) {
    const Feature& f = features_[i];
    return f.is_point ? minus(f.at, origin) : f.at;
  };
  const auto is_distinct = [&](std::size_t i) {
    return i != base[0] && (!features_[i].is_point || !is_same(features_[i].at, origin));
  };
  const auto second = std::find_if(all.begin(), all.end(), is_distinct);
  if (second != all.end()) base.push_back(*second);
  if (in_space() && base.size() == 2) {
    const Triple along = way(base[1]);
    const auto apart = [&](std::size_t i) { return is_distinct(i) ? sine(along, way(i)) : Number(0); };
    auto third = std::find_if(all.begin(), all.end(), [&](std::size_t i) { return apart(i) > kWellApart; });
    if (third == all.end()) {
      third =
          std::max_element(all.begin(), all.end(), [&](std::size_t i, std::size_t k) { return apart(i) < apart(k); });
      if (!(apart(*third) > kSomewhatApart)) third = all.end();
    }
    if (third != all.end()) base.push_back(*third);
  }
  widen(base, all, [&](std::size_t i, std::size_t k) {
    return features_[i].is_point && features_[k].is_point && key(i) == key(k);
  });
  settle(s, base);
}

Number Expansion::width(const std::vector<std::size_t>& base) const {
  const auto way = [&](std::size_t from, std::size_t to) {
    return features_[base[to]].is_point ? minus(features_[base[to]].at, features_[base[from]].at)
                                        : features_[base[to]].at;
  };
  if (base.size() < 3) return base.size() < 2 ? Number(0) : triple::norm(way(0, 1));
  const Number area = triple::norm(triple::cross(way(0, 1), way(0, 2)));
  if (!features_[base[1]].is_point || !features_[base[2]].is_point) return area;
  return area / std::max({triple::norm(way(0, 1)), triple::norm(way(0, 2)), triple::norm(way(1, 2))});
}

void Expansion::widen(std::vector<std::size_t>& base, const std::vector<std::size_t>& all,
                      const std::function<bool(std::size_t, std::size_t)>& are_equal) const {
  Number widest = width(base);
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t k = 0; k < base.size(); ++k) {
      for (const std::size_t i : all) {
        if (!are_equal(i, base[k]) || std::find(base.begin(), base.end(), i) != base.end()) continue;
        const std::size_t before = std::exchange(base[k], i);
        if (const Number other = width(base); other > kWider * widest) {
          widest = other;
          changed = true;
        } else {
          base[k] = before;
        }
      }
    }
  }
}

std::vector<std::size_t> Expansion::own_base(std::size_t s) const {
  std::vector<std::size_t> base;
  if (solids_[s].based < 0) return base;
  const Body& b = p_.bodies[idx(solids_[s].based)];
  const auto take = [&](const std::string& name) {
    if (const auto found = feature_of_.find(name); found != feature_of_.end()) base.push_back(found->second);
  };
  if (!b.origin.empty()) take(b.origin);
  std::for_each(b.frame.begin(), b.frame.end(), take);
  std::for_each(b.base.begin(), b.base.end(), take);
  return base;
}

void Expansion::settle(std::size_t s, const std::vector<std::size_t>& base) {
  const int self = static_cast<int>(s);
  based_on_[self] = base;
  stood_on_.insert(base.begin(), base.end());
  for (const std::size_t i : solids_[s].features) {
    Feature& f = features_[i];
    if (std::find(base.begin(), base.end(), i) != base.end() || f.solid == self) continue;
    if (self == ground_ && f.fixed) continue;
    if (f.fixed && rests(base, f, kSame)) {
      if (const auto by = put_there_by_.find({self, i}); by != put_there_by_.end()) {
        implied_.emplace_back(by->second, p_.dimension - (f.is_point ? 0 : 1));
      }
      continue;
    }
    if (f.solid == kNobody && !f.driven && rests(base, f, kExactly)) {
      f.fixed = true;
      continue;
    }
    const bool is_free = !f.fixed && !f.driven && f.solid == kNobody && f.level >= solids_[s].level_of(f);
    if (self != ground_ && is_free && may_determine(self, i)) {
      f.solid = self;
    } else {
      ties_.push_back({i, self});
    }
  }
}

bool Expansion::rests(const std::vector<std::size_t>& base, const Feature& f, double share) const {
  if (base.empty() || !features_[base[0]].fixed) return false;
  const Feature& origin = features_[base[0]];
  if (f.is_point && is_same(f.at, origin.at, share)) return true;
  if (base.size() < 2 || !features_[base[1]].fixed) return false;
  const Feature& second = features_[base[1]];
  return is_on_line(f, origin.at, second.is_point ? unit(minus(second.at, origin.at)) : second.at, share);
}

bool Expansion::may_determine(int solid, std::size_t feature) const {
  if (stood_on_.count(feature) == 0) return true;
  std::vector<int> path = {solid};
  std::set<int> seen = {solid};
  while (!path.empty()) {
    const auto at = based_on_.find(path.back());
    path.pop_back();
    if (at == based_on_.end()) continue;
    for (const std::size_t i : at->second) {
      if (i == feature) return false;
      const int owner = features_[i].solid;
      if (owner != kNobody && seen.insert(owner).second) path.push_back(owner);
    }
  }
  return true;
}

}  // namespace assur::joints
