// Rows, poses and Jacobian matrices as objects of Eigen 3, which only the program needs that includes this header. It
// is not part of assur.hpp.
#pragma once

#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <span>

#include "assur/jacobian.hpp"
#include "assur/rows.hpp"

namespace assur {

// Shows numbers as a vector; valid as long as they are.
[[nodiscard]] inline Eigen::Map<const Eigen::VectorXd> as_vector(std::span<const double> numbers) {
  return {numbers.data(), static_cast<Eigen::Index>(numbers.size())};
}

// The pose of a body in a row: ground coordinates = pose * coordinates in the frame of the body. In the plane z = 0.
[[nodiscard]] inline Eigen::Isometry3d pose(const BodyHandle& body, std::span<const double> row) {
  Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
  const std::span<const double> at = body.origin.value(row), q = body.quaternion.value(row);
  for (std::size_t k = 0; k < at.size(); ++k) out.translation()[static_cast<Eigen::Index>(k)] = at[k];
  if (q.size() == 4) {
    out.linear() = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
  } else {
    out.linear() = Eigen::AngleAxisd(body.turn.value(row)[0], Eigen::Vector3d::UnitZ()).toRotationMatrix();
  }
  return out;
}

// Shows the Jacobian of outputs as a matrix, outputs x drivers; valid as long as the Jacobian is.
using OutputJacobianMap = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;
[[nodiscard]] inline OutputJacobianMap as_matrix(const OutputJacobian& jacobian) {
  return {jacobian.values.data(), static_cast<Eigen::Index>(jacobian.outputs.size()),
          static_cast<Eigen::Index>(jacobian.drivers.size())};
}

// Shows the Jacobian of the constraints as a sparse matrix; valid as long as the Jacobian is.
[[nodiscard]] inline Eigen::Map<const Eigen::SparseMatrix<double>> as_matrix(const ConstraintJacobian& jacobian) {
  return {static_cast<Eigen::Index>(jacobian.equations.size()),
          static_cast<Eigen::Index>(jacobian.unknowns.size()),
          static_cast<Eigen::Index>(jacobian.values.size()),
          jacobian.column_start.data(),
          jacobian.row.data(),
          jacobian.values.data()};
}

}  // namespace assur
