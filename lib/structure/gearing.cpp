#include "structure/gearing.hpp"

#include <algorithm>
#include <cmath>

#include "index.hpp"
#include "scene/gear.hpp"

namespace assur {
namespace {

// The largest angle for each metre; 0: the equation mentions no displacement, or is not periodic.
double angle_per_metre(const Callback& c) {
  const auto numbers = numbers_of(c);
  double most = 0;
  if (!numbers || !numbers->is_periodic) return most;
  for (const GearNumbers::Side& side : numbers->sides) {
    if (!side.is_angle) most = std::max(most, std::abs(side.factor));
  }
  return most;
}

bool counts_turns(const Callback& c) { return c.teeth > 1 || angle_per_metre(c) > 0; }

}  // namespace

Gearing gearing(const System& s) {
  Gearing out{false, s.teeth, 0};
  for (const CallbackBlock& block : s.callbacks) {
    out.count_turns = out.count_turns || counts_turns(*block.callback);
    out.per_metre = std::max(out.per_metre, angle_per_metre(*block.callback));
  }
  return out;
}

Blocks blocks_of_gears(const System& s, const Blocks& all) {
  const auto has_gear = [&](Index b) {
    const auto equations = all.equations_of(b);
    return std::any_of(equations.begin(), equations.end(), [&](Index e) {
      const Index callback = s.equations[idx(e)].callback;
      return callback >= 0 && counts_turns(*s.callbacks[idx(callback)].callback);
    });
  };
  std::vector<bool> wanted(idx(all.size()), false);
  for (Index b = all.size() - 1; b >= 0; --b) {
    if (!wanted[idx(b)] && !has_gear(b)) continue;
    wanted[idx(b)] = true;
    for (const Index needed : all.needs_of(b)) wanted[idx(needed)] = true;
  }
  Blocks out;
  for (Index b = 0; b < all.size(); ++b) {
    if (!wanted[idx(b)]) continue;
    const auto equations = all.equations_of(b), unknowns = all.unknowns_of(b);
    out.equations.insert(out.equations.end(), equations.begin(), equations.end());
    out.unknowns.insert(out.unknowns.end(), unknowns.begin(), unknowns.end());
    out.start.push_back(static_cast<Index>(out.unknowns.size()));
  }
  return out;
}

}  // namespace assur
