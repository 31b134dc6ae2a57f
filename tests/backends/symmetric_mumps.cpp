#include "backends/symmetric_mumps.hpp"

#include "backends/augmented.hpp"
#include "backends/mumps_matrix.hpp"

namespace assur::test {

const Backend* symmetric_mumps() {
  static constexpr Backend kRow = {
      .id = "symmetric_mumps",
      .why_not = [](const Shape&, ThreadBudget) { return std::string(); },
      .make = [](ThreadBudget, Precision) { return make_augmented(mumps::make_symmetric); },
      .version = [] { return std::string(MUMPS_VERSION); },
      .licence = "CECILL-C"};
  return &kRow;
}

}  // namespace assur::test
