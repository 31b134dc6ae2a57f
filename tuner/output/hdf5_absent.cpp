#include "assur/status.hpp"
#include "output/hdf5.hpp"

namespace assur::output {

OpenHdf5* load_hdf5(const std::string& option) {
  throw Error(Error::Kind::environment,
              {{option, "this build cannot write HDF5, because HDF5 was not found (Debian: libhdf5-dev)"}});
}

}  // namespace assur::output
