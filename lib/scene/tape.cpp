#include "scene/tape.hpp"

#include <utility>

#include "index.hpp"

namespace assur {
namespace {

// Numbers whose last digits are zero, such as 1 or 0.25, may be anything: their bits name no node.
constexpr std::uint64_t kLastDigits = (std::uint64_t{1} << 20) - 1;

}  // namespace

constinit thread_local Tape* Tape::active_ = nullptr;

Tape::Tape(std::span<const double> values) : parameters_(values.size()) {
  for (std::size_t i = 0; i < values.size(); ++i) add({Kind::parameter, static_cast<Node>(i)}, values[i]);
}

Tape::Node Tape::add(const Operation& operation, double result) {
  const auto node = static_cast<Node>(operations_.size());
  operations_.push_back(operation);
  const auto bits = std::bit_cast<std::uint64_t>(result);
  // The bits of |a| are also those of a or -a.
  if (operation.kind != Kind::magnitude && (bits & kLastDigits) != 0) node_of_.try_emplace(bits, node);
  return node;
}

Tape::Node Tape::record(Kind kind, double result, const Operation& operands) {
  return add({kind, operands.a, operands.b, operands.c}, result);
}

void Tape::record(Formula formula, double result) {
  if (find(result) != kNone) return;
  formulas_.push_back(std::move(formula));
  add({Kind::formula, kNone, static_cast<Node>(formulas_.size()) - 1}, result);
}

Tape::Node Tape::literal(double value) {
  const auto [found, is_new] = literal_of_.try_emplace(std::bit_cast<std::uint64_t>(value), kNone);
  if (is_new) {
    literals_.push_back(value);
    operations_.push_back({Kind::literal, static_cast<Node>(literals_.size()) - 1});
    found->second = static_cast<Node>(operations_.size()) - 1;
  }
  return found->second;
}

}  // namespace assur
