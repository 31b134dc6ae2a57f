#include "program/slopes.hpp"

#include "index.hpp"

namespace assur {
namespace {

// The share of an input in a register, as a coefficient.
std::int32_t share(const Program& program, std::int32_t reg, std::int32_t input) {
  if (reg == program.n + input) return one_coefficient(program);
  if (reg <= program.one()) return Slopes::kNone;
  const Program::Form& f = program.forms[idx(reg - program.one() - 1)];
  for (std::int32_t o = f.moving; o < f.unknowns; ++o) {
    if (program.operands[idx(o)].reg == program.n + input) return program.operands[idx(o)].coefficient;
  }
  return Slopes::kNone;
}

}  // namespace

Slopes slopes_of(const Program& program, const Separable& separable, std::span<const std::uint8_t> computed) {
  Slopes out;
  const std::int32_t n = program.n, one = one_coefficient(program), none = Slopes::kNone;
  for (std::int32_t i = 0; i < n; ++i) {
    const std::size_t entries_before = out.entries.size();
    for (std::int32_t input = 0; input < program.inputs; ++input) {
      if (computed[idx(input)] == 0) continue;
      const std::size_t before = out.terms.size();
      const auto add = [&](std::int32_t reg, Slopes::Term term) {
        term.share = share(program, reg, input);
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
