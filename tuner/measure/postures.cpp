#include "measure/postures.hpp"

#include "equations/system.hpp"

namespace assur::measure {
namespace {

std::vector<double> gather(const std::vector<std::int32_t>& places, const std::vector<double>& from) {
  std::vector<double> out;
  out.reserve(places.size());
  for (const std::int32_t place : places) out.push_back(from[static_cast<std::size_t>(place)]);
  return out;
}

}  // namespace

Posture posture(const GroupedSystem& structure, const GroupClass& group_class, const SolvedGroup& group) {
  Posture out{std::vector<double>(group_class.coefficients.size()), gather(group.inputs, structure.start),
              gather(group.unknowns, structure.start)};
  const std::vector<double> constants = gather(group.constants, structure.system->constants);
  bind_coefficients(group_class, constants.data(), out.coefficients.data(), 1);
  return out;
}

}  // namespace assur::measure
