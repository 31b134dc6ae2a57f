#include "equations/program.hpp"

#include <cmath>

#include "index.hpp"
#include "numbers.hpp"

namespace assur {
namespace {

double value(const GroupClass::Coefficient& k, std::span<const double> constants) {
  double v = k.literal;
  for (const std::int32_t c : k.constant) {
    if (c >= 0) v *= constants[idx(c)];
  }
  return v;
}

// Sums of the sizes of the coefficients of a register: over the unknowns of a block, and over all that moves.
struct Sizes {
  double in_block = 0, moving = 0;
};
Sizes sizes_of(const GroupClass& c, std::int32_t reg, std::int32_t block, std::span<const double> constants) {
  Sizes sum;
  const auto add = [&](std::int32_t coordinate, double size) {
    if (coordinate < c.n) {
      sum.moving += size;
      if (c.unknown_block[idx(coordinate)] == block) sum.in_block += size;
    } else if (coordinate < c.one() && c.input_moves[idx(coordinate - c.n)] != 0) {
      sum.moving += size;
    }
  };
  if (reg <= c.one()) {
    add(reg, 1);
    return sum;
  }
  const GroupClass::Form& f = c.forms[idx(reg - c.one() - 1)];  // the last registers, in order
  for (std::int32_t o = f.begin; o < f.end; ++o) {
    const GroupClass::Operand& operand = c.operands[idx(o)];
    add(operand.reg, std::abs(value(c.coefficients[idx(operand.coefficient)], constants)));
  }
  return sum;
}

}  // namespace

void bind_coefficients(const GroupClass& c, std::span<const double> constants, double* out, std::size_t stride) {
  for (const GroupClass::Coefficient& k : c.coefficients) {
    *out = value(k, constants);
    out += stride;
  }
}

void lipschitz(const GroupClass& c, std::span<const double> constants, double* out, std::size_t stride) {
  for (std::size_t i = 0; i < c.equations.size(); ++i) {
    const GroupClass::Equation& e = c.equations[i];
    double sum = e.gear >= 0 ? kInfinity : 0;
    for (std::int32_t k = e.products.begin; k < e.products.end; ++k) {
      const GroupClass::Product& p = c.products[idx(k)];
      const Sizes a = sizes_of(c, p.a, c.equation_block[i], constants);
      const Sizes b = p.b == p.a ? a : sizes_of(c, p.b, c.equation_block[i], constants);
      sum += std::abs(value(c.coefficients[idx(p.coefficient)], constants)) *
             (a.in_block * b.moving + a.moving * b.in_block);
    }
    out[i * stride] = sum;
  }
  for (const GroupClass::CallbackUse& use : c.callbacks) {
    for (const GroupClass::CallbackUse::Row& r : use.rows) out[idx(r.equation) * stride] = kInfinity;
  }
}

}  // namespace assur
