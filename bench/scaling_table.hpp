// The results of scaling_bench: as tables on the terminal, and all of them in one CSV.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "contest.hpp"

namespace assur::bench {

// The columns of a table besides the strategy and the time of a step.
enum class Show {
  threads,  // speed-up over the same strategy on one thread, in all and for each thread
  lanes,    // speed-up over one lane, in all and for each lane
  chunks,   // speed-up over one thread without chunks, and over the same chunks on one thread
  members,  // steps per second; speed-up over single mechanisms, in all and for each thread, and over one thread
  legs,     // time for one leg, in s and relative to the fewest legs
  single,   // median, 99th percentile and longest of single steps
};

void print_table(const std::string& title, const std::vector<Entry>& contest, Show show);

// Column names; the rows of one experiment. Times are in seconds; cells that do not apply are empty.
void write_csv_header(std::ostream& out);
void write_csv_rows(std::ostream& out, const std::string& experiment, const std::vector<Entry>& contest);

}  // namespace assur::bench
