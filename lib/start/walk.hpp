// Follows a posture continuously while the drivers move, or while its open equations close.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "graph/blocks.hpp"
#include "numbers.hpp"

namespace assur {

// The values of all drivers, [input][law].
using DriverValues = std::vector<std::vector<double>>;

// Unknowns that are solved together. More equations than unknowns depend on each other, and hold as well as they can:
// the sum of their squares is least.
struct WalkedPart {
  std::vector<Index> equations, unknowns;
  bool is_needed = true;  // false: if it cannot be followed, it and the parts that read it are left behind
};

// Whatever moves while s goes from 0 to 1.
struct WalkPath {
  DriverValues from, change;  // the drivers have the values from + s * change
  std::vector<double> open;   // [equation of the system]: its residual is (1 - s) times this; empty: 0
  bool passes = true;         // false: a change point ends the walk
};

// How far the known coordinates may leave their chords while the drivers go this share of the way: h^2 / 8 times the
// second derivative. off: coordinates, of which those of inputs and assignments are set.
void set_strays(const System& system, const WalkPath& way, double share, std::vector<double>& off);

// False if a driver that moves has not its value at q any more, because its direction has vanished.
[[nodiscard]] bool drivers_hold(const System& system, const WalkPath& way, const std::vector<double>& q,
                                Index* driver = nullptr);  // driver: receives this one

// The end of a walk.
struct Walked {
  enum class End : std::uint8_t {
    arrived,
    singular,  // the Jacobian of `part` is singular there
    vanished,  // the direction, the distance or the lever of `driver` vanishes there
    too_long,  // the way has more than kMostWalkedSteps steps, or is bound to
  };
  End end = End::arrived;
  double share = 0;      // s of the last posture
  std::size_t part = 0;  // singular: index of the part
  Index driver = -1;     // vanished: index into System::drivers
  struct ChangePoint {
    double share;
    std::size_t part;
  };
  std::vector<ChangePoint> passed;  // change points, by the smooth continuation
  std::vector<std::size_t> left;    // parts that were left behind
  int steps = 0;                    // attempts
};

// A choice. Measured: 5,000 steps of a slider-crank take 0.14 s, those of two gear wheels 0.3 s.
inline constexpr int kMostWalkedSteps = 100000;

// The rules of a step, here and in lanes (program/walk_step.hpp).
struct WalkRules {
  static constexpr int kMostCorrections = 10;    // of Newton's method; a choice
  static constexpr double kCorrected = 1e-10;    // internal units; Newton's next correction is far below rounding
  static constexpr double kRoundingOnly = 1e-6;  // corrections below this that no longer fall are rounding
  // Largest first correction behind a change point over the move. A choice: on another branch the correction would be
  // about as large as the move.
  static constexpr double kSureOfBranch = 1e-3;
  static constexpr double kSurest = 0.8;  // of the bound of the test that proves a step
  // Length of the next step over that of this one, for the part of the bound that it used.
  [[nodiscard]] static double after_success(double used) { return std::clamp(0.5 / std::max(used, kEps), 0.3, 2.5); }
  [[nodiscard]] static double after_failure(double used) { return std::clamp(0.5 / used, 0.09, 0.5); }
};

// Moves q along the way, from a posture at s = 0. `parts` are in solving order. Each step is proven: for all s of the
// step, each part has exactly one posture within a ball around the chord of the step, so that the posture at the end
// is the continuation of the one at the beginning. (The chord's residuals are known, because the equations are
// quadratic; Newton-Kantorovich, see groups/newton_kantorovich.hpp. For functions of the program the bounds are
// measured, not proven, and so is the distance of earlier parts from their chords.) q is the last posture that was
// reached.
[[nodiscard]] Walked walk(const System& system, const std::vector<WalkedPart>& parts, const WalkPath& way,
                          std::vector<double>& q);

}  // namespace assur
