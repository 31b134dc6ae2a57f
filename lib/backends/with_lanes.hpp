// Loops over the lanes of vectors, for numbers of lanes that are known at run time.
#pragma once

#include <cstddef>
#include <type_traits>

namespace assur {

template <std::size_t W>
using Constant = std::integral_constant<std::size_t, W>;

// Calls visit(lanes) with the number of lanes as a constant for the usual numbers, so that inner loops vectorise.
template <typename Visit>
void with_lanes(std::size_t lanes, const Visit& visit) {
  switch (lanes) {
    case 1:
      return visit(Constant<1>{});
    case 2:
      return visit(Constant<2>{});
    case 4:
      return visit(Constant<4>{});
    case 8:
      return visit(Constant<8>{});
    case 16:
      return visit(Constant<16>{});
    default:
      return visit(lanes);
  }
}

}  // namespace assur
