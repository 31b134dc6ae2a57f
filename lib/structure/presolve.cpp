#include "structure/presolve.hpp"

#include <algorithm>
#include <cmath>

#include "assur/number.hpp"
#include "index.hpp"

namespace assur {
namespace {

// part of the largest coefficient; then x = sum c_j / c_p q_j amplifies rounding at most by the inverse
constexpr double kPivotShare = 0.5;
constexpr std::size_t kLongestForm = 12;  // longer forms would cost more than the unknown that they save

struct Affine {
  struct AffineTerm {
    Index coordinate;
    Number factor;
    Index constant;  // constant of the factor: kPlus or kMinus for a literal, -1 for a new constant
  };
  std::vector<AffineTerm> parts;
};

class Presolve {
 public:
  explicit Presolve(System& s) : s_(s), eliminated_(s.coordinates.size(), -1), used_(s.coordinates.size(), 0) {}

  Index run(std::vector<Index>& equations, std::vector<Index>& unknowns) {
    std::vector<Index> mentioned;
    for (const Index e : equations) {
      s_.mentioned(e, mentioned);
      for (const Index c : mentioned) ++used_[idx(c)];
    }
    std::vector<Index> left;
    for (const Index e : equations) {
      if (!eliminate(s_.equations[idx(e)])) left.push_back(e);
    }
    const auto count = static_cast<Index>(equations.size() - left.size());
    if (count == 0) return 0;
    equations = std::move(left);
    std::erase_if(unknowns, [&](Index u) { return eliminated_[idx(u)] >= 0; });
    rewrite_forms();
    return count;
  }

 private:
  static bool is_literal(const Affine::AffineTerm& p) { return p.constant >= 0 && p.constant < kLiterals; }

  void add(Affine& sum, const Affine::AffineTerm& p) const {
    const auto same = std::find_if(sum.parts.begin(), sum.parts.end(),
                                   [&](const Affine::AffineTerm& o) { return o.coordinate == p.coordinate; });
    if (same == sum.parts.end()) {
      sum.parts.push_back(p);
    } else if (is_literal(*same) && is_literal(p) && same->constant != p.constant) {
      sum.parts.erase(same);  // +1 and -1 cancel exactly
    } else {
      same->factor += p.factor;
      same->constant = -1;
    }
  }

  // The form after replacing every eliminated coordinate, also in the replacements.
  Affine resolve(Index form) const {
    Affine out;
    for (const Term& t : s_.form(form)) {
      resolve_term({t.coordinate, s_.constant(t.constant), t.constant}, out);
    }
    return out;
  }
  void resolve_term(const Affine::AffineTerm& p, Affine& out) const {
    const Index by = eliminated_[idx(p.coordinate)];
    if (by < 0) {
      add(out, p);
      return;
    }
    for (const Affine::AffineTerm& r : replacement_[idx(by)].parts) {
      const Index constant = p.constant == kPlus ? r.constant : -1;
      resolve_term({r.coordinate, p.factor * r.factor, constant}, out);
    }
  }

  bool eliminate(const Equation& e) {
    if (e.linear < 0 || e.callback >= 0 || e.products_begin != e.products_end) return false;
    const Affine row = resolve(e.linear);
    if (row.parts.size() > kLongestForm) return false;
    Number largest = 0;
    for (const auto& p : row.parts) {
      if (s_.coordinates[idx(p.coordinate)].role == Role::unknown) largest = std::max(largest, abs(p.factor));
    }
    const Affine::AffineTerm* pivot = nullptr;
    for (const auto& p : row.parts) {
      if (s_.coordinates[idx(p.coordinate)].role != Role::unknown || abs(p.factor) < kPivotShare * largest ||
          p.factor == 0) {
        continue;
      }
      if (pivot == nullptr || used_[idx(p.coordinate)] < used_[idx(pivot->coordinate)]) pivot = &p;
    }
    if (pivot == nullptr) return false;
    Affine replacement;
    for (const auto& p : row.parts) {
      if (&p == pivot) continue;
      // The quotient of two literals is a literal.
      Index constant = -1;
      if (is_literal(p) && is_literal(*pivot)) {
        constant = p.constant == pivot->constant ? kMinus : kPlus;
      }
      replacement.parts.push_back({p.coordinate, -p.factor / pivot->factor, constant});
      ++used_[idx(p.coordinate)];
    }
    eliminated_[idx(pivot->coordinate)] = static_cast<Index>(replacement_.size());
    replacement_.push_back(std::move(replacement));
    return true;
  }

  Index constant_of(const Affine::AffineTerm& p) {
    if (p.constant >= 0) return p.constant;
    return s_.add_constant(p.factor);
  }

  void rewrite_forms() {
    std::vector<Index> start = {0};
    std::vector<Term> terms;
    terms.reserve(s_.terms.size());
    for (Index f = 0; f < s_.forms(); ++f) {
      const auto old = s_.form(f);
      const bool touched =
          std::any_of(old.begin(), old.end(), [&](const Term& t) { return eliminated_[idx(t.coordinate)] >= 0; });
      if (!touched) {
        terms.insert(terms.end(), old.begin(), old.end());
      } else {
        for (const Affine::AffineTerm& p : resolve(f).parts) terms.push_back({p.coordinate, constant_of(p)});
      }
      start.push_back(static_cast<Index>(terms.size()));
    }
    s_.form_start = std::move(start);
    s_.terms = std::move(terms);
  }

  System& s_;
  std::vector<Index> eliminated_;  // index into replacement_; -1: not eliminated
  std::vector<Affine> replacement_;
  std::vector<Index> used_;  // equations that mention the coordinate
};

}  // namespace

Index presolve(System& system, std::vector<Index>& equations, std::vector<Index>& unknowns) {
  return Presolve(system).run(equations, unknowns);
}

}  // namespace assur
