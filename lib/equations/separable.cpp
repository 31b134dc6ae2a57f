#include "equations/separable.hpp"

#include <algorithm>
#include <cmath>

#include "index.hpp"
#include "numbers.hpp"

namespace assur {
namespace {

class Separation {
 public:
  explicit Separation(const GroupClass& c) : class_(c) { out_.squares.resize(idx(c.n) * idx(c.n)); }

  std::optional<Separable> run() {
    if (!class_.quadratic()) return std::nullopt;
    for (std::int32_t i = 0; i < class_.n; ++i) {
      const GroupClass::Equation& e = class_.equations[idx(i)];
      for (std::int32_t o = e.linear.begin; o < e.linear.end; ++o) linear(i, class_.linear[idx(o)]);
      for (std::int32_t q = e.products.begin; q < e.products.end; ++q) product(i, class_.products[idx(q)]);
    }
    if (!separable_) return std::nullopt;
    return std::move(out_);
  }

 private:
  // slope * unknown + known register
  struct Part {
    std::int32_t unknown = Separable::kNone, slope = Separable::kNone, known = Separable::kNone;
    bool moves = false;
  };

  Part part(std::int32_t reg) {
    Part out;
    if (reg < class_.n) {
      out.unknown = reg;
      return out;
    }
    out.known = reg;
    if (reg < class_.one()) out.moves = class_.input_moves[idx(reg - class_.n)] != 0;
    if (reg <= class_.one()) return out;
    const GroupClass::Form& f =
        class_.forms[idx(reg - class_.one() - 1)];  // forms have the last registers, in their order
    out.moves = f.moving != f.unknowns;
    if (f.end - f.unknowns > 1) separable_ = false;
    if (f.end == f.unknowns) return out;
    out.unknown = class_.operands[idx(f.unknowns)].reg;
    out.slope = class_.operands[idx(f.unknowns)].coefficient;
    return out;
  }

  void linear(std::int32_t i, const GroupClass::Operand& o) {
    const Part x = part(o.reg);
    if (x.unknown >= 0) out_.linear.push_back({i, x.unknown, o.coefficient, x.slope, class_.one()});
    if (x.known < 0) return;
    out_.known.push_back({i, o.coefficient, x.known});
    if (x.moves) out_.moving_known.push_back(out_.known.back());
  }

  void product(std::int32_t i, const GroupClass::Product& q) {
    const Part a = part(q.a), b = part(q.b);
    if (q.a == q.b && a.unknown >= 0) {
      Separable::Square& square = out_.squares[idx(i * class_.n + a.unknown)];
      separable_ = separable_ && square.s < 0;
      square = {q.coefficient, a.slope, a.known};
      return;
    }
    const Part &x = a.unknown >= 0 ? a : b, &factor = a.unknown >= 0 ? b : a;
    if (x.unknown < 0 || x.known >= 0 || factor.unknown >= 0) {
      separable_ = false;
      return;
    }
    out_.linear.push_back({i, x.unknown, q.coefficient, Separable::kNone, factor.known});
    if (factor.moves) out_.moving_linear.push_back(out_.linear.back());
  }

  const GroupClass& class_;
  Separable out_;
  bool separable_ = true;
};

}  // namespace

std::optional<Separable> separate(const GroupClass& group_class) { return Separation(group_class).run(); }

bool measures_distances(const Separable& separable, const GroupClass& group_class) {
  const auto literal = [&](std::int32_t coefficient, double none) {
    if (coefficient == Separable::kNone) return none;
    const GroupClass::Coefficient& c = group_class.coefficients[idx(coefficient)];
    return c == GroupClass::Coefficient{c.literal} ? c.literal : kNan;
  };
  const double sign = literal(separable.squares[0].a, 1);
  if (std::abs(sign) != 1) return false;
  for (const Separable::Square& q : separable.squares) {
    if (literal(q.s, 0) != 1 || literal(q.a, 1) != sign) return false;
  }
  std::vector<std::int32_t> constants(idx(group_class.n), 0);
  for (const Separable::Known& t : separable.known) {
    if (t.reg != group_class.one()) return false;
    ++constants[idx(t.equation)];
  }
  return separable.linear.empty() &&
         std::all_of(constants.begin(), constants.end(), [](std::int32_t count) { return count == 1; });
}

}  // namespace assur
