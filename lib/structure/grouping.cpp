#include "structure/grouping.hpp"

#include <algorithm>
#include <compare>
#include <numeric>
#include <tuple>

#include "graph/block_names.hpp"
#include "index.hpp"

namespace assur {
namespace {

class Grouping {
 public:
  Grouping(const System& system, const Blocks& blocks) : s_(system), blocks_(blocks) {}

  std::vector<Draft> run(Formulation formulation) {
    group_of_.assign(idx(blocks_.size()), -1);
    if (formulation == Formulation::global) {
      drafts_.push_back({"all", {}, 0, 0, false});
      std::fill(group_of_.begin(), group_of_.end(), 0);
    } else if (formulation == Formulation::groups) {
      declared_groups();
    }
    if (formulation != Formulation::global) drafts_.reserve(drafts_.size() + idx(blocks_.size()));
    for (Index b = 0; b < blocks_.size(); ++b) {
      if (group_of_[idx(b)] < 0) {
        group_of_[idx(b)] = static_cast<Index>(drafts_.size());
        drafts_.push_back({block_name(s_, blocks_, b), {}, 0, 0, false});
      }
      Draft& d = drafts_[idx(group_of_[idx(b)])];
      d.blocks.push_back(b);
      d.of += static_cast<Index>(blocks_.unknowns_of(b).size());
    }
    order_groups();
    return std::move(drafts_);
  }

 private:
  void declared_groups() {
    std::vector<Index> declared(s_.coordinates.size(), -1);
    for (std::size_t g = 0; g < s_.groups.size(); ++g) {
      drafts_.push_back({s_.groups[g].name, {}, 0, 0, s_.groups[g].keep});
      for (const Index u : s_.groups[g].unknowns) declared[idx(u)] = static_cast<Index>(g);
    }
    for (Index b = 0; b < blocks_.size(); ++b) {
      const auto unknowns = blocks_.unknowns_of(b);
      const Index g = declared[idx(unknowns.front())];
      for (const Index u : unknowns) {
        if (declared[idx(u)] == g) continue;
        const Index other = std::max(g, declared[idx(u)]);
        throw Error(Error::Kind::input,
                    {{"/groups/" + s_.groups[idx(other)].name,
                      "must be a union of irreducible groups, but cuts through " + block_name(s_, blocks_, b) +
                          "; add all of it (" + all_names(s_, blocks_, b) + ") to the group, or nothing"}});
      }
      group_of_[idx(b)] = g;
    }
  }

  struct Need {
    Index of, by;  // groups
    friend auto operator<=>(const Need&, const Need&) = default;
  };

  // Levels by longest path among groups. In a cycle, an outside block lies between two blocks of a group.
  void order_groups() {
    const std::size_t n = drafts_.size();
    std::vector<Need> needs;
    for (Index b = 0; b < blocks_.size(); ++b) {
      for (const Index o : blocks_.needs_of(b)) {
        if (group_of_[idx(o)] != group_of_[idx(b)]) needs.push_back({group_of_[idx(o)], group_of_[idx(b)]});
      }
    }
    std::sort(needs.begin(), needs.end());
    needs.erase(std::unique(needs.begin(), needs.end()), needs.end());
    std::vector<Index> waiting(n, 0), ready;
    for (const Need& need : needs) ++waiting[idx(need.by)];
    for (std::size_t g = 0; g < n; ++g) {
      if (waiting[g] == 0) ready.push_back(static_cast<Index>(g));
    }
    std::size_t ordered = 0;
    for (; !ready.empty(); ++ordered) {
      const Index g = ready.back();
      ready.pop_back();
      for (auto f = std::lower_bound(needs.begin(), needs.end(), Need{g, 0}); f != needs.end() && f->of == g; ++f) {
        drafts_[idx(f->by)].level = std::max(drafts_[idx(f->by)].level, drafts_[idx(g)].level + 1);
        if (--waiting[idx(f->by)] == 0) ready.push_back(f->by);
      }
    }
    if (ordered != n) refuse_cycle(waiting, needs);
    // Sorts the groups in solving order.
    std::vector<Index> sorted(n);
    std::iota(sorted.begin(), sorted.end(), 0);
    std::sort(sorted.begin(), sorted.end(), [&](Index x, Index y) {
      const auto key = [&](Index g) {
        const Draft& d = drafts_[idx(g)];
        return std::tuple(d.level, d.blocks.empty() ? Index{0} : d.blocks.front(), g);
      };
      return key(x) < key(y);
    });
    std::vector<Draft> drafts;
    drafts.reserve(n);
    for (const Index g : sorted) drafts.push_back(std::move(drafts_[idx(g)]));
    drafts_ = std::move(drafts);
  }

  [[noreturn]] void refuse_cycle(const std::vector<Index>& waiting, const std::vector<Need>& needs) const {
    for (std::size_t g = 0; g < s_.groups.size(); ++g) {
      for (const Need& need : needs) {
        if (idx(need.by) != g || waiting[g] == 0 || waiting[idx(need.of)] == 0) continue;
        throw Error(Error::Kind::input, {{"/groups/" + s_.groups[g].name,
                                          "needs " + drafts_[idx(need.of)].name +
                                              ", which in turn needs this group: it lies between blocks of the "
                                              "group and must belong to it"}});
      }
    }
    throw Error(Error::Kind::input, {{"/groups", "the declared groups need each other in a cycle; merge them"}});
  }

  const System& s_;
  const Blocks& blocks_;
  std::vector<Index> group_of_;  // blocks -> drafts_
  std::vector<Draft> drafts_;
};

}  // namespace

std::vector<Draft> form_groups(const System& system, const Blocks& blocks, Formulation formulation) {
  return Grouping(system, blocks).run(formulation);
}

}  // namespace assur
