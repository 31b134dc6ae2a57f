#include "program/graph.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace assur {
namespace {

// The operation on numbers. Only for operations that constants meet.
std::optional<double> fold(Op op, double a, double b) {
  switch (op) {
    case Op::add:
      return a + b;
    case Op::subtract:
      return a - b;
    case Op::multiply:
      return a * b;
    case Op::divide:
      return a / b;
    case Op::absolute:
      return std::abs(a);
    case Op::larger:
      return a > b ? a : b;
    default:
      return std::nullopt;
  }
}

}  // namespace

Value Graph::add(const Node& node) {
  const Key key{node.op, node.operand, node.slot.memory, node.slot.index, std::bit_cast<std::uint64_t>(node.number)};
  const auto [found, is_new] = known_.try_emplace(key, static_cast<std::uint32_t>(nodes_.size()));
  if (is_new) nodes_.push_back(node);
  return {this, found->second};
}

bool Graph::is(Value v, double number) const {
  const Node& n = nodes_[v.id];
  return n.op == Op::constant && std::bit_cast<std::uint64_t>(n.number) == std::bit_cast<std::uint64_t>(number);
}

Value Graph::load(Slot slot) { return add({Op::load, {}, slot, 0}); }
Value Graph::constant(double number) { return add({Op::constant, {}, {}, number}); }

Value Graph::make(Op op, Value a, Value b, Value c, Value d) {
  const int operands = operands_of(op);
  const auto is_constant = [&](Value v) { return nodes_[v.id].op == Op::constant; };
  if (operands <= 2 && is_constant(a) && (operands < 2 || is_constant(b))) {
    const auto folded = fold(op, nodes_[a.id].number, operands < 2 ? 0 : nodes_[b.id].number);
    if (folded) return constant(*folded);
  }
  if (op == Op::add && is(a, 0)) return b;
  if ((op == Op::add || op == Op::subtract) && is(b, 0)) return a;
  if (op == Op::multiply && (is(a, 0) || is(b, 0))) return constant(0);
  if (op == Op::multiply && is(a, 1)) return b;
  if ((op == Op::multiply || op == Op::divide) && is(b, 1)) return a;
  if (op == Op::divide && is(a, 0)) return a;
  if (op == Op::select && c.id == d.id) return c;
  if ((op == Op::add || op == Op::multiply) && a.id > b.id) std::swap(a, b);
  std::array<std::uint32_t, 4> of = {a.id, b.id, c.id, d.id};
  std::fill(of.begin() + operands, of.end(), 0);
  return add({op, of, {}, 0});
}

Phase Graph::phase() const {
  std::vector<Node> nodes = nodes_;
  std::vector<int> uses(nodes.size());
  const auto count = [&](const auto& self, std::uint32_t id) -> void {
    if (uses[id]++ > 0) return;
    for (int k = 0; k < operands_of(nodes[id].op); ++k) self(self, nodes[id].operand[static_cast<std::size_t>(k)]);
  };
  for (const Phase::Store& s : stores_) count(count, s.value);

  for (Node& n : nodes) {
    if (n.op != Op::add && n.op != Op::subtract) continue;
    const std::uint32_t a = n.operand[0], b = n.operand[1];
    const auto is_only_here = [&](std::uint32_t id) { return nodes[id].op == Op::multiply && uses[id] == 1; };
    if (is_only_here(b)) {
      n.op = n.op == Op::add ? Op::fma : Op::fnma;
      n.operand = {nodes[b].operand[0], nodes[b].operand[1], a};
    } else if (is_only_here(a)) {
      n.op = n.op == Op::add ? Op::fma : Op::fms;
      n.operand = {nodes[a].operand[0], nodes[a].operand[1], b};
    }
  }

  Phase out;
  std::vector<std::uint32_t> place(nodes.size(), UINT32_MAX);
  const auto write = [&](const auto& self, std::uint32_t id) -> void {
    if (place[id] != UINT32_MAX) return;
    const Node& n = nodes[id];
    Instruction to{n.op, {}, n.slot};
    for (std::size_t k = 0; k < static_cast<std::size_t>(operands_of(n.op)); ++k) {
      self(self, n.operand[k]);
      to.operand[k] = place[n.operand[k]];
    }
    if (n.op == Op::constant) {
      to.operand[0] = static_cast<std::uint32_t>(out.constants.size());
      out.constants.push_back(n.number);
    }
    place[id] = static_cast<std::uint32_t>(out.code.size());
    out.code.push_back(to);
  };
  for (const Phase::Store& s : stores_) {
    write(write, s.value);
    out.stores.push_back({s.to, place[s.value]});
  }
  return out;
}

}  // namespace assur
