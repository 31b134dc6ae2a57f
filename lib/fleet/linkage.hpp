// A linkage, checked and ready for its kernels.
#pragma once

#include <string>
#include <vector>

#include "assur/fleet.hpp"
#include "fleet/linkage_kernels.hpp"

namespace assur {

// A squared distance that comes to its limit within this part of it, inside or outside, touches the limit: two motions
// cross.
inline constexpr double kTouches = 1e-12;

// A linkage without its traced joint; memory is kept from one linkage to the next.
class PreparedLinkage {
 public:
  // Returns what is wrong with the linkage; "": nothing, and it is ready.
  [[nodiscard]] std::string take(const Linkage& linkage);

  [[nodiscard]] std::span<const PreparedJoint> joints() const { return joints_; }
  [[nodiscard]] std::size_t traced() const { return traced_; }
  [[nodiscard]] std::int64_t dyads() const { return dyads_; }  // and triads
  [[nodiscard]] bool has_triads() const { return has_triads_; }
  [[nodiscard]] double mean_length() const { return mean_length_; }  // of cranks, dyads and triads; 1 if there are none

 private:
  std::vector<PreparedJoint> joints_;
  std::size_t traced_ = 0;
  std::int64_t dyads_ = 0;
  bool has_triads_ = false;
  double mean_length_ = 1;
};

// Lets the triads begin at the approximate posture that their linkage gives.
void begin_at_guess(std::span<const PreparedJoint> joints, JointBlock* blocks);

}  // namespace assur
