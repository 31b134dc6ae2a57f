// Where --errors goes: a row for each step and group.
#pragma once

#include <cstdint>
#include <fstream>
#include <span>
#include <string>

#include "assur/structure.hpp"
#include "measure/diagnosis.hpp"

namespace assur::output {

// t, group, residual, estimated, error, condition, iterations, substeps; what is not known is left empty.
class ErrorsCsv {
 public:
  // Throws Error (environment), as all of it does, that names the file.
  explicit ErrorsCsv(std::string file);

  // substeps: accepted ones on the way to t.
  void write(double t, std::int64_t substeps, const Structure& structure, std::span<const measure::GroupErrors> groups);
  void close();

 private:
  [[noreturn]] void fail() const;

  std::string file_;
  std::ofstream out_;
};

}  // namespace assur::output
