// index.html of the report.
#pragma once

#include <string>
#include <vector>

#include "report/knowledge.hpp"
#include "report/section.hpp"

namespace assur::report {

// A part of the report, with its sections or the reason why they are missing.
struct Part {
  std::string chapter;  // "This machine"
  std::string title;    // subject
  std::vector<Section> sections;
  std::string missing;  // reason why sections are missing; "": none is missing
};

struct PageHead {
  Facts facts;
  std::string notice;  // a sentence before everything else; may be empty
  std::string state;   // "Made in 2 min", "Interrupted: ..."
};

// The page as a single file without references to others. Parts of one chapter must follow each other.
[[nodiscard]] std::string page(const PageHead& head, const std::vector<Part>& parts);

}  // namespace assur::report
