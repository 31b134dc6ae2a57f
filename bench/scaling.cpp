// Scaling of the library on this machine: threads, lanes, chunks, members, legs; single steps with pinned threads; and
// runs beside busy processes. Every result is compared with the result of one thread before its time counts. The exit
// status is 1 if a result is wrong.
//
//   scaling_bench [--quick] [--only NAMES] [--threads N] [--rounds N] [--block S] [--busy N] [--csv FILE]
#include <malloc.h>
#include <stdlib.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <limits>
#include <string>
#include <vector>

#include "assur/assur.hpp"
#include "contest.hpp"
#include "experiments.hpp"
#include "machine.hpp"
#include "scaling_table.hpp"

namespace assur::bench {
namespace {

// The load is reported with the results, because other processes slow them down.
std::string load() {
  double average[1] = {0};
  if (getloadavg(average, 1) != 1) return "unknown";
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", average[0]);
  return text;
}

void describe(std::ostream& out, const Options& o, const std::string& prefix) {
  describe_machine(out, prefix);
  out << prefix << "load average: " << load() << '\n'
      << prefix << "threads: up to " << o.threads << "; rounds: " << o.rounds << '\n';
  out.flush();
}

// Keeps the memory of results, even of large ones, from round to round: a page that is new to the process costs as much
// as some of the steps whose results it holds.
void keep_memory() {
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
}

int run(Options o) {
  keep_memory();
  if (o.threads == 0) o.threads = this_machine().budget().threads;
  if (o.rounds == 0) o.rounds = o.quick ? 3 : 15;
  if (o.busy == 0) o.busy = 2 * o.threads;
  if (o.block == 0) o.block = o.quick ? 0.002 : 0.05;
  std::ofstream csv;
  if (!o.csv.empty()) {
    csv.open(o.csv);
    if (!csv) throw Error(Error::Kind::environment, "--csv: cannot write " + o.csv);
    describe(csv, o, "# ");
    write_csv_header(csv);
  }
  describe(std::cout, o, "");
  int wrong = 0;
  for (const Experiment& experiment : experiments()) {
    if (!o.only.empty() && std::find(o.only.begin(), o.only.end(), experiment.name) == o.only.end()) continue;
    std::vector<Entry> contest = experiment.make(o);
    hold(contest, o.rounds);
    print_table(experiment.title, contest, experiment.show);
    if (csv.is_open()) write_csv_rows(csv, experiment.name, contest);
    wrong += static_cast<int>(std::count_if(contest.begin(), contest.end(), [](const Entry& e) { return e.wrong; }));
  }
  std::printf(
      "\nmedians of %d rounds, all lines of a table in turns. One thread: processor time; several: by the "
      "clock.\n+-%%: half the distance of the quartiles; at best: the "
      "fastest rounds.\n"
      "Load average at the end: %s\n",
      o.rounds, load().c_str());
  if (!o.csv.empty() && !csv) throw Error(Error::Kind::environment, "--csv: cannot write " + o.csv);
  if (wrong > 0) std::fprintf(stderr, "error: %d results are WRONG\n", wrong);
  return wrong > 0 ? 1 : 0;
}

}  // namespace
}  // namespace assur::bench

int main(int argc, char** argv) {
  using namespace assur::bench;
  Options options;
  std::vector<std::string> names;
  for (const Experiment& experiment : experiments()) names.emplace_back(experiment.name);
  CLI::App app("Scaling of the library on this machine. Every result is verified before its time counts.",
               "scaling_bench");
  app.add_flag("--quick", options.quick, "Small sizes, which take seconds: shows that everything runs");
  app.add_option("--only", options.only, "Run only some of " + CLI::detail::join(names, ", "))
      ->delimiter(',')
      ->check(CLI::IsMember(names))
      ->type_name("A,B");
  const auto count = [&](const char* name, int& value, const char* meaning) {
    app.add_option(name, value, meaning)->check(CLI::Range(1, 4096))->type_name("N");
  };
  count("--threads", options.threads, "Largest number of threads; may exceed the machine's budget");
  count("--rounds", options.rounds, "Measurements of each candidate: 15, with --quick 3");
  count("--busy", options.busy, "Number of busy processes: two for each thread");
  app.add_option("--block", options.block, "Seconds of one measurement: 0.05, with --quick 0.002")
      ->check(CLI::Range(1e-6, 100.0))
      ->type_name("S");
  app.add_option("--csv", options.csv, "Write all tables")->type_name("FILE");
  app.footer("Exit status: 0 done, 1 a result is wrong, 2 bad usage, 3 environment.");
  try {
    app.parse(argc, argv);
    return run(options);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "error: %s\n", error.what());
    return 3;
  }
}
