// Used instead of reference.cpp if Boost is not installed.
#include "assur/simulator.hpp"

namespace assur {

ForwardError forward_error(const Prepared&, const Trajectory&) {
  throw Error(Error::Kind::environment,
              "the reference needs quad precision, which this build lacks: install Boost.Multiprecision (Debian: apt "
              "install libboost-dev) and build assur again");
}

}  // namespace assur
