// The way from the posture as written to the start: the posture is closed, then the drivers move to their laws.
#pragma once

#include <span>
#include <vector>

#include "start/walk.hpp"

namespace assur {

// The way of the drivers from their values in the posture as written to those of the laws, which q has at `time`.
// Coordinates of joints count whole turns; other angles turn the shorter way, and half a turn is positive. A driver
// without a value in the posture as written has that of its law at once.
[[nodiscard]] WalkPath way_to_laws(const System& system, std::span<const double> q, double time);

// True if a driver moves on this way. False if a law has no finite value.
[[nodiscard]] bool is_moving(const System& system, const WalkPath& way);

// The way that closes q with the drivers held: the residuals shrink in proportion. Nothing is open: q is closed.
[[nodiscard]] WalkPath closing_way(const System& system, const std::vector<WalkedPart>& parts,
                                   const std::vector<double>& q);

// Closes q, by this way if it is far from being closed. False, with q unchanged, if a singular posture is on the way.
[[nodiscard]] bool close(const System& system, const std::vector<WalkedPart>& parts, std::vector<double>& q);

}  // namespace assur
