#include "assur/mjcf.hpp"

#include <cmath>

#include "fuzz/targets.hpp"
#include "parallel/file_tree.hpp"

namespace assur::fuzz {
namespace {

// Behind this line is the file part.xml, which the model may include.
constexpr std::string_view kPart = "\n<!--part.xml-->\n";

void check(const ImportedModel& model) {
  const std::string text = write_scene(model.scene);
  bool is_same = false;
  require(accepts([&] { is_same = write_scene(parse_scene(text)) == text; }), "the scene of a model must be readable");
  require(is_same, "the scene of a model must be written the same again");
  for (const ImportedModel::Coordinate& c : model.coordinates) require(std::isfinite(c.start), "values must be finite");
}

}  // namespace

bool model(std::string_view bytes) {
  static test::FileTree folder;
  const std::size_t cut = bytes.find(kPart);
  folder.file("model.xml", std::string(bytes.substr(0, cut)));
  folder.file("part.xml", std::string(cut == bytes.npos ? "" : bytes.substr(cut + kPart.size())));
  return accepts([&] {
    const ImportedModel model = import_model(folder.root() / "model.xml");
    check(model);
    for (const ImportedModel::Coordinate& c : model.coordinates) {
      (void)accepts([&] { check(import_model(folder.root() / "model.xml", {"", {{c.joint, "0,0.5"}}, {}})); });
      break;
    }
  });
}

}  // namespace assur::fuzz
