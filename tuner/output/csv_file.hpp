// Where --csv goes.
#pragma once

#include <iostream>
#include <optional>
#include <string>

#include "assur/simulator.hpp"
#include "output/replace_file.hpp"

namespace assur::output {

class CsvFile {
 public:
  // "-": standard output; "": nowhere. Opened before the run: an hour's work is not lost to a misspelt folder. Throws
  // Error (environment), as write() does.
  explicit CsvFile(const std::string& name);

  // `result`: of a run, anything that write_csv() takes.
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
