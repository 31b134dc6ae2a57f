#include "output/csv_file.hpp"

#include <cerrno>
#include <cstring>
#include <utility>

namespace assur::output {

CsvFile::CsvFile(const std::string& name) : to_standard_output_(name == "-") {
  if (!name.empty() && !to_standard_output_) file_.emplace("--csv", name);
}

std::ostream& CsvFile::begin() {
  errno = 0;
  return file_ ? file_->stream() : std::cout;
}

void CsvFile::end() {
  if (file_) return file_->put();
  std::cout.flush();
  if (std::cout) return;
  const std::string why = errno != 0 ? std::strerror(errno) : "unknown reason";
  throw Error(Error::Kind::environment, {{"--csv", "cannot write to standard output: " + why}});
}

}  // namespace assur::output
