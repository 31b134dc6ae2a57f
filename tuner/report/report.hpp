// The report as a whole: parts made one after the other, and its files, which are whole at any time.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "report/sections.hpp"

namespace assur::report {

// A part to be made: sections that belong together.
struct Planned {
  std::string chapter;  // "This machine"
  std::string title;    // of what it is about
  double share = 1;     // of the time, beside those of the others
  std::function<std::vector<Section>(const Conditions&)> make;
};

struct Wishes {
  std::string peers = {};  // a file that bench/peers/peers.sh has written; empty: none
  double watts = 0;        // PaperOptions::watts
};

// What a report has, in order. The knowledge outlives what is returned. Throws Error (input) for a file of peers that
// cannot be read or is none.
[[nodiscard]] std::vector<Planned> contents(const Knowledge& knowledge, const Wishes& wishes = {});

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
