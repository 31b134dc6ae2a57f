// The experiments of scaling_bench, each with its own table.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "contest.hpp"
#include "scaling_table.hpp"

namespace assur::bench {

struct Options {
  bool quick = false;
  std::vector<std::string> only;
  int threads = 0;   // 0: the budget of the machine
  int rounds = 0;    // 0: 3 if quick, else 15
  int busy = 0;      // processes; 0: two for each thread
  double block = 0;  // s, time of one measurement of a candidate of latency; 0: 0.05, if quick 0.002
  std::string csv;

  // 1, 2, 4, ... and the largest number asked for.
  [[nodiscard]] std::vector<int> counts() const {
    std::vector<int> of;
    for (int n = 1; n < threads; n *= 2) of.push_back(n);
    of.push_back(threads);
    return of;
  }
};

struct Experiment {
  const char* name;
  const char* title;
  std::vector<Entry> (*make)(const Options&);
  Show show;
};

[[nodiscard]] std::span<const Experiment> experiments();

}  // namespace assur::bench
