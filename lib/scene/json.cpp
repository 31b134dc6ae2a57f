#include <fstream>
#include <iterator>

#include "assur/scene.hpp"
#include "scene/json_reader.hpp"

namespace assur {
namespace {

// The document is gone before the scene is checked, and read again to sort what is wrong.
Scene build(SceneBuilder builder, std::string_view text) {
  try {
    return std::move(builder).build();
  } catch (const Error& error) {
    std::vector<Diagnostic> findings = error.diagnostics();
    const JsonDocument document = parse_json(text);
    sort_by_place(findings, document.root);
    throw Error(error.kind(), std::move(findings));
  }
}

Scene parse(std::string_view text, const std::string& source, const std::string& title,
            const std::filesystem::path& folder, const Parameters& set) {
  try {
    return build(JsonReader(parse_json(text), folder, set).read(title), text);
  } catch (const Error& error) {
    throw Error(error.kind(), error.diagnostics(), source);
  }
}

}  // namespace

Scene parse_scene(std::string_view text, const std::string& name, const std::filesystem::path& folder,
                  const Parameters& set) {
  return parse(text, name, name, folder, set);
}

Scene read_scene(const std::filesystem::path& path, const Parameters& set) {
  std::error_code unused;
  std::ifstream file(path, std::ios::binary);
  if (!file || std::filesystem::is_directory(path, unused)) {
    throw Error(Error::Kind::environment, {{"", "the scene file cannot be read"}}, path.string());
  }
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  return parse(text, path.string(), path.stem().string(), path.parent_path(), set);
}

}  // namespace assur
