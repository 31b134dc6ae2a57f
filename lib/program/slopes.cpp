#include "program/slopes.hpp"

#include "index.hpp"

namespace assur {
namespace {

// The share of an input in a register, as a coefficient.
std::int32_t share(const GroupClass& group_class, std::int32_t reg, std::int32_t input) {
  if (reg == group_class.n + input) return one_coefficient(group_class);
  if (reg <= group_class.one()) return Slopes::kNone;
  const GroupClass::Form& f = group_class.forms[idx(reg - group_class.one() - 1)];
  for (std::int32_t o = f.moving; o < f.unknowns; ++o) {
    if (group_class.operands[idx(o)].reg == group_class.n + input) return group_class.operands[idx(o)].coefficient;
  }
  return Slopes::kNone;
}

}  // namespace

Slopes slopes_of(const GroupClass& group_class, const Separable& separable, std::span<const std::uint8_t> computed) {
  Slopes out;
  const std::int32_t n = group_class.n, one = one_coefficient(group_class), none = Slopes::kNone;
  for (std::int32_t i = 0; i < n; ++i) {
    const std::size_t entries_before = out.entries.size();
    for (std::int32_t input = 0; input < group_class.inputs; ++input) {
      if (computed[idx(input)] == 0) continue;
      const std::size_t before = out.terms.size();
      const auto add = [&](std::int32_t reg, Slopes::Term term) {
        term.share = share(group_class, reg, input);
        if (term.share >= 0) out.terms.push_back(term);
      };
      for (std::int32_t j = 0; j < n; ++j) {
        const Separable::Square& q = separable.squares[idx(i * n + j)];
        if (q.s != Separable::kNone && q.b != Separable::kNone) add(q.b, {q.s, one, none, j, none});
      }
      for (const Separable::Known& t : separable.known) {
        if (t.equation == i) add(t.reg, {t.coefficient, one, none, none, none});
      }
      for (const Separable::Linear& t : separable.linear) {
        const std::int32_t slope = t.slope == Separable::kNone ? one : t.slope;
        if (t.equation == i) add(t.reg, {t.coefficient, slope, none, none, t.unknown});
      }
      if (out.terms.size() > before) out.entries.push_back({out.rows(), input, before, out.terms.size()});
    }
    if (out.entries.size() > entries_before) out.equations.push_back(i);
  }
  return out;
}

}  // namespace assur
