// The axes of a frame in a posture.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "equations/system.hpp"
#include "scene/triple.hpp"

namespace assur {

inline constexpr double kSkew = 1e-6;  // error of a frame's axes; a scene may give them with seven digits

struct FrameAxes {
  bool mirrored = false;  // left-handed
  double skew = 0;        // largest error of a length, a right angle, or the third axis
};

// q: all coordinates.
inline FrameAxes frame_axes(const System& s, const Frame& frame, std::span<const double> q) {
  Triple a[3];
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t k = 0; k < 3; ++k) a[j][k] = form_value<double>(s, s.items[idx(frame.item[j])].form[k], q);
  }
  const Triple off = triple::subtract(triple::cross(a[0], a[1]), a[2]);
  return {!(triple::dot(triple::cross(a[0], a[1]), a[2]) > 0),
          std::max({triple::norm(off), abs(triple::dot(a[0], a[1])), abs(triple::norm(a[0]) - 1),
                    abs(triple::norm(a[1]) - 1)})};
}

}  // namespace assur
