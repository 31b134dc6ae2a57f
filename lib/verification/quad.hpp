// Quadruple precision: 113 bits.
#pragma once

#include <boost/multiprecision/cpp_bin_float.hpp>

namespace assur {

using Quad = boost::multiprecision::cpp_bin_float_quad;

}  // namespace assur
