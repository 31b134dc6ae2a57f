// What a report has, in order.
#pragma once

#include <string>
#include <vector>

#include "report/report.hpp"

namespace assur::report {

// peers: what bench/peers/peers.sh has written; empty: none. The knowledge outlives what is returned.
[[nodiscard]] std::vector<Planned> contents(const Knowledge& knowledge, const std::string& peers = {});

}  // namespace assur::report
