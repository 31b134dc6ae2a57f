// How far one driver can be moved from the start posture, in both directions.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "assur/scene.hpp"
#include "assur/status.hpp"

namespace assur {

// One end of a range. All values in this header are those of the driver's law, rad or m: for a relative driver and for
// a coordinate of a joint they count from the posture as written.
struct RangeEnd {
  // fold: a fold; limit_reached: a limit of the scene; ok: no end was found; any other: why the motion could
  // not go on
  Code code = Code::ok;
  // The end lies between both. The mechanism reaches `reached`; if there is no end, both are the value that was asked
  // for.
  double reached = 0, beyond = 0;
  std::string group = {};  // the group that is at its fold, or the quantity that is at its limit; "": none
};

// A limit that flags, and does not end the range.
struct PassedLimit {
  std::string quantity;  // name
  double at = 0;         // value of the driver
  bool leaves = true;    // on the way from the start posture, the quantity leaves its limit there; false: it returns
};

// The range of one driver, while all other drivers rest at their values at the start.
struct MotionRange {
  std::string driver;  // name, or value of a pose ("pose.x")
  std::string unit;    // "rad", "m", or "" for a component of a vector
  double start = 0;    // value in the start posture
  RangeEnd low, high;  // ends below and above it
  std::vector<double>
      change_points;                // values at which branches cross, and the smooth continuation was taken; ascending
  std::vector<PassedLimit> passed;  // by ascending values of the driver
};

// Moves one driver both ways from the start posture of the scene, along the branch. farthest: the longest way to each
// side, in the unit of the driver; 0: a whole turn of an angle, 10 characteristic lengths (docs/accuracy.md; each about
// the length of a part) for a length, 2 pi for a component of a vector. A fold is bracketed to about 1e-12 rad, or
// 1e-12 of the characteristic length. Throws Error: input if there is no such driver (a scene with one driver needs no
// name: ""), or for a `farthest` that is negative or not finite; and like prepare() and Simulator. Needs the library
// assur::assur.
[[nodiscard]] MotionRange motion_range(const Scene& scene, std::string_view driver = {}, double farthest = 0);

}  // namespace assur
