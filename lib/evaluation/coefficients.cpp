#include "evaluation/coefficients.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "backends/with_lanes.hpp"
#include "index.hpp"
#include "numbers.hpp"

namespace assur {

bool terms_may_vanish(const GroupClass& c) {
  const auto is_constant = [&](const GroupClass::Operand& o) { return o.reg == c.one(); };
  const auto is_square = [](const GroupClass::Product& p) { return p.a == p.b; };
  const auto is_periodic = [](const GroupClass::Gear& g) { return g.is_periodic; };
  return !std::all_of(c.linear.begin(), c.linear.end(), is_constant) ||
         !std::all_of(c.products.begin(), c.products.end(), is_square) ||
         !std::all_of(c.gears.begin(), c.gears.end(), is_periodic);
}

void bind_coefficients(const GroupClass& c, const double* constants, double* out, std::size_t lanes) {
  with_lanes(lanes, [&](auto w) {
    for (const GroupClass::Coefficient& k : c.coefficients) {
      double product[kMostLanes];
      for (std::size_t l = 0; l < w; ++l) product[l] = k.literal;
      for (const std::int32_t of : k.constant) {
        for (std::size_t l = 0; of >= 0 && l < w; ++l) product[l] *= constants[idx(of) * w + l];
      }
      for (std::size_t l = 0; l < w; ++l) *out++ = product[l];
    }
  });
}

void lipschitz(const GroupClass& c, const double* coefficients, double* out, std::size_t lanes) {
  using Row = std::array<double, kMostLanes>;
  Row ones;
  ones.fill(1);
  // Sums of |coefficient| of a register: over the block's unknowns, and over all that moves.
  struct Sums {
    Row in_block, moving;
  };
  const auto add = [&](auto w, std::int32_t coordinate, const double* size, std::int32_t block, Sums& to) {
    const bool is_unknown = coordinate < c.n;
    if (coordinate >= c.one() || (!is_unknown && c.input_moves[idx(coordinate - c.n)] == 0)) return;
    const bool is_in_block = is_unknown && c.unknown_block[idx(coordinate)] == block;
    for (std::size_t l = 0; l < w; ++l) to.moving[l] += std::abs(size[l]);
    for (std::size_t l = 0; is_in_block && l < w; ++l) to.in_block[l] += std::abs(size[l]);
  };
  const auto add_up = [&](auto w, std::int32_t reg, std::int32_t block, Sums& to) {
    for (std::size_t l = 0; l < w; ++l) to.in_block[l] = to.moving[l] = 0;
    if (reg <= c.one()) return add(w, reg, ones.data(), block, to);
    const GroupClass::Form& f = c.forms[idx(reg - c.one() - 1)];  // the last registers, in order
    for (std::int32_t o = f.begin; o < f.end; ++o) {
      const GroupClass::Operand& operand = c.operands[idx(o)];
      add(w, operand.reg, coefficients + idx(operand.coefficient) * w, block, to);
    }
  };
  with_lanes(lanes, [&](auto w) {
    Sums a, b;
    for (std::size_t i = 0; i < c.equations.size(); ++i) {
      const GroupClass::Equation& e = c.equations[i];
      double* const sum = out + i * w;
      std::fill_n(sum, std::size_t{w}, e.gear >= 0 ? kInfinity : 0);
      for (std::int32_t k = e.products.begin; k < e.products.end; ++k) {
        const GroupClass::Product& p = c.products[idx(k)];
        add_up(w, p.a, c.equation_block[i], a);
        if (p.b != p.a) add_up(w, p.b, c.equation_block[i], b);
        const Sums& other = p.b == p.a ? a : b;
        const double* const factor = coefficients + idx(p.coefficient) * w;
        for (std::size_t l = 0; l < w; ++l) {
          sum[l] += std::abs(factor[l]) * (a.in_block[l] * other.moving[l] + a.moving[l] * other.in_block[l]);
        }
      }
    }
    for (const GroupClass::CallbackUse& use : c.callbacks) {
      for (const GroupClass::CallbackUse::EquationOfRow& r : use.rows)
        std::fill_n(out + idx(r.equation) * w, std::size_t{w}, kInfinity);
    }
  });
}

}  // namespace assur
