#include "equations/separable.hpp"

#include <algorithm>
#include <cmath>

#include "index.hpp"
#include "numbers.hpp"

namespace assur {
namespace {

class Separation {
 public:
  Separation(const Program& p, std::span<const std::uint8_t> input_moves) : p_(p), input_moves_(input_moves) {
    out_.squares.resize(idx(p.n) * idx(p.n));
  }

  std::optional<Separable> run() {
    if (!p_.callbacks.empty() || !p_.gears.empty()) return std::nullopt;
    for (std::int32_t i = 0; i < p_.equations_count; ++i) {
      const Program::Equation& e = p_.equations[idx(i)];
      for (std::int32_t o = e.linear.begin; o < e.linear.end; ++o) linear(i, p_.linear[idx(o)]);
      for (std::int32_t q = e.products.begin; q < e.products.end; ++q) product(i, p_.products[idx(q)]);
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
    if (reg < p_.n) {
      out.unknown = reg;
      return out;
    }
    out.known = reg;
    if (reg < p_.one()) out.moves = input_moves_[idx(reg - p_.n)] != 0;
    if (reg <= p_.one()) return out;
    const Program::Form& f = p_.forms[idx(reg - p_.one() - 1)];  // forms have the last registers, in their order
    out.moves = f.moving != f.unknowns;
    if (f.end - f.unknowns > 1) separable_ = false;
    if (f.end == f.unknowns) return out;
    out.unknown = p_.operands[idx(f.unknowns)].reg;
    out.slope = p_.operands[idx(f.unknowns)].coefficient;
    return out;
  }

  void linear(std::int32_t i, const Program::Operand& o) {
    const Part x = part(o.reg);
    if (x.unknown >= 0) out_.linear.push_back({i, x.unknown, o.coefficient, x.slope, p_.one()});
    if (x.known < 0) return;
    out_.known.push_back({i, o.coefficient, x.known});
    if (x.moves) out_.moving_known.push_back(out_.known.back());
  }

  void product(std::int32_t i, const Program::Product& q) {
    const Part a = part(q.a), b = part(q.b);
    if (q.a == q.b && a.unknown >= 0) {
      Separable::Square& square = out_.squares[idx(i * p_.n + a.unknown)];
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

  const Program& p_;
  std::span<const std::uint8_t> input_moves_;
  Separable out_;
  bool separable_ = true;
};

}  // namespace

std::optional<Separable> separate(const Program& program, std::span<const std::uint8_t> input_moves) {
  return Separation(program, input_moves).run();
}

bool measures_distances(const Separable& separable, const Program& program) {
  const auto literal = [&](std::int32_t coefficient, double none) {
    if (coefficient == Separable::kNone) return none;
    const Coefficient& c = program.coefficients[idx(coefficient)];
    return c == Coefficient{c.literal} ? c.literal : kNan;
  };
  const double sign = literal(separable.squares[0].a, 1);
  if (std::abs(sign) != 1) return false;
  for (const Separable::Square& q : separable.squares) {
    if (literal(q.s, 0) != 1 || literal(q.a, 1) != sign) return false;
  }
  std::vector<std::int32_t> constants(idx(program.n), 0);
  for (const Separable::Known& t : separable.known) {
    if (t.reg != program.one()) return false;
    ++constants[idx(t.equation)];
  }
  return separable.linear.empty() &&
         std::all_of(constants.begin(), constants.end(), [](std::int32_t count) { return count == 1; });
}

}  // namespace assur
