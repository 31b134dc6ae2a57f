// Where --csv goes.
#pragma once

#include <fstream>
#include <iostream>
#include <string>

#include "assur/simulator.hpp"

namespace assur::output {

class CsvFile {
 public:
  // "-": standard output; "": nowhere. Opened before the run: an hour's work is not lost to a misspelt folder. Throws
  // Error (environment), as write() does.
  explicit CsvFile(std::string name);

  // `result`: of a run, anything that write_csv() takes.
  template <class Result>
  void write(const Result& result) {
    if (name_.empty()) return;
    std::ostream& out = begin();
    write_csv(out, result);
    end(out);
  }

 private:
  std::ostream& begin();
  void end(std::ostream& out) const;
  [[noreturn]] void fail() const;

  std::string name_;
  std::ofstream file_;
};

}  // namespace assur::output
