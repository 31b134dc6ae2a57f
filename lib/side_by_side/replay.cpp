#include "side_by_side/replay.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <set>
#include <tuple>
#include <utility>

#include "equations/angles-inl.hpp"
#include "index.hpp"
#include "program/graph.hpp"

namespace assur {
namespace {

using Kind = Tape::Kind;

// Calls use(node) for each number that an operation reads.
template <class Use>
void each_operand(const Tape& tape, const Tape::Operation& o, const Use& use) {
  if (o.kind == Kind::parameter || o.kind == Kind::literal) return;
  if (o.kind == Kind::formula) {
    for (const Tape::Node n : tape.formulas()[idx(o.b)].arguments) use(n);
    return;
  }
  for (const Tape::Node n : {o.a, o.b, o.c}) {
    if (n != Tape::kNone) use(n);
  }
}

// Writes the programs of a tape.
class Writer {
 public:
  Writer(const Tape& tape, std::span<const Tape::Node> wanted) : tape_(tape), part_(tape.operations().size(), kUnused) {
    const auto use = [this](Tape::Node n) { part_[idx(n)] = 0; };
    std::for_each(wanted.begin(), wanted.end(), use);
    for (const Tape::Guard& g : tape.guards()) use(g.a), use(g.b);
    const auto operations = tape.operations();
    for (std::size_t i = operations.size(); i-- > 0;) {
      if (part_[i] != kUnused) each_operand(tape, operations[i], use);
    }
    for (std::size_t i = 0; i < operations.size(); ++i) {
      if (part_[i] == kUnused) continue;
      each_operand(tape, operations[i], [&](Tape::Node n) { part_[i] = std::max(part_[i], part_[idx(n)]); });
      if (operations[i].kind == Kind::formula) ++part_[i];
      parts_ = std::max(parts_, idx(part_[i]) + 1);
    }
    rows_.assign(part_.size(), -1);
    for (std::size_t i = 0; i < operations.size(); ++i) {
      if (part_[i] == kUnused) continue;
      const bool is_formula = operations[i].kind == Kind::formula;
      if (is_formula) give_row(i);
      each_operand(tape, operations[i], [&](Tape::Node n) {
        if (is_formula || (part_[idx(n)] < part_[i] && is_computed(idx(n)))) give_row(idx(n));
      });
    }
    for (const Tape::Node n : wanted) keep_for_the_end(n);
    for (const Tape::Guard& g : tape.guards()) keep_for_the_end(g.a), keep_for_the_end(g.b);
  }

  [[nodiscard]] std::size_t parts() const { return parts_; }
  [[nodiscard]] std::size_t rows() const { return idx(count_); }
  [[nodiscard]] std::uint32_t row(Tape::Node n) const { return static_cast<std::uint32_t>(rows_[idx(n)]); }
  // Formulas whose arguments part p or an earlier one computes.
  template <class Use>
  void each_formula(std::size_t p, const Use& use) const {
    for (std::size_t i = 0; i < part_.size(); ++i) {
      if (part_[i] == static_cast<std::int32_t>(p) + 1 && tape_.operations()[i].kind == Kind::formula) {
        use(static_cast<Tape::Node>(i), tape_.formulas()[idx(tape_.operations()[i].b)]);
      }
    }
  }

  // The p-th part. The last one also has the wanted numbers, and Memory::figures: 0 if all guards have their outcomes
  // and all numbers that are compared or wanted are finite, else another number or NaN.
  [[nodiscard]] StepProgram program(std::size_t p, std::span<const Tape::Node> wanted) const {
    Graph graph;
    std::vector<Value> values(part_.size());
    const auto row = [](Memory m, std::size_t i) { return Slot{m, static_cast<std::uint32_t>(i)}; };
    for (std::size_t i = 0; i < part_.size(); ++i) {
      const Tape::Operation& o = tape_.operations()[i];
      if (part_[i] == kUnused || part_[i] > static_cast<std::int32_t>(p)) continue;
      const bool is_known = part_[i] < static_cast<std::int32_t>(p) || o.kind == Kind::formula;
      if (is_known && is_computed(i)) {
        if (rows_[i] >= 0) values[i] = graph.load(row(Memory::work, idx(rows_[i])));
        continue;
      }
      const auto of = [&](Tape::Node n) { return n < 0 ? Value() : values[idx(n)]; };
      values[i] = o.kind == Kind::parameter ? graph.load(row(Memory::factors, idx(o.a)))
                  : o.kind == Kind::literal ? Value::set(tape_.literals()[idx(o.a)])
                                            : result(o.kind, of(o.a), of(o.b), of(o.c));
      if (rows_[i] >= 0 && !is_known) graph.store(row(Memory::work, idx(rows_[i])), values[i]);
    }
    if (p + 1 < parts_) return {{graph.phase()}, {}};
    Value off = Value::set(0);
    const auto must_be_finite = [&](const Value& x) { off = off + (x - x); };
    for (std::size_t i = 0; i < tape_.parameters(); ++i) must_be_finite(graph.load(row(Memory::factors, i)));
    std::set<std::tuple<Tape::Node, Tape::Node, bool>> known;
    for (const Tape::Guard& g : tape_.guards()) {
      if (!known.emplace(g.a, g.b, g.is_less).second) continue;
      const Value &a = values[idx(g.a)], &b = values[idx(g.b)], none = Value::set(0), one = Value::set(1);
      must_be_finite(a);
      must_be_finite(b);
      const Value is_not_less = if_at_most(b, a, one, none);
      const Value fails = g.is_less ? is_not_less : if_at_most(abs(a - b), none, none, one);
      off = off + (g.outcome ? fails : one - fails);
    }
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      must_be_finite(values[idx(wanted[i])]);
      graph.store(row(Memory::outputs, i), values[idx(wanted[i])]);
    }
    graph.store(row(Memory::figures, 0), off);
    return {{graph.phase()}, {}};
  }

 private:
  static constexpr std::int32_t kUnused = -1;

  void give_row(std::size_t node) {
    if (rows_[node] < 0) rows_[node] = count_++;
  }
  [[nodiscard]] bool is_computed(std::size_t node) const {
    const Kind kind = tape_.operations()[node].kind;
    return kind != Kind::literal && kind != Kind::parameter;
  }
  void keep_for_the_end(Tape::Node n) {
    if (idx(part_[idx(n)]) + 1 < parts_ && is_computed(idx(n))) give_row(idx(n));
  }
  [[nodiscard]] static Value result(Kind kind, const Value& a, const Value& b, const Value& c) {
    switch (kind) {
      case Kind::add:
        return a + b;
      case Kind::subtract:
        return a - b;
      case Kind::multiply:
        return a * b;
      case Kind::divide:
        return a / b;
      case Kind::negate:
        return -a;
      case Kind::fused:
        return make(Op::fma, a, b, c);
      case Kind::root:
        return sqrt(a);
      case Kind::length:
        return sqrt(a * a + b * b + c * c);
      case Kind::magnitude:
        return abs(a);
      case Kind::angle:
        return HWY_NAMESPACE::signed_angle_of(a, b);
      case Kind::parameter:
      case Kind::literal:
      case Kind::formula:
        break;
    }
    return {};
  }

  const Tape& tape_;
  std::vector<std::int32_t> part_;  // operations: formulas on the longest way to it; kUnused: nothing needs it
  std::size_t parts_ = 1;
  std::vector<std::int32_t> rows_;  // operations: row in Memory::work; -1: none
  std::int32_t count_ = 0;
};

}  // namespace

// Keeps what the wanted numbers and the guards need.
Replay::Replay(const Tape& tape, std::span<const Tape::Node> wanted, std::size_t lanes, StepCode* code)
    : w_(std::bit_ceil(lanes)), wanted_(wanted.size() * w_), off_(w_) {
  const Writer writer(tape, wanted);
  parameters_.resize(tape.parameters() * w_);
  rows_.resize(writer.rows() * w_);
  for (std::size_t p = 0; p < writer.parts(); ++p) {
    Part& part = parts_.emplace_back();
    const StepProgram program = writer.program(p, wanted);
    if (code != nullptr) part.program = code->of(program, static_cast<int>(w_));
    if (!part.program) part.program = make_interpreter(program, static_cast<int>(w_));
    writer.each_formula(p, [&](Tape::Node node, const Tape::Formula& f) {
      TextOf& text = part.formulas.emplace_back(TextOf{Formula(f.text, f.names), {}, writer.row(node)});
      for (const Tape::Node n : f.arguments) text.arguments.push_back(writer.row(n));
    });
  }
}

void Replay::run(std::span<const double* const> parameters) {
  for (std::size_t l = 0; l < w_; ++l) {
    const double* const of_lane = parameters[l < parameters.size() ? l : 0];  // idle lanes repeat the first one
    for (std::size_t i = 0; i * w_ < parameters_.size(); ++i) parameters_[i * w_ + l] = of_lane[i];
  }
  std::array<double*, kMemories> memory;
  memory[static_cast<std::size_t>(Memory::factors)] = parameters_.data();
  memory[static_cast<std::size_t>(Memory::work)] = rows_.data();
  memory[static_cast<std::size_t>(Memory::outputs)] = wanted_.data();
  memory[static_cast<std::size_t>(Memory::figures)] = off_.data();
  for (Part& part : parts_) {
    part.program->run(memory);
    for (TextOf& text : part.formulas) {
      for (std::size_t l = 0; l < parameters.size(); ++l) {
        arguments_.clear();
        for (const std::uint32_t row : text.arguments) arguments_.push_back(rows_[row * w_ + l]);
        rows_[text.row * w_ + l] = text.formula(arguments_);
      }
    }
  }
}

}  // namespace assur
