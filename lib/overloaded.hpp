// One function object of several, for std::visit: an alternative that none of them takes does not compile.
#pragma once

namespace assur {

template <class... Functions>
struct Overloaded : Functions... {
  using Functions::operator()...;
};
template <class... Functions>
Overloaded(Functions...) -> Overloaded<Functions...>;

}  // namespace assur
