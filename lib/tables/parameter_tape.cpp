#include "tables/parameter_tape.hpp"

#include <algorithm>
#include <utility>

#include "evaluation/angles-inl.hpp"
#include "index.hpp"

namespace assur {
namespace {

Slot row(Memory memory, std::size_t i) { return {memory, static_cast<std::uint32_t>(i)}; }

// 0 for a finite number, else NaN.
Value finite(const Value& x) { return x - x; }

Value result(Number::Operation op, const Value& a, const Value& b, const Value& c) {
  using enum Number::Operation;
  switch (op) {
    case add:
      return a + b;
    case subtract:
      return a - b;
    case multiply:
      return a * b;
    case divide:
      return a / b;
    case negate:
      return -a;
    case fused:
      return make(Op::fma, a, b, c);
    case root:
      return sqrt(a);
    case length:
      return sqrt(a * a + b * b + c * c);
    case magnitude:
      return abs(a);
    case angle:
      return HWY_NAMESPACE::signed_angle_of(a, b);
  }
  return {};
}

// The sum, as a tree: that of a large scene has many terms.
Value sum_of(std::span<const Value> terms) {
  if (terms.empty()) return Value::set(0);
  if (terms.size() == 1) return terms[0];
  const std::size_t half = terms.size() / 2;
  return sum_of(terms.first(half)) + sum_of(terms.subspan(half));
}

}  // namespace

ParameterTape::StagedValue ParameterTape::entry(const Number& number) const {
  return has(number) ? entries_[place_of(number)] : StagedValue{Value::set(number.value())};
}

std::size_t ParameterTape::add(const StagedValue& entry) {
  entries_.push_back(entry);
  return entries_.size() - 1;
}

Number ParameterTape::parameter(double value) {
  const Value loaded = graph_.load(row(Memory::factors, parameters_++));
  conditions_.push_back(finite(loaded));
  return number(value, add({loaded}));
}

Number ParameterTape::formula(std::string text, std::vector<std::string> names, std::span<const Number> arguments,
                              double value) {
  Formula& f = formulas_.emplace_back(Formula{{std::move(text), std::move(names), {}, 0}, {}, 1});
  for (const Number& argument : arguments) {
    const StagedValue of = entry(argument);
    f.arguments.push_back(of.value);
    f.text.arguments.push_back(static_cast<std::uint32_t>(rows_++));
    f.depth = std::max(f.depth, of.depth + 1);
  }
  f.text.row = static_cast<std::uint32_t>(rows_++);
  return number(value, add({graph_.load(row(Memory::work, f.text.row)), f.depth}));
}

std::optional<std::size_t> ParameterTape::operation(Number::Operation op, const Number& a, const Number& b,
                                                    const Number& c) {
  const StagedValue of_a = entry(a), of_b = entry(b), of_c = entry(c);
  const Value value = result(op, of_a.value, of_b.value, of_c.value);
  if (value.is_constant()) return {};
  return add({value, std::max({of_a.depth, of_b.depth, of_c.depth})});
}

void ParameterTape::comparison(const Number& a, const Number& b, bool is_less, bool outcome) {
  const Value x = entry(a).value, y = entry(b).value, none = Value::set(0), one = Value::set(1);
  const Value fails = is_less ? if_at_most(y, x, one, none) : if_at_most(abs(x - y), none, none, one);
  conditions_.push_back(outcome ? fails : one - fails);
  conditions_.push_back(finite(x));
  conditions_.push_back(finite(y));
}

ParameterProgram ParameterTape::program(std::span<const Number> wanted) {
  ParameterProgram out{{}, parameters_, rows_, wanted.size()};
  std::vector<Value> conditions = conditions_;
  for (const Number& number : wanted) conditions.push_back(finite(entry(number).value));
  // The same numbers are compared many times.
  const auto id = [](const Value& v) { return v.is_constant() ? UINT32_MAX : v.id; };
  std::sort(conditions.begin(), conditions.end(), [&](const Value& a, const Value& b) { return id(a) < id(b); });
  const auto is_same = [&](const Value& a, const Value& b) { return id(a) == id(b) && a.number == b.number; };
  conditions.erase(std::unique(conditions.begin(), conditions.end(), is_same), conditions.end());
  const Value off = sum_of(conditions);
  Graph last = graph_;
  for (std::size_t i = 0; i < wanted.size(); ++i) last.store(row(Memory::outputs, i), entry(wanted[i]).value);
  last.store(row(Memory::figures, 0), off);

  // Backwards, because a part computes the arguments of those texts that later parts need.
  std::vector<std::uint8_t> is_read(rows_, 0);
  const auto append = [&](const Graph& graph, std::vector<ParameterProgram::Text> texts) {
    out.parts.push_back({{{graph.phase()}, {}}, std::move(texts)});
    for (const Instruction& i : out.parts.back().program.phases[0].code) {
      if (i.op == Op::load && i.slot.memory == Memory::work) is_read[i.slot.index] = 1;
    }
  };
  append(last, {});
  std::size_t deepest = 0;
  for (const Formula& f : formulas_) deepest = std::max(deepest, f.depth);
  for (std::size_t depth = deepest; depth > 0; --depth) {
    Graph part = graph_;
    std::vector<ParameterProgram::Text> texts;
    for (const Formula& f : formulas_) {
      if (f.depth != depth || is_read[f.text.row] == 0) continue;
      texts.push_back(f.text);
      for (std::size_t i = 0; i < f.arguments.size(); ++i) {
        part.store(row(Memory::work, f.text.arguments[i]), f.arguments[i]);
      }
    }
    if (!texts.empty()) append(part, std::move(texts));
  }
  std::reverse(out.parts.begin(), out.parts.end());
  return out;
}

}  // namespace assur
