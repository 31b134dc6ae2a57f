// What a report has, in order.
#pragma once

#include <string>
#include <vector>

#include "report/report.hpp"

namespace assur::report {

struct Wishes {
  std::string peers = {};  // a file that bench/peers/peers.sh has written; empty: none
  double watts = 0;        // PaperOptions::watts
};

// The knowledge outlives what is returned. Throws Error (input) for a file of peers that cannot be read or is none.
[[nodiscard]] std::vector<Planned> contents(const Knowledge& knowledge, const Wishes& wishes = {});

}  // namespace assur::report
