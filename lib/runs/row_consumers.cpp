#include "runs/row_consumers.hpp"

#include <algorithm>
#include <cmath>

#include "numbers.hpp"
#include "outputs/columns.hpp"

namespace assur {

std::vector<std::size_t> indices_of(const std::vector<std::string>& columns, const std::vector<std::string>& all) {
  std::vector<std::size_t> indices;
  for (const std::string& column : columns) indices.push_back(column_index(all, column));
  return indices;
}

std::vector<std::size_t> selected(const RowSelection& selection, const RowSink& sink,
                                  const std::vector<std::string>& all) {
  if (!sink) throw Error(Error::Kind::input, "the sink of rows is empty");
  if (selection.every < 1 || selection.block < 1) {
    throw Error(Error::Kind::input, "RowSelection::every and RowSelection::block must be at least 1");
  }
  return indices_of(selection.columns.empty() ? all : selection.columns, all);
}

void RowStore::add_row(double /*time*/, const double* row) {
  for (const std::size_t c : columns_) *to_++ = row[c];
}

RowSummary::RowSummary(std::span<const std::size_t> columns, std::span<ColumnSummary> out)
    : columns_(columns), out_(out) {
  std::fill(out_.begin(), out_.end(), ColumnSummary{});
}

void RowSummary::add_row(double time, const double* row) {
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const double value = row[columns_[i]];
    ColumnSummary& s = out_[i];
    if (rows_ == 0) {
      s = {value, value, time, time, value, value};
      continue;
    }
    s.mean += value;
    s.last = value;
    if (value >= s.minimum && value <= s.maximum) continue;
    // NaN is kept, and nothing is smaller or larger.
    if (value < s.minimum || (std::isnan(value) && !std::isnan(s.minimum))) {
      s.minimum = value;
      s.minimum_time = time;
    }
    if (value > s.maximum || (std::isnan(value) && !std::isnan(s.maximum))) {
      s.maximum = value;
      s.maximum_time = time;
    }
  }
  ++rows_;
}

void RowSummary::finish() {
  for (ColumnSummary& s : out_) s.mean /= static_cast<double>(rows_);
}

void RowStream::add_row(double time, const double* row) {
  if (seen_++ % selection_->every != 0) return;
  times_.push_back(time);
  for (const std::size_t c : columns_) values_.push_back(row[c]);
  if (times_.size() == selection_->block) give();
}

// Returns the memory: only members that run have some.
void RowStream::finish() {
  if (!times_.empty()) give();
  times_ = {};
  values_ = {};
}

void RowStream::give() {
  (*sink_)({member_, times_, values_});
  times_.clear();
  values_.clear();
}

}  // namespace assur
