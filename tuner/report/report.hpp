// The report as a whole: parts made one after the other, and its files, which are whole at any time.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "report/conditions.hpp"
#include "report/page.hpp"

namespace assur::report {

// A part to be made.
struct Planned {
  std::string chapter, title;  // as of Part
  double share = 1;            // of the time, beside those of the others
  std::function<std::vector<Section>(const Conditions&)> make;
};

struct Outcome {
  struct Took {
    std::string title;
    double seconds = 0;
  };

  std::vector<std::filesystem::path> files;
  std::vector<std::string> failures;  // of parts that could not be made, and why
  std::vector<Took> parts;            // those that were begun
  bool interrupted = false;
};

// Makes all parts in their order, within whole.seconds; what one part leaves goes to those after it. index.html,
// report.csv and report.json in `folder` (made if it is not there) are written at the start and after each part; a
// reader finds the old ones or the new ones, never half of one. A part that throws Error is a sentence of the page,
// unless a file cannot be written: Error (environment).
[[nodiscard]] Outcome make_report(const std::filesystem::path& folder, const std::vector<Planned>& parts,
                                  const Knowledge& knowledge, const Conditions& whole);

}  // namespace assur::report
