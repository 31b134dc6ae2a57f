#include "program/step_graph.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <utility>

namespace assur {
namespace {

// The operation on numbers.
double fold(Op op, double a, double b, double c, double d) {
  switch (op) {
    case Op::add:
      return a + b;
    case Op::subtract:
      return a - b;
    case Op::multiply:
      return a * b;
    case Op::divide:
      return a / b;
    case Op::fma:
      return std::fma(a, b, c);
    case Op::fnma:
      return std::fma(-a, b, c);
    case Op::square_root:
      return std::sqrt(a);
    case Op::absolute:
      return std::abs(a);
    case Op::copy_sign:
      return std::copysign(a, b);
    case Op::round:
      return std::nearbyint(a);
    case Op::larger:
      return a > b ? a : b;
    case Op::select:
      return a <= b ? c : d;
    case Op::load:
    case Op::pick:
    case Op::constant:
      break;
  }
  return a;
}

bool is(const Value& v, double number) {
  return v.is_constant() && std::bit_cast<std::uint64_t>(v.number) == std::bit_cast<std::uint64_t>(number);
}

bool are_equal(const Value& a, const Value& b) {
  return a.graph == b.graph && (a.is_constant() ? is(a, b.number) : a.id == b.id);
}

// a b
std::optional<Value> simple_product(const Value& a, const Value& b) {
  if (is(a, 0) || is(b, 0)) return Value::set(0);
  if (is(a, 1)) return b;
  if (is(b, 1)) return a;
  return std::nullopt;
}

}  // namespace

// x if v is -x.
std::optional<Value> Graph::negated(const Value& v) {
  if (v.is_constant()) return std::nullopt;
  const Graph& g = *v.graph;
  const Node& n = g.nodes_[v.id];
  if (n.op != Op::multiply) return std::nullopt;
  for (const std::size_t k : {0U, 1U}) {
    const Node& factor = g.nodes_[n.operand[k]];
    if (factor.op == Op::constant && factor.number == -1) return Value{v.graph, n.operand[1 - k], 0};
  }
  return std::nullopt;
}

// What an operation is without operations, or with a simpler one of the same bits.
std::optional<Value> Graph::simplified(Op op, const Value& a, const Value& b, const Value& c, const Value& d) {
  switch (op) {
    case Op::add:
      if (is(a, 0)) return b;
      if (is(b, 0)) return a;
      if (const auto x = negated(a)) return b - *x;
      if (const auto x = negated(b)) return a - *x;
      break;
    case Op::subtract:
      if (is(b, 0)) return a;
      if (const auto x = negated(b)) return a + *x;
      break;
    case Op::multiply:
      return simple_product(a, b);
    case Op::divide:
      if (is(b, 1) || is(a, 0)) return a;
      break;
    case Op::absolute:
      if (const auto x = negated(a)) return abs(*x);
      break;
    case Op::fma:
    case Op::fnma: {
      auto product = simple_product(a, b);
      if (!product && (is(a, -1) || is(b, -1))) product = a * b;
      if (product) return op == Op::fma ? c + *product : c - *product;
      break;
    }
    case Op::select:
      if (are_equal(c, d)) return c;
      break;
    default:
      break;
  }
  return std::nullopt;
}

Value make(Op op, Value a, Value b, Value c, Value d) {
  const auto operands = static_cast<std::size_t>(operands_of(op));
  std::array<Value*, 4> all = {&a, &b, &c, &d};
  Graph* graph = nullptr;
  for (std::size_t k = 0; k < operands && graph == nullptr; ++k) graph = all[k]->graph;
  if (graph == nullptr) return Value::set(fold(op, a.number, b.number, c.number, d.number));
  if (const auto simple = Graph::simplified(op, a, b, c, d)) return *simple;
  std::array<std::uint32_t, 4> of{};
  for (std::size_t k = 0; k < operands; ++k) of[k] = graph->node_of(*all[k]);
  const bool commutes = op == Op::add || op == Op::multiply || op == Op::fma || op == Op::fnma;
  if (commutes && of[0] > of[1]) std::swap(of[0], of[1]);
  return graph->add({op, of, {}, 0});
}

Value Graph::add(const Node& node) {
  if (2 * nodes_.size() >= table_.size()) {
    table_.assign(std::max<std::size_t>(2 * table_.size(), 256), 0);
    for (std::uint32_t i = 0; i < nodes_.size(); ++i) table_[place_of(nodes_[i])] = i + 1;
  }
  std::uint32_t& at = table_[place_of(node)];
  if (at == 0) {
    nodes_.push_back(node);
    at = static_cast<std::uint32_t>(nodes_.size());
  }
  return {this, at - 1, 0};
}

std::size_t Graph::place_of(const Node& node) const {
  std::uint64_t hash = static_cast<std::uint64_t>(node.op);
  const auto mix = [&](std::uint64_t x) { hash = (hash ^ x) * 0x9e3779b97f4a7c15; };  // Knuth's multiplicative hashing
  for (const std::uint32_t operand : node.operand) mix(operand);
  mix(memory_of(node.slot));
  mix(node.slot.index * 4 + static_cast<std::uint64_t>(node.slot.reach));
  mix(std::bit_cast<std::uint64_t>(node.number));
  const auto is_same = [&](const Node& n) {
    return n.op == node.op && n.operand == node.operand && n.slot == node.slot &&
           std::bit_cast<std::uint64_t>(n.number) == std::bit_cast<std::uint64_t>(node.number);
  };
  const std::size_t mask = table_.size() - 1;
  std::size_t place = (hash >> 32) & mask;
  while (table_[place] != 0 && !is_same(nodes_[table_[place] - 1])) place = (place + 1) & mask;
  return place;
}

Value Graph::pick(Slot first, const Value& index) { return add({Op::pick, {node_of(index)}, first, 0}); }

Value Graph::load(Slot slot) { return add({Op::load, {}, slot, 0}); }

std::uint32_t Graph::node_of(const Value& value) {
  return value.is_constant() ? add({Op::constant, {}, {}, value.number}).id : value.id;
}

Phase Graph::phase() const {
  Phase out;
  std::vector<std::uint32_t> place(nodes_.size(), UINT32_MAX);
  std::vector<std::uint32_t> open;
  const auto write = [&](std::uint32_t id) {
    const Node& n = nodes_[id];
    Instruction to{n.op, {}, n.slot};
    for (std::size_t k = 0; k < static_cast<std::size_t>(operands_of(n.op)); ++k) to.operand[k] = place[n.operand[k]];
    if (n.op == Op::constant) {
      to.operand[0] = static_cast<std::uint32_t>(out.constants.size());
      out.constants.push_back(n.number);
    }
    place[id] = static_cast<std::uint32_t>(out.code.size());
    out.code.push_back(to);
  };
  // Operands come before their node. Without recursion, because a graph may be deep.
  const auto write_all = [&](std::uint32_t last) {
    open = {last};
    while (!open.empty()) {
      const std::uint32_t id = open.back();
      const std::size_t before = open.size();
      for (std::size_t k = static_cast<std::size_t>(operands_of(nodes_[id].op)); k-- > 0;) {
        if (place[nodes_[id].operand[k]] == UINT32_MAX) open.push_back(nodes_[id].operand[k]);
      }
      if (open.size() > before) continue;
      open.pop_back();
      if (place[id] == UINT32_MAX) write(id);
    }
  };
  for (const Phase::Store& s : stores_) {
    write_all(s.value);
    out.stores.push_back({s.to, place[s.value]});
  }
  return out;
}

Phase Graph::take_phase() {
  Phase out = phase();
  *this = {};
  return out;
}

}  // namespace assur
