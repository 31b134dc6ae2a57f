#include "program/together_step.hpp"

#include "program/graph.hpp"
#include "program/group_slots.hpp"
#include "program/together_group-inl.hpp"

namespace assur {
namespace {

template <int N>
StepProgram write(TogetherPass pass, const GroupClass& group_class, std::span<const std::int32_t> reads,
                  const Slopes& slopes, const TogetherShape& shape) {
  return HWY_NAMESPACE::with_together_group<Value, N>(
      group_class, [&]<class Group>(std::type_identity<Group>, const Separable& separable) {
        Graph graph;
        GroupSlots io(graph, group_class, shape.stride, Reach::from);
        Group(reads, slopes, group_class, separable).run(pass, io);
        StepProgram out{{graph.phase()}, {}};
        out.phases[0].lanes = shape.lanes_of(pass);
        return out;
      });
}

}  // namespace

std::size_t work_of_together_step(const GroupClass& c) {
  return c.n == 2 ? HWY_NAMESPACE::work_of_together_group<2>() : HWY_NAMESPACE::work_of_together_group<3>();
}

StepProgram together_program(TogetherPass pass, const GroupClass& group_class, std::span<const std::int32_t> reads,
                             const Slopes& slopes, const TogetherShape& shape) {
  return group_class.n == 2 ? write<2>(pass, group_class, reads, slopes, shape)
                            : write<3>(pass, group_class, reads, slopes, shape);
}

}  // namespace assur
