// The numbers of groups as slots of a program: what the texts of their steps call a Source.
#pragma once

#include <cstddef>
#include <cstdint>

#include "evaluation/coefficients.hpp"
#include "index.hpp"
#include "program/group_step.hpp"
#include "program/step_graph.hpp"
#include "program/step_program.hpp"

namespace assur {

// A coefficient without constants of the group is part of the program.
class GroupSlots {
 public:
  // Of a pack: rows of its lanes.
  GroupSlots(Graph& graph, const GroupClass& group_class, std::uint16_t group)
      : graph_(graph), class_(group_class), group_(group) {}
  // Of a class: number k of the group in lane l at [k stride + l].
  GroupSlots(Graph& graph, const GroupClass& group_class, std::size_t stride, Reach reach)
      : graph_(graph), class_(group_class), stride_(stride), reach_(reach) {}

  [[nodiscard]] Slot slot(Memory memory, std::size_t index) const {
    return {memory, static_cast<std::uint32_t>(index * stride_), reach_, group_};
  }
  [[nodiscard]] Value load(Memory memory, std::size_t index) const { return graph_.load(slot(memory, index)); }
  void store(Memory memory, std::size_t index, const Value& value) { graph_.store(slot(memory, index), value); }

  [[nodiscard]] Value coefficient(std::int32_t k) const {
    if (k == zero_coefficient(class_)) return Value::set(0);
    if (k == one_coefficient(class_)) return Value::set(1);
    const GroupClass::Coefficient& c = class_.coefficients[idx(k)];
    return c == GroupClass::Coefficient{c.literal} ? Value::set(c.literal) : load(Memory::coefficients, idx(k));
  }
  [[nodiscard]] Value input(int derivative, std::int32_t i) const {
    constexpr Memory kOf[] = {Memory::inputs, Memory::input_rates, Memory::input_accelerations};
    return load(kOf[derivative], idx(i));
  }
  [[nodiscard]] Value unknown(int j) const { return load(Memory::unknowns, idx(j)); }
  [[nodiscard]] Value anchor(std::size_t k) const { return load(Memory::anchor, k); }
  [[nodiscard]] Value omega() const { return load(Memory::omega, 0); }
  [[nodiscard]] Value ball_used() const { return load(Memory::ball_used, 0); }
  [[nodiscard]] Value setting(GroupSetting s) const {
    Slot of = slot_of(s);
    of.group = group_;
    return graph_.load(of);
  }

 private:
  Graph& graph_;
  const GroupClass& class_;
  std::size_t stride_ = 1;
  Reach reach_ = Reach::row;
  std::uint16_t group_ = 0;
};

}  // namespace assur
