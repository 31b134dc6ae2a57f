// The output file of --csv.
#pragma once

#include <iostream>
#include <optional>
#include <string>

#include "assur/simulator.hpp"
#include "output/replace_file.hpp"

namespace assur::output {

class CsvFile {
 public:
  // "-": standard output; "": no output. Opens the file before the run, so that a misspelt folder does not cost the
  // work of an hour. Throws Error (environment), like write().
  explicit CsvFile(const std::string& name);

  // `result`: a trajectory of a run or of an ensemble.
  template <class Result>
  void write(const Result& result) {
    if (!file_ && !to_standard_output_) return;
    write_csv(begin(), result);
    end();
  }

 private:
  std::ostream& begin();
  void end();

  bool to_standard_output_;
  std::optional<Replacement> file_;
};

}  // namespace assur::output
