#include <algorithm>

#include "assur/scene.hpp"
#include "files/input_file.hpp"
#include "files/json_reader.hpp"
#include "scene/scene_source.hpp"

namespace assur {
namespace {

// The document is released before the scene is checked, so findings need a second reading to be sorted.
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

constexpr std::size_t kMostSceneFindings = 1000;  // a choice: more than anyone reads

// Shortens findings: they quote keys of the file, and there may be millions of them.
std::vector<Diagnostic> readable(std::vector<Diagnostic> findings) {
  const std::size_t more = findings.size() - std::min(findings.size(), kMostSceneFindings);
  findings.resize(findings.size() - more);
  if (more > 0) findings.push_back({"", "and " + std::to_string(more) + " more findings"});
  for (Diagnostic& finding : findings) {
    std::string where;
    for (std::size_t at = 0; at < finding.where.size();) {
      const std::size_t end = std::min(finding.where.find('/', at + 1), finding.where.size());
      where += excerpt(std::string_view(finding.where).substr(at, end - at));
      at = end;
    }
    finding.where = std::move(where);
  }
  return findings;
}

Scene parse(std::string_view text, const std::string& source, const std::string& title, const TableFolders& tables,
            const Parameters& set) {
  try {
    std::vector<std::string> parameters;
    SceneBuilder builder = [&] {
      const JsonDocument document = parse_json(text);
      if (const JsonNode* section = document.root.find("parameters")) {
        parameters.assign(section->keys().begin(), section->keys().end());
      }
      return JsonReader(document, tables, set).read(title);
    }();
    Scene scene = build(std::move(builder), text);
    if (parameters.empty()) return scene;
    return SceneSource::attach(std::move(scene), {std::move(parameters), [text = std::string(text), source, title,
                                                                          tables, set](const Parameters& values) {
                                                    Parameters all = values;
                                                    all.insert(set.begin(), set.end());
                                                    return parse(text, source, title, tables, all);
                                                  }});
  } catch (const Error& error) {
    throw Error(error.kind(), readable(error.diagnostics()), source);
  }
}

}  // namespace

Scene parse_scene(std::string_view text, const std::string& name, const std::filesystem::path& folder,
                  const Parameters& set, const std::vector<std::filesystem::path>& more_folders) {
  return parse(text, name, name, {folder, more_folders}, set);
}

Scene read_scene(const std::filesystem::path& path, const Parameters& set,
                 const std::vector<std::filesystem::path>& more_folders) {
  const InputFile file = read_input(path, kLargestScene);
  if (!file.why_not.empty()) {
    throw Error(Error::Kind::environment, {{"", "the scene file cannot be read: " + file.why_not}}, path.string());
  }
  return parse(file.text, path.string(), path.stem().string(), {path.parent_path(), more_folders}, set);
}

}  // namespace assur
