#include "executors/places.hpp"

namespace assur {

Places places_of(const Phase& phase) {
  const std::size_t count = phase.code.size();
  std::vector<std::size_t> last(count, 0);  // use
  for (std::size_t i = 0; i < count; ++i) {
    const Instruction& n = phase.code[i];
    for (std::size_t k = 0; k < static_cast<std::size_t>(operands_of(n.op)); ++k) last[n.operand[k]] = i;
  }
  for (const Phase::Store& s : phase.stores) last[s.value] = count;

  Places out;
  out.of.resize(count);
  std::vector<std::uint32_t> free;
  for (std::size_t i = 0; i < count; ++i) {
    if (free.empty()) free.push_back(static_cast<std::uint32_t>(out.count++));
    out.of[i] = free.back();
    free.pop_back();
    const Instruction& n = phase.code[i];
    for (std::size_t k = 0; k < static_cast<std::size_t>(operands_of(n.op)); ++k) {
      const std::uint32_t of = n.operand[k];
      if (last[of] != i) continue;
      free.push_back(out.of[of]);
      last[of] = count + 1;  // an operand may occur twice
    }
  }
  return out;
}

}  // namespace assur
