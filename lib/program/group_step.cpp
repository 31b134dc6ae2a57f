#include "program/group_step.hpp"

#include <type_traits>

#include "index.hpp"
#include "program/graph.hpp"
#include "program/small_group-inl.hpp"

namespace assur {
namespace {

// Places in Memory::work.
struct Layout {
  std::uint32_t n;
  [[nodiscard]] std::uint32_t unknown(std::uint32_t j) const { return j; }
  [[nodiscard]] std::uint32_t residual(std::uint32_t i) const { return n + i; }
  [[nodiscard]] std::uint32_t weight(std::uint32_t i) const { return 2 * n + i; }
  [[nodiscard]] std::uint32_t relative() const { return 3 * n; }
  [[nodiscard]] std::uint32_t active() const { return 3 * n + 1; }
  [[nodiscard]] std::uint32_t size() const { return 3 * n + 2; }
};

// The numbers of a pack as slots. A coefficient without constants of the group is part of the program.
class Slots {
 public:
  Slots(Graph& graph, const Program& program) : graph_(graph), program_(program) {}

  [[nodiscard]] Value load(Memory memory, std::size_t index) const {
    return graph_.load({memory, static_cast<std::uint32_t>(index)});
  }
  [[nodiscard]] Value coefficient(std::int32_t k) const {
    if (k == zero_coefficient(program_)) return Value::set(0);
    if (k == one_coefficient(program_)) return Value::set(1);
    const Coefficient& c = program_.coefficients[idx(k)];
    return c == Coefficient{c.literal} ? Value::set(c.literal) : load(Memory::coefficients, idx(k));
  }
  [[nodiscard]] Value input(int derivative, std::int32_t i) const {
    constexpr Memory kOf[] = {Memory::inputs, Memory::input_rates, Memory::input_accelerations};
    return load(kOf[derivative], idx(i));
  }
  [[nodiscard]] Value unknown(int j) const { return load(Memory::unknowns, idx(j)); }
  [[nodiscard]] Value pivot(std::size_t k) const { return load(Memory::pivots, k); }
  [[nodiscard]] Value anchor(std::size_t k) const { return load(Memory::anchor, k); }
  [[nodiscard]] Value omega() const { return load(Memory::omega, 0); }
  [[nodiscard]] Value setting(GroupSetting s) const { return graph_.load(slot_of(s)); }

 private:
  Graph& graph_;
  const Program& program_;
};

// Writes the phases of a SmallGroup, one after the other.
template <int N, class Equations>
class Writer {
  using Group = HWY_NAMESPACE::SmallGroup<Value, N, Equations>;

 public:
  template <class... Arguments>
  Writer(const GroupClass& group_class, const Program& program, const Arguments&... arguments)
      : group_class_(group_class), program_(program), group_(group_class, program, arguments...) {}

  [[nodiscard]] StepProgram write(std::span<const std::int32_t> reads) {
    StepProgram out;
    {
      Graph graph;
      typename Group::State s;
      group_.begin(Slots(graph, program_), s);
      keep(graph, s);
      for (std::uint32_t i = 0; i < kAt.n; ++i) graph.store(work(kAt.weight(i)), s.weight[i]);
      out.phases.push_back(graph.phase());
    }
    {
      Graph graph;
      typename Group::State s = recall(graph);
      group_.iterate(Slots(graph, program_), s);
      keep(graph, s);
      out.phases.push_back(graph.phase());
      out.phases.back().repeat_while = work(kAt.active());
    }
    Graph graph;
    typename Group::State s = recall(graph);
    typename Group::Figures figures;
    Value rate[N], acceleration[N];
    const int derivatives = group_class_.derivatives;
    group_.finish(Slots(graph, program_), derivatives, reads, s, rate, acceleration, figures);
    for (std::uint32_t j = 0; j < kAt.n; ++j) {
      graph.store({Memory::unknowns, j}, s.x[j]);
      if (derivatives > 0) graph.store({Memory::rates, j}, rate[j]);
      if (derivatives > 1) graph.store({Memory::accelerations, j}, acceleration[j]);
    }
    graph.store(slot_of(GroupFigure::failed), s.failed);
    graph.store(slot_of(GroupFigure::position), s.relative);
    graph.store(slot_of(GroupFigure::velocity), figures.velocity);
    graph.store(slot_of(GroupFigure::acceleration), figures.acceleration);
    graph.store(slot_of(GroupFigure::ball_used), figures.ball_used);
    graph.store(slot_of(GroupFigure::needs_anchor), figures.needs_anchor);
    out.phases.push_back(graph.phase());
    return out;
  }

 private:
  static Slot work(std::uint32_t index) { return {Memory::work, index}; }
  void keep(Graph& graph, const typename Group::State& s) const {
    for (std::uint32_t i = 0; i < kAt.n; ++i) {
      graph.store(work(kAt.unknown(i)), s.x[i]);
      graph.store(work(kAt.residual(i)), s.phi[i]);
    }
    graph.store(work(kAt.relative()), s.relative);
    graph.store(work(kAt.active()), s.active);
    graph.store(slot_of(GroupFigure::failed), s.failed);
    graph.store(slot_of(GroupFigure::iterations), s.iterations);
  }
  // What earlier phases kept. Equations read their inputs again, which takes hardly more than reading what they made of
  // them: unused results are not written.
  [[nodiscard]] typename Group::State recall(Graph& graph) {
    const Slots slots(graph, program_);
    group_.equations().set_inputs(slots);
    typename Group::State s;
    for (std::uint32_t i = 0; i < kAt.n; ++i) {
      s.x[i] = slots.load(Memory::work, kAt.unknown(i));
      s.phi[i] = slots.load(Memory::work, kAt.residual(i));
      s.weight[i] = slots.load(Memory::work, kAt.weight(i));
    }
    s.relative = slots.load(Memory::work, kAt.relative());
    s.active = slots.load(Memory::work, kAt.active());
    s.failed = graph.load(slot_of(GroupFigure::failed));
    s.iterations = graph.load(slot_of(GroupFigure::iterations));
    return s;
  }

  static constexpr Layout kAt{N};
  const GroupClass& group_class_;
  const Program& program_;
  Group group_;
};

template <int N>
GroupProgram write(const GroupClass& group_class, const Program& equations, std::span<const std::int32_t> reads) {
  const auto make = [&]<class E>(std::type_identity<E>, const auto&... arguments) {
    return GroupProgram{Writer<N, E>(arguments...).write(reads), Layout{N}.size()};
  };
  return HWY_NAMESPACE::with_equations<Value, N>(group_class, equations, make);
}

}  // namespace

bool has_group_step(const GroupClass& c) {
  return (c.n == 2 || c.n == 3) && c.quadratic && c.blocks == 1 && c.first_wanted == 0;
}

std::size_t pivots_of_group_step(const GroupClass& c) { return idx(c.n * (c.n - 1) / 2); }

GroupProgram group_step(const GroupClass& group_class, const Program& equations, std::span<const std::int32_t> reads) {
  return equations.n == 2 ? write<2>(group_class, equations, reads) : write<3>(group_class, equations, reads);
}

}  // namespace assur
