#include "assur/status.hpp"
#include "sweep/linkage_file.hpp"

namespace assur::sweep {

struct LinkageFile::Impl {};

LinkageFile::LinkageFile(const std::string& /*name*/, const LinkageSet& /*set*/) {
  throw Error(Error::Kind::environment,
              "this build cannot write data sets of linkages, because HDF5 was not found (Debian: libhdf5-dev)");
}
LinkageFile::~LinkageFile() = default;
const LinkageCounts& LinkageFile::counts() const {
  static const LinkageCounts kNone;
  return kNone;
}
std::vector<std::pair<std::int64_t, double>> LinkageFile::distances() const { return {}; }
void LinkageFile::append(std::span<const LinkageRow> /*rows*/, const LinkageCounts& /*more*/) {}

}  // namespace assur::sweep
