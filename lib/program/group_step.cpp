#include "program/group_step.hpp"

#include <algorithm>

#include "index.hpp"
#include "program/group_slots.hpp"
#include "program/needs.hpp"
#include "program/small_group-inl.hpp"
#include "program/step_graph.hpp"

namespace assur {
namespace {

// Places in Memory::work. active: 1 as long as the lane iterates; is_open: 1 if the first phase left it so, or rough.
struct Layout {
  std::uint32_t n;
  [[nodiscard]] std::uint32_t unknown(std::uint32_t j) const { return j; }
  [[nodiscard]] std::uint32_t residual(std::uint32_t i) const { return n + i; }
  [[nodiscard]] std::uint32_t weight(std::uint32_t i) const { return 2 * n + i; }
  [[nodiscard]] std::uint32_t relative() const { return 3 * n; }
  [[nodiscard]] std::uint32_t active() const { return 3 * n + 1; }
  [[nodiscard]] std::uint32_t failed() const { return 3 * n + 2; }
  [[nodiscard]] std::uint32_t is_open() const { return 3 * n + 3; }
  [[nodiscard]] std::uint32_t last() const { return 3 * n + 4; }
  [[nodiscard]] std::uint32_t size() const { return 3 * n + 5; }
};

// GroupSlots where inputs and predicted unknowns are values of the graph.
class GivenValues : public GroupSlots {
 public:
  GivenValues(const GroupSlots& slots, const GroupBegin& begin) : GroupSlots(slots), begin_(begin) {}

  [[nodiscard]] Value input(int derivative, std::int32_t i) const {
    const Value& given = begin_.inputs[idx(derivative)][idx(i)];
    return given.is_constant() ? GroupSlots::input(derivative, i) : given;
  }
  [[nodiscard]] Value unknown(int j) const { return begin_.unknowns[idx(j)]; }

 private:
  const GroupBegin& begin_;
};

// Writes the phases of a SmallGroup. Most steps take one correction. So the first phase begins, corrects once and
// finishes, all in registers; lanes that are not solved then iterate and finish in phases of their own.
template <int N>
class GroupWriter {
  using Group = HWY_NAMESPACE::SmallGroup<Value, N>;
  using State = typename Group::State;

 public:
  GroupWriter(std::uint16_t number, std::span<const std::int32_t> reads, const GroupClass& group_class)
      : number_(number), reads_(reads), group_class_(group_class), group_(group_class) {}

  [[nodiscard]] StepProgram write(const GroupBegin* begin) {
    StepProgram out;
    if (begin != nullptr) {
      write_first(begin->graph, GivenValues(slots(begin->graph), *begin), out);
    } else {
      Graph graph;
      write_first(graph, slots(graph), out);
    }
    {
      Graph graph;
      State s = recall(graph);
      group_.iterate(slots(graph), s);
      keep(graph, s);
      out.phases.push_back(graph.phase());
      out.phases.back().repeat_while = work(kAt.active());
    }
    Graph graph;
    State s = recall(graph);
    finish<true>(graph, slots(graph), s);
    graph.store(work(kAt.is_open()), Value::set(0));
    out.phases.push_back(graph.phase());
    out.phases.back().repeat_while = work(kAt.is_open());
    return out;
  }

 private:
  template <class Source>
  void write_first(Graph& graph, const Source& in, StepProgram& out) {
    State s;
    group_.begin(in, s);
    group_.iterate(in, s);
    keep(graph, s);
    for (std::uint32_t i = 0; i < kAt.n; ++i) graph.store(work(kAt.weight(i)), s.weight[i]);
    // Lanes that are not solved keep their prediction, like those that fail.
    const Value active = s.active;
    s.failed = s.failed + active;
    const Value rough = finish<false>(graph, in, s);
    graph.store(work(kAt.is_open()), if_at_most(active + rough, Value::set(0), Value::set(0), Value::set(1)));
    out.phases.push_back(graph.phase());
  }
  template <bool kRefine, class Source>
  Value finish(Graph& graph, const Source& in, State& s) {
    typename Group::Figures figures;
    Value rate[N], acceleration[N];
    const int derivatives = group_class_.derivatives;
    group_.template finish<kRefine>(in, derivatives, reads_, s, rate, acceleration, figures);
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
    return figures.rough;
  }

  [[nodiscard]] Slot slot(Slot of) const {
    of.group = number_;
    return of;
  }
  [[nodiscard]] Slot work(std::uint32_t index) const { return slot({Memory::work, index}); }
  [[nodiscard]] GroupSlots slots(Graph& graph) const { return {graph, group_class_, number_}; }
  void keep(Graph& graph, const State& s) const {
    for (std::uint32_t i = 0; i < kAt.n; ++i) {
      graph.store(work(kAt.unknown(i)), s.x[i]);
      graph.store(work(kAt.residual(i)), s.phi[i]);
    }
    graph.store(work(kAt.relative()), s.relative);
    graph.store(work(kAt.active()), s.active);
    graph.store(work(kAt.failed()), s.failed);
    graph.store(slot(slot_of(GroupFigure::iterations)), s.iterations);
    if (!group_class_.gears.empty()) graph.store(work(kAt.last()), s.last);
  }
  // What earlier phases kept. Equations read their inputs again: unused results are not written, and even sums of four
  // inputs, as for the handle ends of a hexapod, are a tenth of the operations.
  [[nodiscard]] State recall(Graph& graph) {
    const GroupSlots of = slots(graph);
    group_.equations().set_inputs(of);
    State s;
    for (std::uint32_t i = 0; i < kAt.n; ++i) {
      s.x[i] = of.load(Memory::work, kAt.unknown(i));
      s.phi[i] = of.load(Memory::work, kAt.residual(i));
      s.weight[i] = of.load(Memory::work, kAt.weight(i));
    }
    s.relative = of.load(Memory::work, kAt.relative());
    s.active = of.load(Memory::work, kAt.active());
    s.failed = of.load(Memory::work, kAt.failed());
    s.iterations = graph.load(slot(slot_of(GroupFigure::iterations)));
    s.last = group_class_.gears.empty() ? Value::set(0) : of.load(Memory::work, kAt.last());
    return s;
  }

  static constexpr Layout kAt{N};
  std::uint16_t number_;
  std::span<const std::int32_t> reads_;
  const GroupClass& group_class_;
  Group group_;
};

template <int N>
GroupProgram write(const GroupClass& group_class, std::span<const std::int32_t> reads, const GroupBegin* begin) {
  const std::uint16_t number = begin != nullptr ? begin->group : std::uint16_t{0};
  return {GroupWriter<N>(number, reads, group_class).write(begin), Layout{N}.size()};
}

template <int N>
StepProgram write_anchor(const GroupClass& group_class, std::span<const std::int32_t> reads) {
  Graph graph;
  GroupSlots io(graph, group_class, std::uint16_t{0});
  HWY_NAMESPACE::SmallGroup<Value, N>(group_class).renew_anchors(group_class.derivatives, reads, io);
  return {{graph.phase()}, {}};
}

}  // namespace

bool has_group_step(const GroupClass& c) {
  return (c.n == 2 || c.n == 3) && can_take(Path::step_program, needs_of(c)) && c.blocks == 1 && c.first_wanted == 0;
}

GroupProgram group_step(const GroupClass& group_class, std::span<const std::int32_t> reads, const GroupBegin* begin) {
  return group_class.n == 2 ? write<2>(group_class, reads, begin) : write<3>(group_class, reads, begin);
}

StepProgram anchor_program(const GroupClass& group_class, std::span<const std::int32_t> reads) {
  return group_class.n == 2 ? write_anchor<2>(group_class, reads) : write_anchor<3>(group_class, reads);
}

}  // namespace assur
