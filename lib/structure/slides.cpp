#include "structure/slides.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <unordered_map>
#include <utility>

#include "assur/number.hpp"
#include "index.hpp"
#include "numbers.hpp"

namespace assur {
namespace {

struct Slide {
  Index norm;                                 // equation |u|^2 = 1
  std::vector<Index> rows;                    // equations r - l u = 0
  std::vector<Index> u;                       // coordinates
  std::vector<std::vector<Term>> components;  // of r
  std::vector<Term> length;                   // l, which begins with lambda
};

class Slides {
 public:
  Slides(System& s, const std::vector<Index>& equations) : s_(s), size_(idx(s.dimension)) {
    for (const Index e : equations) note_norm(e);
    if (norm_of_.empty()) return;
    for (std::size_t i = 0; i + size_ <= equations.size(); ++i) note_slide(std::span(equations).subspan(i, size_));
  }

  [[nodiscard]] std::vector<Slide> take() { return std::move(slides_); }

  [[nodiscard]] bool has_unknown_lambda(const Slide& slide) const {
    return s_.coordinates[idx(slide.length[0].coordinate)].role == Role::unknown;
  }

  // u x r = 0 and u . r - l = 0, in the plane.
  void turn(const Slide& slide) {
    const Index x = form(slide.components[0]), y = form(slide.components[1]);
    const Index ux = form({{slide.u[0], kPlus}}), uy = form({{slide.u[1], kPlus}});
    std::vector<Term> length = slide.length;
    for (Term& t : length) t.constant = negative(t.constant);
    set(slide.rows[0], {{ux, y, kPlus}, {uy, x, kMinus}}, -1);
    set(slide.rows[1], {{ux, x, kPlus}, {uy, y, kPlus}}, form(length));
  }

  // |r|^2 - l^2 = 0 instead of the norm. Returns the norm.
  Equation replace_norm(const Slide& slide) {
    const Equation norm = s_.equations[idx(slide.norm)];
    std::vector<Product> products;
    const auto add_square = [&](const std::vector<Term>& terms, Index factor) {
      const Index f = form(terms);
      products.push_back({f, f, factor});
    };
    for (const std::vector<Term>& r : slide.components) add_square(r, kPlus);
    add_square(slide.length, kMinus);
    set(slide.norm, products, -1);
    s_.equations[idx(slide.norm)].source = s_.equations[idx(slide.rows[0])].source;
    return norm;
  }

 private:
  Index form(const std::vector<Term>& terms) {
    s_.terms.insert(s_.terms.end(), terms.begin(), terms.end());
    s_.form_start.push_back(static_cast<Index>(s_.terms.size()));
    return s_.forms() - 1;
  }
  Index negative(Index constant) {
    if (constant < kLiterals) return constant == kPlus ? kMinus : kPlus;
    s_.constants.push_back((-value(constant)).value());
    return static_cast<Index>(s_.constants.size()) - 1;
  }
  void set(Index equation, const std::vector<Product>& products, Index linear) {
    Equation& e = s_.equations[idx(equation)];
    e.products_begin = static_cast<Index>(s_.products.size());
    s_.products.insert(s_.products.end(), products.begin(), products.end());
    e.products_end = static_cast<Index>(s_.products.size());
    e.linear = linear;
  }
  // The unknown that is the whole form; -1: the form is another one.
  [[nodiscard]] Index only(Index form) const {
    const auto terms = s_.form(form);
    if (terms.size() != 1 || terms[0].constant != kPlus) return -1;
    return s_.coordinates[idx(terms[0].coordinate)].role == Role::unknown ? terms[0].coordinate : -1;
  }
  [[nodiscard]] Number value(Index constant) const { return s_.constant(constant); }

  void note_norm(Index equation) {
    const Equation& e = s_.equations[idx(equation)];
    const auto products = s_.products_of(e);
    if (products.size() != size_ || e.linear < 0) return;
    const auto linear = s_.form(e.linear);
    if (linear.size() != 1 || linear[0].coordinate != kOne || linear[0].constant != kMinus) return;
    std::vector<Index> u;
    for (const Product& p : products) {
      if (p.a != p.b || p.constant != kPlus || only(p.a) < 0) return;
      u.push_back(only(p.a));
    }
    const Index first = u[0];
    norm_of_.emplace(first, std::pair(equation, std::move(u)));
  }

  // Row k is r_k - constant u_k - lambda u_k, and r has no component of u.
  void note_slide(std::span<const Index> rows) {
    Slide slide{};
    Index source = -1;
    Number constant = 0;
    for (std::size_t k = 0; k < size_; ++k) {
      const Equation& e = s_.equations[idx(rows[k])];
      const auto products = s_.products_of(e);
      if (e.linear < 0 || products.size() != 1 || products[0].constant != kMinus) return;
      if (k == 0) {
        const auto norm = norm_of_.find(only(products[0].b));
        if (norm == norm_of_.end()) return;
        const auto lambda = s_.form(products[0].a);
        if (lambda.size() != 1 || lambda[0].constant != kPlus) return;
        source = e.source;
        slide = {norm->second.first, {rows.begin(), rows.end()}, norm->second.second, {}, {lambda[0]}};
      }
      if (e.source != source || only(products[0].b) != slide.u[k]) return;
      Number own = 0;
      std::vector<Term>& r = slide.components.emplace_back();
      for (const Term& t : s_.form(e.linear)) {
        if (t.coordinate != kOne && value(t.constant) == 0) continue;
        if (t.coordinate == slide.u[k]) {
          own -= value(t.constant);
        } else if (std::find(slide.u.begin(), slide.u.end(), t.coordinate) != slide.u.end()) {
          return;
        } else {
          r.push_back(t);
        }
      }
      if (k == 0) constant = own;
      if (!(abs(own - constant) <= 4 * kEps * abs(constant))) return;
    }
    if (constant != 0) {
      slide.length.push_back({kOne, s_.add_constant(constant)});
    }
    norm_of_.erase(slide.u[0]);
    slides_.push_back(std::move(slide));
  }

  System& s_;
  std::size_t size_;
  std::unordered_map<Index, std::pair<Index, std::vector<Index>>> norm_of_;  // by the first coordinate
  std::vector<Slide> slides_;
};

}  // namespace

void decouple_slides(System& system, const std::vector<Index>& equations, const std::vector<Index>& unknowns,
                     Blocks& blocks) {
  Slides all(system, equations);
  std::vector<Slide> slides = all.take();
  if (slides.empty()) return;
  std::vector<std::pair<Slide, Equation>> replaced;
  for (Slide& slide : slides) {
    if (system.dimension == 2 && all.has_unknown_lambda(slide)) {
      all.turn(slide);
    } else {
      const Equation norm = all.replace_norm(slide);
      replaced.emplace_back(std::move(slide), norm);
    }
  }
  const auto follows = [](const Slide& slide, const std::vector<Index>& block_of) {
    const auto is_apart = [&](const std::vector<Term>& terms) {
      return std::all_of(terms.begin(), terms.end(), [&](const Term& t) {
        return std::all_of(slide.u.begin(), slide.u.end(), [&](Index u) {
          return block_of[idx(u)] >= 0 && block_of[idx(u)] != block_of[idx(t.coordinate)];
        });
      });
    };
    return is_apart(slide.length) && std::all_of(slide.components.begin(), slide.components.end(), is_apart);
  };
  // Putting back a norm may couple further directions.
  for (bool changed = true; changed;) {
    blocks = decompose(system, equations, unknowns);
    std::vector<Index> block_of(system.coordinates.size(), -1);
    for (Index b = 0; b < blocks.size(); ++b) {
      for (const Index u : blocks.unknowns_of(b)) block_of[idx(u)] = b;
    }
    changed = std::erase_if(replaced, [&](const auto& pair) {
                const auto& [slide, norm] = pair;
                if (follows(slide, block_of)) return false;
                system.equations[idx(slide.norm)] = norm;
                return true;
              }) > 0;
  }
}

}  // namespace assur
