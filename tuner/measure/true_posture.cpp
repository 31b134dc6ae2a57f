#include "measure/true_posture.hpp"

#include <algorithm>
#include <cmath>

#include "verification/reference_motion.hpp"

namespace assur::measure {

struct TruePosture::Impl {
  explicit Impl(const Prepared& prepared) : motion(prepared) {}
  ReferenceMotion motion;
};

TruePosture::TruePosture(const Prepared& prepared) : impl_(std::make_unique<Impl>(prepared)) {}
TruePosture::~TruePosture() = default;

double TruePosture::error(double t, const std::vector<double>& posture, const std::vector<std::int32_t>& of) {
  ReferenceMotion& motion = impl_->motion;
  if (motion.state().time != t) motion.advance(t);
  double worst = 0;
  for (const std::int32_t c : of) {
    const auto i = static_cast<std::size_t>(c);
    const double difference = static_cast<double>(abs(Quad(posture[i]) - motion.state().q[0][i]));
    if (!(difference <= worst)) worst = difference;  // also for NaN
  }
  return worst;
}

}  // namespace assur::measure
