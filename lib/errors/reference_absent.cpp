// Stands in for reference.cpp where Boost is not installed.
#include "assur/simulator.hpp"

namespace assur {

ForwardError forward_error(const Prepared&, const Trajectory&) {
  throw Error(Error::Kind::environment,
              "the reference needs quad precision, and this build has none: install Boost.Multiprecision (Debian: apt "
              "install libboost-dev) and build assur again");
}

}  // namespace assur
