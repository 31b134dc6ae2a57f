// Jacobian matrices of a posture: of outputs with respect to drivers, and of the constraints.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "assur/status.hpp"

namespace assur {

// Derivatives of outputs with respect to controlled drivers (Simulator::jacobian()). With the values u of the drivers
// and the outputs x, x' = J u' while all other drivers rest. In SI units: m, m/rad, rad/m, ...
struct OutputJacobian {
  // The outputs: one row for each component, under the name of its value ("C.x"), or of its first wanted derivative if
  // the value is not among the columns ("B.wx"); further derivatives have no row. So the rows of "B.origin" and
  // "B.angular_velocity" are the twist.
  std::vector<std::string> outputs;
  std::vector<std::string> drivers;  // the controlled drivers, in the order of Simulator::drivers()
  std::vector<double> values;        // outputs x drivers; NaN if the status is not ok
  // The smallest of the singular values of J, whose number is the smaller one of rows and columns: 0 where the drivers
  // cannot move the outputs independently of each other. Rows and columns of other units change it, so compare it for
  // outputs of one unit. NaN if J is empty or the status is not ok.
  double smallest_singular_value = std::numeric_limits<double>::quiet_NaN();
  Status status;  // ok, or singular with the group whose equations have no unique velocities

  // The derivative of outputs[output] with respect to drivers[driver]. Indices are not checked.
  [[nodiscard]] double operator()(std::size_t output, std::size_t driver) const {
    return values[output * drivers.size() + driver];
  }
};

// The derivatives dPhi/dq of the equations that are solved, by their unknowns (Simulator::constraint_jacobian()),
// sparse by columns. Derivatives are by unknowns in SI units. The factor of a row is that of its equation in
// docs/method.md, where lengths count in a unit of 2^k m if the library cannot tell the dimension of the equation:
// factors of rows have no effect on null space, rank or solutions.
struct ConstraintJacobian {
  std::vector<std::string> equations;      // rows: names of constraints, drivers and bodies, which may repeat
  std::vector<std::string> unknowns;       // columns: "C.x", "slider.lambda", ...
  std::vector<std::int32_t> column_start;  // unknowns + 1: index into `row` and `values`
  std::vector<std::int32_t> row;           // ascending in each column
  std::vector<double> values;
};

}  // namespace assur
