// The output of --errors: a row for each step and group.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "assur/simulator.hpp"
#include "output/replace_file.hpp"

namespace assur::output {

// One group after one step; unknown values are empty.
struct ErrorsRow {
  GroupFigures figures;
  std::optional<double> error = {};  // largest true error of its unknowns, relative to the characteristic length
  std::optional<std::int64_t> iterations = {};  // empty: known only for all groups together
};

// t, group, residual, estimated, error, condition, iterations, substeps.
class ErrorsCsv {
 public:
  // Throws Error (environment), like all functions here, that names the file.
  explicit ErrorsCsv(const std::string& file);

  // substeps: accepted substeps on the way to t.
  void write(double t, std::int64_t substeps, const GroupedSystem& structure, std::span<const ErrorsRow> rows);
  void close();

 private:
  Replacement file_;
};

}  // namespace assur::output
