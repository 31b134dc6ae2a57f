#include <algorithm>
#include <cmath>

#include "assur/scene.hpp"
#include "fuzz/targets.hpp"
#include "parallel/file_tree.hpp"

namespace assur::fuzz {

bool variants(std::string_view bytes) {
  static test::FileTree folder;
  folder.file("variants.csv", std::string(bytes));
  return accepts([&] {
    const std::vector<Parameters> variants = read_variants(folder.root() / "variants.csv");
    require(!variants.empty(), "a list of variants must not be empty");
    for (const Parameters& variant : variants) {
      require(!variant.empty() && variant.size() == variants.front().size(),
              "all variants must set the same number of parameters");
      for (const auto& [name, value] : variant) {
        require(!name.empty() && std::isfinite(value), "each value must have a name and be finite");
      }
    }
  });
}

}  // namespace assur::fuzz
