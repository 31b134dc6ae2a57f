// The page of `assur sweep`: figures over parameters, and the best samples in motion.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sweep/sweep.hpp"

namespace assur::pictures {

struct SweepPage {
  std::string scene;
  std::vector<std::string> about;  // a sentence each
  std::vector<sweep::Range> ranges;
  std::vector<std::string> figures;
  std::vector<sweep::DesignSample> rows;  // those to show
  std::vector<sweep::DesignSample> best;
  std::vector<std::string> motions;  // SVG of each of the best; "": none
};

// Shows at most this number of rows; more would make points that cannot be told apart.
inline constexpr std::int64_t kRowsOfPage = 1000;

[[nodiscard]] std::string page_of(const SweepPage& page);

}  // namespace assur::pictures
