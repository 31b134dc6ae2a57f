// A nearly singular posture that a step passes without an event of another kind.
#pragma once

#include <algorithm>

#include "assur/status.hpp"
#include "motion/event_log.hpp"

namespace assur {

// Watches the bends of the postures of one step: the second derivatives of the unknowns by the drivers. At a nearly
// singular posture they are large, and much smaller at both ends of the step.
class NearPass {
 public:
  // The step is divided for the first time, at its first posture with this bend.
  void begin(double bend) { at_ends_ = bend; }
  // An attempt failed in this group.
  void fail(Place group) { failed_ = group; }
  // A part of the step from one time to another arrived at a posture with this bend.
  void see(double bend, double from, double until) {
    if (bend > peak_) peak_ = bend, from_ = from, until_ = until;
  }
  // Another event reports the posture that was passed.
  void explain() { explained_ = true; }

  // False: no bend at the end of the step can make it a near pass.
  [[nodiscard]] bool is_possible() const { return peak_ >= kBends && !explained_; }
  // bend: that of the last posture of the step.
  [[nodiscard]] bool is_passed(double bend) const {
    return is_possible() && peak_ >= kOfEnds * std::max(at_ends_, bend);
  }
  [[nodiscard]] Noticed event() const { return {from_, until_, failed_, Code::near_singular, peak_}; }

 private:
  static constexpr double kBends = 1000, kOfEnds = 16;  // regular mechanisms have bends of 1 to 10

  double at_ends_ = 0, peak_ = 0, from_ = 0, until_ = 0;
  Place failed_;
  bool explained_ = false;
};

}  // namespace assur
