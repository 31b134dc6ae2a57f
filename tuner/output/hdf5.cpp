#include "output/hdf5.hpp"

#include <dlfcn.h>

#include "assur/status.hpp"

namespace assur::output {

OpenHdf5* load_hdf5(const std::string& option) {
  // Searched in the folders that the command was linked with: beside it, or below the folder of the libraries.
  void* const module = dlopen("assur_hdf5.so", RTLD_NOW | RTLD_LOCAL);
  void* const open = module != nullptr ? dlsym(module, "assur_open_hdf5") : nullptr;
  if (open != nullptr) return reinterpret_cast<OpenHdf5*>(open);
  const char* const why = dlerror();
  throw Error(Error::Kind::environment, {{option, "HDF5 cannot be loaded: " + std::string(why != nullptr ? why : "") +
                                                      "; install assur again, with all of its libraries"}});
}

}  // namespace assur::output
