// Summaries of columns, row after row, so that no row is stored.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "assur/ensemble.hpp"

namespace assur {

// Summarises some columns of one run.
class RowSummary {
 public:
  // columns: indices; `out` has one summary for each. Both must outlive this object.
  RowSummary(std::span<const std::size_t> columns, std::span<ColumnSummary> out) : columns_(columns), out_(out) {}

  // Takes the next row of the run: all its columns.
  void take(double time, const double* row);
  // After the last row.
  void finish();

 private:
  std::span<const std::size_t> columns_;
  std::span<ColumnSummary> out_;
  std::int64_t rows_ = 0;
};

}  // namespace assur
