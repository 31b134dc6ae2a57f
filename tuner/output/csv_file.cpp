#include "output/csv_file.hpp"

#include <cerrno>
#include <cstring>
#include <utility>

namespace assur::output {

CsvFile::CsvFile(std::string name) : name_(std::move(name)) {
  if (name_.empty() || name_ == "-") return;
  errno = 0;
  file_.open(name_);
  if (!file_) fail();
}

std::ostream& CsvFile::begin() {
  errno = 0;
  return name_ == "-" ? std::cout : file_;
}

void CsvFile::end(std::ostream& out) const {
  out.flush();
  if (!out) fail();
}

void CsvFile::fail() const {
  const std::string why = errno != 0 ? std::strerror(errno) : "unknown reason";
  throw Error(Error::Kind::environment,
              {{"--csv", "cannot write " + (name_ == "-" ? "to standard output" : name_) + ": " + why}});
}

}  // namespace assur::output
