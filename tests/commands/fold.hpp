// A mechanism that reaches a limit during its run.
#pragma once

#include <cmath>

namespace assur {

// The crank turns until coupler and rocker are in line: |B - D| = 2 at cos theta = 1/4.
inline constexpr const char* kFold = R"({
  "assur": 1, "name": "fold", "dimension": 2,
  "points": {"A": {"at": [0, 0], "fixed": true}, "D": {"at": [2, 0], "fixed": true},
             "B": {"at": [1, 0]}, "C": {"at": [1.5, 0.8]}},
  "constraints": {"coupler": {"distance": ["B", "C"], "value": 1}, "rocker": {"distance": ["D", "C"], "value": 1}},
  "drivers": {"motor": {"angle": ["A", "B"], "law": {"polynomial": [0, 1]}}},
  "time": {"start": 0, "end": 2, "step": 0.01}
})";
inline const double kFoldTime = std::acos(0.25);

}  // namespace assur
