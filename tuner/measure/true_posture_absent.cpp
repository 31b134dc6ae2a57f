// Replaces true_posture.cpp if Boost is not installed.
#include "assur/status.hpp"
#include "measure/true_posture.hpp"

namespace assur::measure {

struct TruePosture::Impl {};

TruePosture::TruePosture(const Prepared&) {
  throw Error(Error::Kind::environment,
              "true errors need quadruple precision, which this build lacks: install Boost.Multiprecision (Debian: apt "
              "install libboost-dev) and build assur again");
}
TruePosture::~TruePosture() = default;

double TruePosture::error(double, const std::vector<double>&, const std::vector<std::int32_t>&) { return 0; }

}  // namespace assur::measure
