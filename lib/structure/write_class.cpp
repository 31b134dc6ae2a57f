#include "structure/write_class.hpp"

#include <algorithm>
#include <functional>
#include <iterator>
#include <map>
#include <set>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "index.hpp"

namespace assur {
namespace {

using Coefficient = GroupClass::Coefficient;

// Of the Jacobian.
Pattern pattern_of(const LocalEquations& c) {
  const Index n = c.outline.n;
  std::vector<std::set<Index>> rows(idx(n));  // for each column
  for (Index i = 0; i < n; ++i) {
    const LocalEquations::Equation& e = c.equations[idx(i)];
    const auto take = [&](Index f) {
      if (f < 0) return;
      for (Index t = c.form_start[idx(f)]; t < c.form_start[idx(f) + 1]; ++t) {
        const Index u = c.terms[idx(t)].coordinate;
        if (u >= 0 && u < n) rows[idx(u)].insert(i);
      }
    };
    take(e.linear);
    for (Index p = e.products_begin; p < e.products_end; ++p) {
      take(c.products[idx(p)].a);
      take(c.products[idx(p)].b);
    }
  }
  Pattern out;
  out.n = n;
  out.column_start = {0};
  for (const auto& column : rows) {
    out.row.insert(out.row.end(), column.begin(), column.end());
    out.column_start.push_back(static_cast<Index>(out.row.size()));
  }
  return out;
}

class ClassWriter {
 public:
  explicit ClassWriter(const LocalEquations& c) : local_(c), class_(c.outline) { class_.pattern = pattern_of(c); }

  GroupClass run() {
    for (std::int32_t f = 0; f < local_.forms(); ++f) form(f);
    for (const LocalEquations::Equation& e : local_.equations) equation(e);
    callbacks();
    gears();
    jacobian();
    return std::move(class_);
  }

 private:
  // A form of the class in terms of the program.
  struct Value {
    std::int32_t reg = -1;       // -1: constant
    std::int32_t constant = -1;  // coefficient, if constant
    bool moves = false, unknown = false;
  };

  std::span<const LocalEquations::Term> terms(std::int32_t f) const {
    return {local_.terms.data() + local_.form_start[idx(f)], local_.terms.data() + local_.form_start[idx(f) + 1]};
  }

  std::int32_t coefficient(Coefficient k) {
    std::sort(std::begin(k.constant), std::end(k.constant), std::greater<>());
    const auto key = std::tuple(k.literal, k.constant[0], k.constant[1], k.constant[2]);
    const auto [found, added] = known_.try_emplace(key, static_cast<std::int32_t>(class_.coefficients.size()));
    if (added) class_.coefficients.push_back(k);
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
    return coordinate >= class_.n && class_.input_moves[idx(coordinate - class_.n)] != 0;
  }

  void form(std::int32_t f) {
    Value v;
    std::vector<LocalEquations::Term> constants, unknowns, inputs;
    for (const LocalEquations::Term& t : terms(f)) {
      (t.coordinate < 0 ? constants : t.coordinate < class_.n ? unknowns : inputs).push_back(t);
      v.moves |= moves(t.coordinate);
      v.unknown |= t.coordinate >= 0 && t.coordinate < class_.n;
    }
    if (unknowns.empty() && inputs.empty()) {
      // A form has at most one constant term, because equal coordinates were merged.
      v.constant = coefficient(constants.empty() ? Coefficient{0.0, {-1, -1, -1}} : of(constants[0].constant));
      values_.push_back(v);
      return;
    }
    if (constants.empty() && unknowns.size() + inputs.size() == 1) {
      const LocalEquations::Term t = unknowns.empty() ? inputs[0] : unknowns[0];
      if (t.constant == -1) {
        v.reg = t.coordinate;
        values_.push_back(v);
        return;
      }
    }
    GroupClass::Form out{};
    out.reg = v.reg = class_.registers();
    const auto put = [&](const std::vector<LocalEquations::Term>& list, bool moving) {
      for (const LocalEquations::Term& t : list) {
        if (moves(t.coordinate) == moving) class_.operands.push_back({coefficient(of(t.constant)), t.coordinate});
      }
      return static_cast<std::int32_t>(class_.operands.size());
    };
    out.begin = static_cast<std::int32_t>(class_.operands.size());
    if (!constants.empty()) class_.operands.push_back({coefficient(of(constants[0].constant)), class_.one()});
    out.moving = put(inputs, false);
    out.unknowns = put(inputs, true);
    out.end = put(unknowns, false);
    class_.forms.push_back(out);
    values_.push_back(v);
  }

  void equation(const LocalEquations::Equation& e) {
    GroupClass::Equation out{};
    const auto here = [&](std::int32_t GroupClass::Range::*side) {
      const auto at = [](const auto& list) { return static_cast<std::int32_t>(list.size()); };
      out.linear.*side = at(class_.linear);
      out.products.*side = at(class_.products);
      out.input_linear.*side = at(class_.input_linear);
      out.input_products.*side = at(class_.input_products);
      out.curvature.*side = at(class_.curvature);
    };
    here(&GroupClass::Range::begin);
    out.gear = e.gear;
    if (e.linear >= 0) linear(Coefficient{}, values_[idx(e.linear)]);
    out.factors = static_cast<std::int32_t>(class_.linear.size());
    if (e.callback < 0) {
      for (std::int32_t i = e.products_begin; i < e.products_end; ++i) product(local_.products[idx(i)]);
    }
    here(&GroupClass::Range::end);
    class_.equations.push_back(out);
  }

  void linear(const Coefficient& k, const Value& v) {
    if (v.reg < 0) {
      class_.linear.push_back({coefficient(times(k, class_.coefficients[idx(v.constant)])), class_.one()});
      return;
    }
    class_.linear.push_back({coefficient(k), v.reg});
    if (v.moves) class_.input_linear.push_back(class_.linear.back());
  }

  // A constant factor becomes part of the coefficient.
  void product(const LocalEquations::Product& q) {
    const Value &a = values_[idx(q.a)], &b = values_[idx(q.b)];
    const Coefficient k = of(q.constant);
    if (a.reg < 0) return linear(times(k, class_.coefficients[idx(a.constant)]), b);
    if (b.reg < 0) return linear(times(k, class_.coefficients[idx(b.constant)]), a);
    Coefficient twice = k;
    twice.literal *= 2;
    class_.products.push_back({coefficient(k), a.reg, b.reg});
    if (a.reg == b.reg) {
      if (a.moves) class_.input_products.push_back({coefficient(twice), a.reg, a.reg});
    } else {
      if (a.moves) class_.input_products.push_back({coefficient(k), a.reg, b.reg});
      if (b.moves) class_.input_products.push_back({coefficient(k), b.reg, a.reg});
    }
    if ((a.moves || a.unknown) && (b.moves || b.unknown)) {
      class_.curvature.push_back({coefficient(twice), a.reg, b.reg});
    }
  }

  void callbacks() {
    for (std::int32_t i = 0; i < static_cast<Index>(local_.equations.size()); ++i) {
      const LocalEquations::Equation& e = local_.equations[idx(i)];
      if (e.callback < 0 || e.gear >= 0) continue;
      auto use = use_of(e.callback);
      if (use == class_.callbacks.end()) use = class_.callbacks.insert(use, {e.callback, {}, arguments(e)});
      use->rows.push_back({i, e.row});
    }
  }
  void gears() {
    class_.gears = local_.gears;
    for (const LocalEquations::Equation& e : local_.equations) {
      if (e.gear >= 0) class_.gears[idx(e.gear)].arguments = arguments(e);
    }
    for (GroupClass::Gear& gear : class_.gears) {
      gear.first = class_.gear_arguments;
      gear.first_angle = class_.gear_angles;
      class_.gear_arguments += static_cast<std::int32_t>(gear.arguments.size());
      for (const GroupClass::Gear::Side& side : gear.sides) class_.gear_angles += side.arguments > 1 ? 1 : 0;
    }
  }
  [[nodiscard]] std::vector<std::int32_t> arguments(const LocalEquations::Equation& e) const {
    std::vector<std::int32_t> out;
    for (std::int32_t k = e.products_begin; k < e.products_end; ++k) {
      const Value& v = values_[idx(local_.products[idx(k)].a)];
      out.push_back(v.reg >= 0 ? v.reg : ~v.constant);
    }
    return out;
  }
  std::vector<GroupClass::CallbackUse>::iterator use_of(std::int32_t callback) {
    return std::find_if(class_.callbacks.begin(), class_.callbacks.end(),
                        [&](const GroupClass::CallbackUse& u) { return u.callback == callback; });
  }

  void jacobian() {
    std::vector<std::map<std::int32_t, std::int32_t>> nonzero(local_.equations.size());  // row -> column -> index
    for (std::int32_t column = 0; column < class_.n; ++column) {
      for (std::int32_t k = class_.pattern.column_start[idx(column)]; k < class_.pattern.column_start[idx(column) + 1];
           ++k) {
        nonzero[idx(class_.pattern.row[idx(k)])][column] = k;
      }
    }
    std::vector<std::vector<GroupClass::Operand>> entry(idx(class_.pattern.nnz()));
    // d(form)/d(unknown) * coefficient * register
    const auto through = [&](std::int32_t row, std::int32_t form, const Coefficient& k, std::int32_t reg) {
      for (const LocalEquations::Term& t : terms(form)) {
        if (t.coordinate < 0 || t.coordinate >= class_.n) continue;
        Coefficient total = times(k, of(t.constant));
        std::vector<GroupClass::Operand>& sum = entry[idx(nonzero[idx(row)].at(t.coordinate))];
        // f * f yields the same operand twice; it is stored once, with twice the coefficient.
        const std::int32_t id = coefficient(total);
        const auto same = std::find_if(
            sum.begin(), sum.end(), [&](const GroupClass::Operand& o) { return o.coefficient == id && o.reg == reg; });
        if (same == sum.end()) {
          sum.push_back({id, reg});
        } else {
          total.literal *= 2;
          same->coefficient = coefficient(total);
        }
      }
    };
    for (std::int32_t i = 0; i < static_cast<Index>(local_.equations.size()); ++i) {
      const LocalEquations::Equation& e = local_.equations[idx(i)];
      if (e.callback >= 0) {
        callback_row(e, nonzero[idx(i)]);
        continue;
      }
      if (e.linear >= 0) through(i, e.linear, Coefficient{}, class_.one());
      for (std::int32_t k = e.products_begin; k < e.products_end; ++k) {
        const LocalEquations::Product& q = local_.products[idx(k)];
        const Value &a = values_[idx(q.a)], &b = values_[idx(q.b)];
        const auto side = [&](std::int32_t form, const Value& other) {
          if (other.reg >= 0) {
            through(i, form, of(q.constant), other.reg);
          } else {
            through(i, form, times(of(q.constant), class_.coefficients[idx(other.constant)]), class_.one());
          }
        };
        side(q.a, b);
        side(q.b, a);
      }
    }
    for (const auto& sum : entry) {
      const auto begin = static_cast<std::int32_t>(class_.entry_operands.size());
      class_.entry_operands.insert(class_.entry_operands.end(), sum.begin(), sum.end());
      class_.entries.push_back({begin, static_cast<std::int32_t>(class_.entry_operands.size())});
    }
    std::stable_sort(class_.gear_entries.begin(), class_.gear_entries.end(),
                     [](const auto& a, const auto& b) { return a.nonzero < b.nonzero; });
  }

  void callback_row(const LocalEquations::Equation& e, const std::map<std::int32_t, std::int32_t>& nonzero) {
    const auto use = static_cast<std::int32_t>(use_of(e.callback) - class_.callbacks.begin());
    for (std::int32_t k = e.products_begin; k < e.products_end; ++k) {
      for (const LocalEquations::Term& t : terms(local_.products[idx(k)].a)) {
        if (t.coordinate < 0 || t.coordinate >= class_.n) continue;
        const std::int32_t at = nonzero.at(t.coordinate), argument = k - e.products_begin;
        if (e.gear >= 0) {
          class_.gear_entries.push_back({at, e.gear, argument, coefficient(of(t.constant))});
        } else {
          class_.callback_entries.push_back({at, use, e.row, argument, coefficient(of(t.constant))});
        }
      }
    }
  }

  const LocalEquations& local_;
  GroupClass class_;
  std::vector<Value> values_;                                                                   // forms of the class
  std::map<std::tuple<double, std::int32_t, std::int32_t, std::int32_t>, std::int32_t> known_;  // coefficients
};

}  // namespace

GroupClass write_class(const LocalEquations& equations) { return ClassWriter(equations).run(); }

}  // namespace assur
