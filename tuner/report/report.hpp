// The report: makes its parts one after the other; its files are complete at any time.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "report/sections.hpp"

namespace assur::report {

// A planned part: sections that belong together.
struct Planned {
  std::string chapter;  // "This machine"
  std::string title;    // subject
  double share = 1;     // share of the time, relative to other parts
  std::function<std::vector<Section>(const Conditions&)> make;
};

struct Wishes {
  std::string peers = {};  // file of bench/peers/peers.sh; empty: none
  double watts = 0;        // PaperOptions::watts
};

// The parts of a report in order. `knowledge` must outlive them. Throws Error (input) if the file of peers cannot be
// read, or has another format.
[[nodiscard]] std::vector<Planned> contents(const Knowledge& knowledge, const Wishes& wishes = {});

struct Outcome {
  struct Took {
    std::string title;
    double seconds = 0;
  };

  std::vector<std::filesystem::path> files;
  std::vector<std::string> failures;  // parts that could not be made, with reasons
  std::vector<Took> parts;            // parts that were begun
  bool interrupted = false;
};

// Makes all parts in their order, within whole.seconds; later parts may use the time that earlier ones leave. Writes
// index.html, report.csv and report.json to `folder` (made if missing) at the start and after each part; readers find
// the old or the new files, never incomplete ones. If a part throws Error, the page has its message. Throws Error
// (environment) if a file cannot be written.
[[nodiscard]] Outcome make_report(const std::filesystem::path& folder, const std::vector<Planned>& parts,
                                  const Knowledge& knowledge, const Conditions& whole);

}  // namespace assur::report
