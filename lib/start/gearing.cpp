#include "start/gearing.hpp"

#include <algorithm>
#include <cstdint>

#include "index.hpp"
#include "joints/gear.hpp"

namespace assur {
namespace {

bool counts_turns(const Callback& c) {
  if (c.teeth > 1) return true;
  const auto numbers = numbers_of(c);  // a rack and its pinion
  return numbers && numbers->is_periodic &&
         std::any_of(numbers->sides.begin(), numbers->sides.end(), [](const auto& side) { return !side.is_angle; });
}

}  // namespace

bool count_turns(const System& s) {
  return std::any_of(s.callbacks.begin(), s.callbacks.end(),
                     [](const CallbackBlock& block) { return counts_turns(*block.callback); });
}

std::vector<WalkedPart> parts_of_gears(const System& s, const std::vector<WalkedPart>& all) {
  std::vector<std::uint8_t> read(s.coordinates.size(), 0);
  std::vector<Index> mentioned;
  std::vector<WalkedPart> out;
  for (auto part = all.rbegin(); part != all.rend(); ++part) {
    const bool has_gear = std::any_of(part->equations.begin(), part->equations.end(), [&](Index e) {
      const Index callback = s.equations[idx(e)].callback;
      return callback >= 0 && counts_turns(*s.callbacks[idx(callback)].callback);
    });
    const auto is_read = [&](Index u) { return read[idx(u)] != 0; };
    if (!has_gear && std::none_of(part->unknowns.begin(), part->unknowns.end(), is_read)) continue;
    for (const Index e : part->equations) {
      s.mentioned(e, mentioned);
      for (const Index c : mentioned) read[idx(c)] = 1;
    }
    out.push_back(*part);
  }
  std::reverse(out.begin(), out.end());
  return out;
}

}  // namespace assur
