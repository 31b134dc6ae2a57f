#include "output/notes.hpp"

namespace assur::output {

std::vector<Diagnostic> notes(const Scene& scene, const Structure& structure) {
  std::vector<Diagnostic> all = scene.warnings();
  all.insert(all.end(), structure.notes.begin(), structure.notes.end());
  return all;
}

void print_notes(Page& page, const Scene& scene, const Structure& structure) {
  std::vector<std::string> texts;
  for (const Diagnostic& d : notes(scene, structure)) {
    texts.push_back(d.where.size() > 1 ? d.where + ": " + d.what : d.what);
  }
  page.list("notes", texts);
}

}  // namespace assur::output
