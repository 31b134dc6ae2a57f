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
    require(!variants.empty(), "there are variants");
    for (const Parameters& variant : variants) {
      require(!variant.empty() && variant.size() == variants.front().size(), "each sets the same parameters");
      for (const auto& [name, value] : variant) {
        require(!name.empty() && std::isfinite(value), "each value has a name and is finite");
      }
    }
  });
}

}  // namespace assur::fuzz
