// The results of scaling_bench: as tables on the terminal, and all of them in one CSV.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "contest.hpp"

namespace assur::bench {

// What a table shows beside the strategy and the time of a step.
enum class Show {
  threads,  // speed-up over the same strategy on one thread, and what each thread of it does
  lanes,    // speed-up over one lane, and what each lane of it does
  chunks,   // speed-up over one thread without chunks, and over the same chunks on one thread
  members,  // steps per second; speed-up over a mechanism on its own, also for each thread, and over one thread
  legs,     // time for one leg, and its growth over the fewest legs
  single,   // median, 99th percentile and longest of single steps
};

void print_table(const std::string& title, const std::vector<Entry>& contest, Show show);

// Column names; the rows of one experiment. Times in seconds; what does not apply is empty.
void write_csv_header(std::ostream& out);
void write_csv_rows(std::ostream& out, const std::string& experiment, const std::vector<Entry>& contest);

}  // namespace assur::bench
