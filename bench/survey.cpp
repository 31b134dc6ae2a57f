#include "survey.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>
#include <iostream>

#include "assur/assur.hpp"
#include "machine.hpp"

namespace assur::bench {

int run_survey(int argc, char** argv, const std::string& about, void (*survey)(const Survey&, std::ostream& csv)) {
  Survey o;
  std::string file;
  CLI::App app(about);
  app.add_flag("--quick", o.quick, "Fewer and smaller measurements");
  app.add_option("--threads", o.threads, "Number of threads; default: the machine's budget");
  app.add_option("--only", o.only, "Only scenes whose text contains this");
  app.add_option("--csv", file, "Write all rows to a CSV file");
  CLI11_PARSE(app, argc, argv);
  try {
    std::ofstream csv;
    const auto check = [&] {
      if (!file.empty() && !csv) throw Error(Error::Kind::environment, "--csv: cannot write " + file);
    };
    if (!file.empty()) csv.open(file);
    check();
    if (o.threads <= 0) o.threads = this_machine().budget().threads;
    describe_machine(std::cout);
    const MachineModel& known = machine_model();
    for (const std::string& message : known.messages) std::cout << message << '\n';
    o.model = known.model;
    std::cout << "model: " << o.model->samples() << " samples, " << o.model->source() << std::endl;
    survey(o, csv);
    csv.close();
    check();
    return 0;
  } catch (const Error& error) {
    std::fprintf(stderr, "error: %s\n", error.what());
    return 1;
  }
}

}  // namespace assur::bench
