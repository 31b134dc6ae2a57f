#include "equations/program.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>

#include "backends/with_lanes.hpp"
#include "index.hpp"
#include "numbers.hpp"

namespace assur {
namespace {

class Compiler {
 public:
  Compiler(const GroupClass& c, Pattern pattern) : c_(c) {
    p_.n = c.n;
    p_.inputs = c.inputs;
    p_.equations_count = static_cast<std::int32_t>(c.equations.size());
    p_.pattern = std::move(pattern);
    p_.unknown_block = c.unknown_block;
    p_.equation_block = c.equation_block;
    p_.blocks = c.blocks;
    p_.registers = c.n + c.inputs + 1;
  }

  Program run() {
    for (std::int32_t f = 0; f < c_.forms(); ++f) form(f);
    for (const GroupClass::Equation& e : c_.equations) equation(e);
    callbacks();
    gears();
    jacobian();
    return std::move(p_);
  }

 private:
  // A form of the class in terms of the program.
  struct Value {
    std::int32_t reg = -1;       // -1: constant
    std::int32_t constant = -1;  // coefficient, if constant
    bool moves = false, unknown = false;
  };

  std::span<const GroupClass::Term> terms(std::int32_t f) const {
    return {c_.terms.data() + c_.form_start[idx(f)], c_.terms.data() + c_.form_start[idx(f) + 1]};
  }

  std::int32_t coefficient(Coefficient k) {
    std::sort(std::begin(k.constant), std::end(k.constant), std::greater<>());
    const auto key = std::tuple(k.literal, k.constant[0], k.constant[1], k.constant[2]);
    const auto [found, added] = known_.try_emplace(key, static_cast<std::int32_t>(p_.coefficients.size()));
    if (added) p_.coefficients.push_back(k);
    return found->second;
  }
  // Class constants: -1 stands for +1, -2 for -1, any other value is a slot.
  static Coefficient of(std::int32_t constant) {
    Coefficient k;
    if (constant == -2) k.literal = -1;
    if (constant >= 0) k.constant[0] = constant;
    return k;
  }
  static Coefficient times(Coefficient a, const Coefficient& b) {
    a.literal *= b.literal;
    for (const std::int32_t c : b.constant) {
      if (c >= 0) *std::find(std::begin(a.constant), std::end(a.constant), -1) = c;
    }
    return a;
  }

  bool moves(std::int32_t coordinate) const {
    return coordinate >= c_.n && c_.input_moves[idx(coordinate - c_.n)] != 0;
  }

  void form(std::int32_t f) {
    Value v;
    std::vector<GroupClass::Term> constants, unknowns, inputs;
    for (const GroupClass::Term& t : terms(f)) {
      (t.coordinate < 0 ? constants : t.coordinate < c_.n ? unknowns : inputs).push_back(t);
      v.moves |= moves(t.coordinate);
      v.unknown |= t.coordinate >= 0 && t.coordinate < c_.n;
    }
    if (unknowns.empty() && inputs.empty()) {
      // A form has at most one constant term, because equal coordinates were merged.
      v.constant = coefficient(constants.empty() ? Coefficient{0.0, {-1, -1, -1}} : of(constants[0].constant));
      values_.push_back(v);
      return;
    }
    if (constants.empty() && unknowns.size() + inputs.size() == 1) {
      const GroupClass::Term t = unknowns.empty() ? inputs[0] : unknowns[0];
      if (t.constant == -1) {
        v.reg = t.coordinate;
        values_.push_back(v);
        return;
      }
    }
    Program::Form out{};
    out.reg = v.reg = p_.registers++;
    const auto put = [&](const std::vector<GroupClass::Term>& list, bool moving) {
      for (const GroupClass::Term& t : list) {
        if (moves(t.coordinate) == moving) p_.operands.push_back({coefficient(of(t.constant)), t.coordinate});
      }
      return static_cast<std::int32_t>(p_.operands.size());
    };
    out.begin = static_cast<std::int32_t>(p_.operands.size());
    if (!constants.empty()) p_.operands.push_back({coefficient(of(constants[0].constant)), p_.one()});
    out.moving = put(inputs, false);
    out.unknowns = put(inputs, true);
    out.end = put(unknowns, false);
    p_.forms.push_back(out);
    values_.push_back(v);
  }

  void equation(const GroupClass::Equation& e) {
    Program::Equation out{};
    const auto here = [&](std::int32_t Program::Range::*side) {
      const auto at = [](const auto& list) { return static_cast<std::int32_t>(list.size()); };
      out.linear.*side = at(p_.linear);
      out.products.*side = at(p_.products);
      out.input_linear.*side = at(p_.input_linear);
      out.input_products.*side = at(p_.input_products);
      out.curvature.*side = at(p_.curvature);
    };
    here(&Program::Range::begin);
    out.gear = e.gear;
    if (e.linear >= 0) linear(Coefficient{}, values_[idx(e.linear)]);
    out.factors = static_cast<std::int32_t>(p_.linear.size());
    if (e.callback < 0) {
      for (std::int32_t i = e.products_begin; i < e.products_end; ++i) product(c_.products[idx(i)]);
    }
    here(&Program::Range::end);
    p_.equations.push_back(out);
  }

  void linear(const Coefficient& k, const Value& v) {
    if (v.reg < 0) {
      p_.linear.push_back({coefficient(times(k, p_.coefficients[idx(v.constant)])), p_.one()});
      return;
    }
    p_.linear.push_back({coefficient(k), v.reg});
    if (v.moves) p_.input_linear.push_back(p_.linear.back());
  }

  // A constant factor becomes part of the coefficient.
  void product(const GroupClass::Product& q) {
    const Value &a = values_[idx(q.a)], &b = values_[idx(q.b)];
    const Coefficient k = of(q.constant);
    if (a.reg < 0) return linear(times(k, p_.coefficients[idx(a.constant)]), b);
    if (b.reg < 0) return linear(times(k, p_.coefficients[idx(b.constant)]), a);
    Coefficient twice = k;
    twice.literal *= 2;
    p_.products.push_back({coefficient(k), a.reg, b.reg});
    if (a.reg == b.reg) {
      if (a.moves) p_.input_products.push_back({coefficient(twice), a.reg, a.reg});
    } else {
      if (a.moves) p_.input_products.push_back({coefficient(k), a.reg, b.reg});
      if (b.moves) p_.input_products.push_back({coefficient(k), b.reg, a.reg});
    }
    if ((a.moves || a.unknown) && (b.moves || b.unknown)) {
      p_.curvature.push_back({coefficient(twice), a.reg, b.reg});
    }
  }

  void callbacks() {
    for (std::int32_t i = 0; i < p_.equations_count; ++i) {
      const GroupClass::Equation& e = c_.equations[idx(i)];
      if (e.callback < 0 || e.gear >= 0) continue;
      auto use = use_of(e.callback);
      if (use == p_.callbacks.end()) use = p_.callbacks.insert(use, {e.callback, {}, arguments(e)});
      use->rows.push_back({i, e.row});
    }
  }
  void gears() {
    p_.gears.resize(c_.gears.size());
    for (const GroupClass::Equation& e : c_.equations) {
      if (e.gear >= 0) p_.gears[idx(e.gear)] = {c_.gears[idx(e.gear)], arguments(e)};
    }
    for (Program::Gear& gear : p_.gears) {
      gear.first = p_.gear_arguments;
      gear.first_angle = p_.gear_angles;
      p_.gear_arguments += static_cast<std::int32_t>(gear.arguments.size());
      for (const GroupClass::Gear::Side& side : gear.numbers.sides) p_.gear_angles += side.arguments > 1 ? 1 : 0;
    }
  }
  [[nodiscard]] std::vector<std::int32_t> arguments(const GroupClass::Equation& e) const {
    std::vector<std::int32_t> out;
    for (std::int32_t k = e.products_begin; k < e.products_end; ++k) {
      const Value& v = values_[idx(c_.products[idx(k)].a)];
      out.push_back(v.reg >= 0 ? v.reg : ~v.constant);
    }
    return out;
  }
  std::vector<Program::CallbackUse>::iterator use_of(std::int32_t callback) {
    return std::find_if(p_.callbacks.begin(), p_.callbacks.end(),
                        [&](const Program::CallbackUse& u) { return u.callback == callback; });
  }

  void jacobian() {
    std::vector<std::map<std::int32_t, std::int32_t>> nonzero(idx(p_.equations_count));  // row -> column -> index
    for (std::int32_t column = 0; column < p_.n; ++column) {
      for (std::int32_t k = p_.pattern.column_start[idx(column)]; k < p_.pattern.column_start[idx(column) + 1]; ++k) {
        nonzero[idx(p_.pattern.row[idx(k)])][column] = k;
      }
    }
    std::vector<std::vector<Program::Operand>> entry(idx(p_.pattern.nnz()));
    // d(form)/d(unknown) * coefficient * register
    const auto through = [&](std::int32_t row, std::int32_t form, const Coefficient& k, std::int32_t reg) {
      for (const GroupClass::Term& t : terms(form)) {
        if (t.coordinate < 0 || t.coordinate >= c_.n) continue;
        Coefficient total = times(k, of(t.constant));
        std::vector<Program::Operand>& sum = entry[idx(nonzero[idx(row)].at(t.coordinate))];
        // f * f yields the same operand twice; it is stored once, with twice the coefficient.
        const std::int32_t id = coefficient(total);
        const auto same = std::find_if(sum.begin(), sum.end(),
                                       [&](const Program::Operand& o) { return o.coefficient == id && o.reg == reg; });
        if (same == sum.end()) {
          sum.push_back({id, reg});
        } else {
          total.literal *= 2;
          same->coefficient = coefficient(total);
        }
      }
    };
    for (std::int32_t i = 0; i < p_.equations_count; ++i) {
      const GroupClass::Equation& e = c_.equations[idx(i)];
      if (e.callback >= 0) {
        callback_row(e, nonzero[idx(i)]);
        continue;
      }
      if (e.linear >= 0) through(i, e.linear, Coefficient{}, p_.one());
      for (std::int32_t k = e.products_begin; k < e.products_end; ++k) {
        const GroupClass::Product& q = c_.products[idx(k)];
        const Value &a = values_[idx(q.a)], &b = values_[idx(q.b)];
        const auto side = [&](std::int32_t form, const Value& other) {
          if (other.reg >= 0) {
            through(i, form, of(q.constant), other.reg);
          } else {
            through(i, form, times(of(q.constant), p_.coefficients[idx(other.constant)]), p_.one());
          }
        };
        side(q.a, b);
        side(q.b, a);
      }
    }
    for (const auto& sum : entry) {
      const auto begin = static_cast<std::int32_t>(p_.entry_operands.size());
      p_.entry_operands.insert(p_.entry_operands.end(), sum.begin(), sum.end());
      p_.entries.push_back({begin, static_cast<std::int32_t>(p_.entry_operands.size())});
    }
    std::stable_sort(p_.gear_entries.begin(), p_.gear_entries.end(),
                     [](const auto& a, const auto& b) { return a.nonzero < b.nonzero; });
  }

  void callback_row(const GroupClass::Equation& e, const std::map<std::int32_t, std::int32_t>& nonzero) {
    const auto use = static_cast<std::int32_t>(use_of(e.callback) - p_.callbacks.begin());
    for (std::int32_t k = e.products_begin; k < e.products_end; ++k) {
      for (const GroupClass::Term& t : terms(c_.products[idx(k)].a)) {
        if (t.coordinate < 0 || t.coordinate >= c_.n) continue;
        const std::int32_t at = nonzero.at(t.coordinate), argument = k - e.products_begin;
        if (e.gear >= 0) {
          p_.gear_entries.push_back({at, e.gear, argument, coefficient(of(t.constant))});
        } else {
          p_.callback_entries.push_back({at, use, e.row, argument, coefficient(of(t.constant))});
        }
      }
    }
  }

  const GroupClass& c_;
  Program p_;
  std::vector<Value> values_;                                                                   // forms of the class
  std::map<std::tuple<double, std::int32_t, std::int32_t, std::int32_t>, std::int32_t> known_;  // coefficients
};

}  // namespace

Program compile(const GroupClass& group_class, Pattern pattern) {
  return Compiler(group_class, std::move(pattern)).run();
}

void bind_coefficients(const Program& p, const double* constants, double* out, std::size_t lanes) {
  with_lanes(lanes, [&](auto w) {
    for (const Coefficient& k : p.coefficients) {
      double product[kMostLanes];
      for (std::size_t l = 0; l < w; ++l) product[l] = k.literal;
      for (const std::int32_t c : k.constant) {
        for (std::size_t l = 0; c >= 0 && l < w; ++l) product[l] *= constants[idx(c) * w + l];
      }
      for (std::size_t l = 0; l < w; ++l) *out++ = product[l];
    }
  });
}

void lipschitz(const GroupClass& c, const double* constants, double* out, std::size_t lanes) {
  using Row = std::array<double, kMostLanes>;
  Row ones;
  ones.fill(1);
  const auto sizes = [&](std::int32_t constant) {  // those of literals are 1 or -1
    return constant < 0 ? ones.data() : constants + idx(constant) * lanes;
  };
  // Sums of |coefficient| of a form: over the block's unknowns, and over everything that moves.
  struct Sums {
    Row in_block, moving;
  };
  const auto add_up = [&](auto w, std::int32_t f, std::int32_t block, Sums& to) {
    for (std::size_t l = 0; l < w; ++l) to.in_block[l] = to.moving[l] = 0;
    for (std::int32_t t = c.form_start[idx(f)]; t < c.form_start[idx(f) + 1]; ++t) {
      const GroupClass::Term& term = c.terms[idx(t)];
      const bool is_unknown = term.coordinate < c.n;
      if (term.coordinate < 0 || (!is_unknown && c.input_moves[idx(term.coordinate - c.n)] == 0)) continue;
      const bool is_in_block = is_unknown && c.unknown_block[idx(term.coordinate)] == block;
      const double* const a = sizes(term.constant);
      for (std::size_t l = 0; l < w; ++l) to.moving[l] += std::abs(a[l]);
      for (std::size_t l = 0; is_in_block && l < w; ++l) to.in_block[l] += std::abs(a[l]);
    }
  };
  with_lanes(lanes, [&](auto w) {
    Sums a, b;
    for (std::size_t i = 0; i < c.equations.size(); ++i, out += w) {
      const GroupClass::Equation& e = c.equations[i];
      std::fill_n(out, std::size_t{w}, e.callback >= 0 ? kInfinity : 0);
      for (std::int32_t k = e.products_begin; k < e.products_end && e.callback < 0; ++k) {
        const GroupClass::Product& p = c.products[idx(k)];
        add_up(w, p.a, c.equation_block[i], a);
        if (p.b != p.a) add_up(w, p.b, c.equation_block[i], b);
        const Sums& other = p.b == p.a ? a : b;
        const double* const factor = sizes(p.constant);
        for (std::size_t l = 0; l < w; ++l) {
          out[l] += std::abs(factor[l]) * (a.in_block[l] * other.moving[l] + a.moving[l] * other.in_block[l]);
        }
      }
    }
  });
}

}  // namespace assur
