// Where --errors goes: a row for each step and group.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "assur/simulator.hpp"
#include "output/replace_file.hpp"

namespace assur::output {

// One group after one step; what is not known is left empty.
struct ErrorsRow {
  GroupFigures figures;
  std::optional<double> error = {};             // true, of its unknowns, over the characteristic length
  std::optional<std::int64_t> iterations = {};  // empty: only known of all groups together
};

// t, group, residual, estimated, error, condition, iterations, substeps.
class ErrorsCsv {
 public:
  // Throws Error (environment), as all of it does, that names the file.
  explicit ErrorsCsv(const std::string& file);

  // substeps: accepted ones on the way to t.
  void write(double t, std::int64_t substeps, const Structure& structure, std::span<const ErrorsRow> rows);
  void close();

 private:
  Replacement file_;
};

}  // namespace assur::output
