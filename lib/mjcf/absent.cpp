// A build without tinyxml2.
#include "assur/mjcf.hpp"

namespace assur {

ImportedModel import_model(const std::filesystem::path& file, const ModelOptions&) {
  throw Error(Error::Kind::environment,
              {{"",
                "assur was built without tinyxml2, which reads models of MuJoCo; install the Debian package "
                "libtinyxml2-dev and build assur again"}},
              file.string());
}

}  // namespace assur
