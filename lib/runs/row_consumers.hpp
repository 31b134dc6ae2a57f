// Consume the rows of a member one after the other, so that a run stores no row.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "assur/ensemble.hpp"

namespace assur {

// Indices of columns. Throws Error (input), with a list of the columns, for an unknown one.
[[nodiscard]] std::vector<std::size_t> indices_of(const std::vector<std::string>& columns,
                                                  const std::vector<std::string>& all);
// The same for the selected columns. Throws Error (input) also for an empty sink, and for a number that is 0.
[[nodiscard]] std::vector<std::size_t> selected(const RowSelection& selection, const RowSink& sink,
                                                const std::vector<std::string>& all);

class RowConsumer {
 public:
  virtual ~RowConsumer() = default;
  // The next row: all columns.
  virtual void add_row(double time, const double* row) = 0;
  // After the last row, if there was one.
  virtual void finish() = 0;
};

// Stores some columns.
class RowStore : public RowConsumer {
 public:
  // columns: indices, which must outlive this object. to: rows x columns.
  RowStore(std::span<const std::size_t> columns, double* to) : columns_(columns), to_(to) {}

  void add_row(double time, const double* row) override;
  void finish() override {}

 private:
  std::span<const std::size_t> columns_;
  double* to_;
};

// Summarises some columns.
class RowSummary : public RowConsumer {
 public:
  // columns: indices; `out` has one summary for each, NaN until there is a row. Both must outlive this object.
  RowSummary(std::span<const std::size_t> columns, std::span<ColumnSummary> out);

  void add_row(double time, const double* row) override;
  void finish() override;

 private:
  std::span<const std::size_t> columns_;
  std::span<ColumnSummary> out_;
  std::int64_t rows_ = 0;
};

// Gives rows to a sink, block by block.
class RowStream : public RowConsumer {
 public:
  // columns: indices. All arguments must outlive this object.
  RowStream(std::size_t member, std::span<const std::size_t> columns, const RowSelection& selection,
            const RowSink& sink)
      : member_(member), columns_(columns), selection_(&selection), sink_(&sink) {}

  void add_row(double time, const double* row) override;
  void finish() override;

 private:
  void give();

  std::size_t member_;
  std::span<const std::size_t> columns_;
  const RowSelection* selection_;
  const RowSink* sink_;
  std::size_t seen_ = 0;  // rows
  std::vector<double> times_, values_;
};

}  // namespace assur
