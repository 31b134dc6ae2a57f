// Used instead of certificate.cpp if Boost is not installed.
#include "assur/simulator.hpp"

namespace assur {
namespace {

[[noreturn]] void refuse() {
  throw Error(Error::Kind::environment,
              "a certificate needs quad precision, which this build lacks: install Boost.Multiprecision (Debian: apt "
              "install libboost-dev) and build assur again");
}

}  // namespace

Certificate certify(const Simulator&) { refuse(); }

std::vector<Certificate> certify(const Prepared&, const Trajectory&, StepSettings) { refuse(); }

}  // namespace assur
