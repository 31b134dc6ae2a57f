#include "backends/symmetric_mumps.hpp"

#include "backends/augmented.hpp"
#include "backends/mumps_matrix.hpp"

namespace assur::test {

const Backend* symmetric_mumps() {
  static constexpr Backend kRow = {"symmetric_mumps",
                                   [](const Shape&, ThreadBudget) { return std::string(); },
                                   [](ThreadBudget, Precision) { return make_augmented(mumps::make_symmetric); },
                                   false,
                                   false,
                                   false,
                                   "CECILL-C",
                                   [] { return std::string(MUMPS_VERSION); }};
  return &kRow;
}

}  // namespace assur::test
