#include "drivers/driver_turns.hpp"

#include <bit>
#include <cstdint>
#include <vector>

#include "drivers/drive_program.hpp"
#include "equations/own_values.hpp"
#include "index.hpp"

namespace assur {

int angles_together(const System& s, const GroupedSystem& structure) {
  std::size_t laws = 0;
  for (const DriverInput& in : s.inputs) laws += in.laws.size();
  const std::size_t words = (laws + 63) / 64;
  std::vector<std::uint64_t> behind(s.coordinates.size() * words);  // coordinates: a bit for each law
  const auto of = [&](std::int32_t c) { return std::span(behind).subspan(idx(c) * words, words); };
  const auto add = [&](std::int32_t to, std::int32_t from) {
    for (std::size_t w = 0; w < words; ++w) of(to)[w] |= of(from)[w];
  };
  std::size_t law = 0;
  for (const DriverInput& in : s.inputs) {
    for (std::size_t k = 0; k < in.laws.size(); ++k, ++law) {
      if (!is_angle(s, in, k)) continue;
      for (Index c = in.first; c < in.first + in.count; ++c) of(c)[law / 64] |= std::uint64_t{1} << (law % 64);
    }
  }
  for (const Assignment& a : s.assignments) {
    for (const Term& t : s.form(a.form)) add(a.coordinate, t.coordinate);
  }
  for (const SolvedGroup& group : structure.groups) {
    if (group.unknowns.empty()) continue;
    const std::int32_t first = group.unknowns.front();
    for (const std::int32_t c : group.inputs) add(first, c);
    for (const std::int32_t c : group.unknowns) add(c, first);
  }
  int most = 1;
  for (std::size_t c = 0; c < s.coordinates.size(); ++c) {
    int count = 0;
    for (const std::uint64_t word : of(static_cast<std::int32_t>(c))) count += std::popcount(word);
    most = std::max(most, count);
  }
  return most;
}

}  // namespace assur
