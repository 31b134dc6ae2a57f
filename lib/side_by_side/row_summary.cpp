#include "side_by_side/row_summary.hpp"

#include <cmath>

#include "numbers.hpp"

namespace assur {

void RowSummary::take(double time, const double* row) {
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const double value = row[columns_[i]];
    ColumnSummary& s = out_[i];
    if (rows_ == 0) {
      s = {value, value, time, time, value, value};
      continue;
    }
    // NaN is kept, and nothing is smaller or larger.
    if (value < s.minimum || (std::isnan(value) && !std::isnan(s.minimum))) {
      s.minimum = value;
      s.minimum_time = time;
    }
    if (value > s.maximum || (std::isnan(value) && !std::isnan(s.maximum))) {
      s.maximum = value;
      s.maximum_time = time;
    }
    s.mean += value;
    s.last = value;
  }
  ++rows_;
}

void RowSummary::finish() {
  for (ColumnSummary& s : out_) {
    if (rows_ == 0) s = {kNan, kNan, kNan, kNan, kNan, kNan};
    if (rows_ > 0) s.mean /= static_cast<double>(rows_);
  }
}

}  // namespace assur
