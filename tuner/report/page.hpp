// index.html of the report.
#pragma once

#include <string>
#include <vector>

#include "report/knowledge.hpp"
#include "report/section.hpp"

namespace assur::report {

// A part of the report: sections that were made, or what there would be.
struct Part {
  std::string chapter;  // "This machine"
  std::string title;    // of what it is about
  std::vector<Section> sections;
  std::string missing;  // why there are none, or not all of it; empty: nothing is missing
};

struct PageHead {
  Facts facts;
  std::string notice;  // a sentence before everything else; may be empty
  std::string state;   // "Made in 2 min", "Interrupted: ..."
};

// One file that needs nothing else. Parts of one chapter follow each other.
[[nodiscard]] std::string page(const PageHead& head, const std::vector<Part>& parts);

}  // namespace assur::report
