// The numbers that the paper prints, and the machines that they were measured on: "Exploiting Hybrid Parallelism in the
// Kinematic Analysis of Multibody Systems Based on Group Equations", tables 2 to 5.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "report/paper/cells.hpp"

namespace assur::report {

struct PaperMachine {
  std::string_view id, name;
  double watts;  // that table 4 counts with
};

// "i5" (tables 2 to 4), "E5" (figure 3, tables 4 and 5), "RP2", "RP3" (table 4), "GTX" (table 5).
[[nodiscard]] const PaperMachine& paper_machine(std::string_view id);

// Times of tables 2, 3 and 5, of one step, with the threads that the paper says.
[[nodiscard]] const std::vector<PaperTiming>& paper_times(int table);

// One machine of table 4.
struct PaperEnergy {
  PaperCell cell;
  std::string_view machine;  // id
  double seconds = 0;        // of the whole run
  double joules = 0;         // as printed
};
[[nodiscard]] const std::vector<PaperEnergy>& paper_energies();

}  // namespace assur::report
