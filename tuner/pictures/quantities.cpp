#include "pictures/quantities.hpp"

#include <algorithm>
#include <array>

#include "equations/outputs.hpp"
#include "structure/grouped_system.hpp"

namespace assur::pictures {
namespace {

std::string unit_of(const OutputPart& part, std::size_t derivative) {
  static constexpr std::array kPerTime = {"", "/s", "/s²"};
  std::string unit = is_angle(part.kind) ? "rad" : part.dimension == 1 ? "m" : part.dimension == 2 ? "m²" : "";
  if (unit.empty() && derivative > 0) unit = "1";
  return unit + kPerTime[derivative];
}

std::string title_of(const Output& output, std::size_t derivative) {
  static constexpr std::array kOfScalar = {"", ", rate", ", acceleration"};
  static constexpr std::array kOfPoint = {"", ", velocity", ", acceleration"};
  const std::string name(output.name);
  if (output.component >= 0) return name + "." + "xyz"[output.component] + kOfPoint[derivative];
  return name + (output.part_count == 1 ? kOfScalar : kOfPoint)[derivative];
}

}  // namespace

std::vector<Quantity> quantities(const Structure& of) {
  const GroupedSystem& structure = GroupedSystem::of(of);
  std::vector<Quantity> all;
  std::size_t column = 0;
  for (const Output& o : wanted_outputs(*structure.system)) {
    for (std::size_t d = 0; d < 3; ++d) {
      if (!o.wanted[d]) continue;
      Quantity& q = all.emplace_back(Quantity{std::string(o.name), title_of(o, d), unit_of(o.parts().front(), d), {}});
      for (std::size_t k = 0; k < o.part_count; ++k) q.columns.push_back(column++);
    }
  }
  if (structure.system->outputs.empty()) {
    std::stable_partition(all.begin(), all.end(), [](const Quantity& q) { return q.columns.size() == 1; });
  }
  return all;
}

}  // namespace assur::pictures
