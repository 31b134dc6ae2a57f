#include "program/group_step.hpp"

#include <type_traits>

#include "index.hpp"
#include "program/graph.hpp"
#include "program/group_slots.hpp"
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

// GroupSlots where inputs and predicted unknowns are values of the graph.
class GivenValues : public GroupSlots {
 public:
  GivenValues(const GroupSlots& slots, const GroupBegin& begin) : GroupSlots(slots), begin_(begin) {}

  [[nodiscard]] Value input(int derivative, std::int32_t i) const {
    const Value& given = begin_.inputs[idx(i)];
    return derivative > 0 || given.is_constant() ? GroupSlots::input(derivative, i) : given;
  }
  [[nodiscard]] Value unknown(int j) const { return begin_.unknowns[idx(j)]; }

 private:
  const GroupBegin& begin_;
};

// Writes the phases of a SmallGroup, one after the other.
template <int N, class Equations>
class Writer {
  using Group = HWY_NAMESPACE::SmallGroup<Value, N, Equations>;

 public:
  template <class... Arguments>
  Writer(std::uint16_t number, const GroupClass& group_class, const Program& program, const Arguments&... arguments)
      : number_(number), group_class_(group_class), program_(program), group_(group_class, program, arguments...) {}

  [[nodiscard]] StepProgram write(std::span<const std::int32_t> reads, const GroupBegin* begin) {
    StepProgram out;
    {
      Graph own;
      Graph& graph = begin != nullptr ? begin->graph : own;
      typename Group::State s;
      if (begin != nullptr) {
        group_.begin(GivenValues(slots(graph), *begin), s);
      } else {
        group_.begin(slots(graph), s);
      }
      keep(graph, s);
      for (std::uint32_t i = 0; i < kAt.n; ++i) graph.store(work(kAt.weight(i)), s.weight[i]);
      out.phases.push_back(graph.phase());
    }
    {
      Graph graph;
      typename Group::State s = recall(graph);
      group_.iterate(slots(graph), s);
      keep(graph, s);
      out.phases.push_back(graph.phase());
      out.phases.back().repeat_while = work(kAt.active());
    }
    Graph graph;
    typename Group::State s = recall(graph);
    typename Group::Figures figures;
    Value rate[N], acceleration[N];
    const int derivatives = group_class_.derivatives;
    group_.finish(slots(graph), derivatives, reads, s, rate, acceleration, figures);
    for (std::uint32_t j = 0; j < kAt.n; ++j) {
      graph.store(slot({Memory::unknowns, j}), s.x[j]);
      if (derivatives > 0) graph.store(slot({Memory::rates, j}), rate[j]);
      if (derivatives > 1) graph.store(slot({Memory::accelerations, j}), acceleration[j]);
    }
    graph.store(slot(slot_of(GroupFigure::failed)), s.failed);
    graph.store(slot(slot_of(GroupFigure::position)), s.relative);
    graph.store(slot(slot_of(GroupFigure::velocity)), figures.velocity);
    graph.store(slot(slot_of(GroupFigure::acceleration)), figures.acceleration);
    graph.store(slot(slot_of(GroupFigure::ball_used)), figures.ball_used);
    graph.store(slot(slot_of(GroupFigure::needs_anchor)), figures.needs_anchor);
    out.phases.push_back(graph.phase());
    return out;
  }

 private:
  [[nodiscard]] Slot slot(Slot of) const {
    of.group = number_;
    return of;
  }
  [[nodiscard]] Slot work(std::uint32_t index) const { return slot({Memory::work, index}); }
  [[nodiscard]] GroupSlots slots(Graph& graph) const { return {graph, program_, number_}; }
  void keep(Graph& graph, const typename Group::State& s) const {
    for (std::uint32_t i = 0; i < kAt.n; ++i) {
      graph.store(work(kAt.unknown(i)), s.x[i]);
      graph.store(work(kAt.residual(i)), s.phi[i]);
    }
    graph.store(work(kAt.relative()), s.relative);
    graph.store(work(kAt.active()), s.active);
    graph.store(slot(slot_of(GroupFigure::failed)), s.failed);
    graph.store(slot(slot_of(GroupFigure::iterations)), s.iterations);
  }
  // What earlier phases kept. Equations read their inputs again: unused results are not written, and even sums of four
  // inputs, as for the handle ends of a hexapod, are a tenth of the operations.
  [[nodiscard]] typename Group::State recall(Graph& graph) {
    const GroupSlots of = slots(graph);
    group_.equations().set_inputs(of);
    typename Group::State s;
    for (std::uint32_t i = 0; i < kAt.n; ++i) {
      s.x[i] = of.load(Memory::work, kAt.unknown(i));
      s.phi[i] = of.load(Memory::work, kAt.residual(i));
      s.weight[i] = of.load(Memory::work, kAt.weight(i));
    }
    s.relative = of.load(Memory::work, kAt.relative());
    s.active = of.load(Memory::work, kAt.active());
    s.failed = graph.load(slot(slot_of(GroupFigure::failed)));
    s.iterations = graph.load(slot(slot_of(GroupFigure::iterations)));
    return s;
  }

  static constexpr Layout kAt{N};
  std::uint16_t number_;
  const GroupClass& group_class_;
  const Program& program_;
  Group group_;
};

template <int N>
GroupProgram write(const GroupClass& group_class, const Program& equations, std::span<const std::int32_t> reads,
                   const GroupBegin* begin) {
  const auto make = [&]<class E>(std::type_identity<E>, const auto&... arguments) {
    const std::uint16_t number = begin != nullptr ? begin->group : std::uint16_t{0};
    return GroupProgram{Writer<N, E>(number, arguments...).write(reads, begin), Layout{N}.size()};
  };
  return HWY_NAMESPACE::with_equations<Value, N>(group_class, equations, make);
}

template <int N>
StepProgram write_anchor(const GroupClass& group_class, const Program& equations, std::span<const std::int32_t> reads) {
  const auto make = [&]<class E>(std::type_identity<E>, const auto&... arguments) {
    Graph graph;
    GroupSlots io(graph, equations, std::uint16_t{0});
    HWY_NAMESPACE::SmallGroup<Value, N, E>(arguments...).renew_anchors(group_class.derivatives, reads, io);
    return StepProgram{{graph.phase()}, {}};
  };
  return HWY_NAMESPACE::with_equations<Value, N>(group_class, equations, make);
}

}  // namespace

bool has_group_step(const GroupClass& c) {
  return (c.n == 2 || c.n == 3) && c.quadratic && c.blocks == 1 && c.first_wanted == 0;
}

std::size_t pivots_of_group_step(const GroupClass& c) { return idx(c.n * (c.n - 1) / 2); }

GroupProgram group_step(const GroupClass& group_class, const Program& equations, std::span<const std::int32_t> reads,
                        const GroupBegin* begin) {
  return equations.n == 2 ? write<2>(group_class, equations, reads, begin)
                          : write<3>(group_class, equations, reads, begin);
}

StepProgram anchor_program(const GroupClass& group_class, const Program& equations,
                           std::span<const std::int32_t> reads) {
  return equations.n == 2 ? write_anchor<2>(group_class, equations, reads)
                          : write_anchor<3>(group_class, equations, reads);
}

}  // namespace assur
