// Which events put the branch of a motion in doubt.
#pragma once

#include "assur/report.hpp"

namespace assur::check {

// True if another branch may have been taken from this event on.
[[nodiscard]] inline bool doubts_branch(const Event& event) {
  return event.kind != Code::inaccurate && event.kind != Code::near_singular;
}

}  // namespace assur::check
