#include "output/notes.hpp"

#include <algorithm>

namespace assur::output {

std::vector<Diagnostic> notes(const Scene& scene, const GroupedSystem& structure) {
  std::vector<Diagnostic> all = structure.notes;
  all.insert(all.end(), scene.warnings().begin(), scene.warnings().end());
  return all;
}

std::vector<std::string> slowed(std::span<const Backend> table) {
  std::vector<std::string> reasons;
  for (const Backend& backend : table) {
    const std::string reason = backend.slowed ? backend.slowed() : "";
    if (!reason.empty() && std::find(reasons.begin(), reasons.end(), reason) == reasons.end()) {
      reasons.push_back(reason);
    }
  }
  return reasons;
}

void print_notes(Page& page, const Scene& scene, const GroupedSystem& structure) {
  std::vector<std::string> texts;
  for (const Diagnostic& d : notes(scene, structure)) {
    texts.push_back(d.where.size() > 1 ? d.where + ": " + d.what : d.what);
  }
  page.list("notes", texts);
}

}  // namespace assur::output
