#include "output/hdf5.hpp"

#include <dlfcn.h>

#include <filesystem>
#include <system_error>

#include "assur/status.hpp"

namespace assur::output {
namespace {

namespace fs = std::filesystem;

// Beside the command in a build, and below the libraries of an installation, which may have been moved.
fs::path module_file() {
  std::error_code error;
  const fs::path folder = fs::canonical("/proc/self/exe", error).parent_path();
  const fs::path beside = folder / "assur_hdf5.so";
  return fs::exists(beside, error) ? beside : (folder / ASSUR_MODULES / "assur_hdf5.so").lexically_normal();
}

}  // namespace

OpenHdf5* load_hdf5(const std::string& option) {
  void* const module = dlopen(module_file().c_str(), RTLD_NOW | RTLD_LOCAL);
  void* const open = module != nullptr ? dlsym(module, "assur_open_hdf5") : nullptr;
  if (open != nullptr) return reinterpret_cast<OpenHdf5*>(open);
  const char* const why = dlerror();
  throw Error(Error::Kind::environment, {{option, "HDF5 cannot be loaded: " + std::string(why != nullptr ? why : "") +
                                                      "; install assur again, with all of its libraries"}});
}

}  // namespace assur::output
