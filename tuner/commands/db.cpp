// assur db
#include <algorithm>
#include <iostream>
#include <set>

#include "commands/db_parts.hpp"
#include "db/machine_model.hpp"
#include "db/unusable.hpp"
#include "output/answer.hpp"
#include "output/format.hpp"
#include "output/replace_file.hpp"
#include "tuning/sample_csv.hpp"

namespace assur::command {
namespace {

namespace fs = std::filesystem;
using db::Access;
using db::Store;
using output::Json;
using output::Page;
using Columns = std::vector<std::pair<std::string, std::string>>;  // column of an answer, its title

// The first existing database.
Store store_to_ask(const Common& common) {
  std::string looked_for;
  for (const db::DatabaseFile& place : databases_of(common)) {
    try {
      return Store(place.file, Access::read);
    } catch (const db::Unusable& unusable) {
      if (unusable.trouble() != db::Trouble::absent) throw;
    }
    looked_for += (looked_for.empty() ? "" : ", ") + place.file.string();
  }
  throw Error(Error::Kind::environment, looked_for.empty()
                                            ? "ASSUR_DB is empty: name a tuning database with --db"
                                            : "there is no tuning database yet (" + looked_for + "); run `assur tune`");
}

// `may_be_new`: creates the database if it does not exist.
Store store_to_change(const Common& common, bool may_be_new) {
  const fs::path file = own_database_of(common);
  if (!may_be_new) db::require_readable(file);
  return Store(file, Access::write);
}

// Prints the messages from opening the database.
void warn_of_database(const Common& common, const Store& store) {
  for (const std::string& message : store.messages()) {
    if (!common.quiet) std::cerr << "warning: " << message << '\n';
  }
}

[[noreturn]] void refuse_unknown(const std::string& where, const std::string& option, const std::string& wanted,
                                 const std::set<std::string>& known) {
  std::string all;
  for (const std::string& one : known) all += (all.empty() ? "" : ", ") + one;
  throw Error(Error::Kind::input,
              option + ": " + where + " has no " + wanted + (all.empty() ? "; it has none" : "; it has " + all));
}

// Refuses a machine or run that the database does not have.
db::Filter filter_of(const Store& store, const DbOptions& options) {
  const std::vector<db::Run> runs = store.runs();
  const std::string file = store.file().string();
  std::set<std::string> machines, numbers;
  for (const db::Run& run : runs) {
    machines.insert(run.machine);
    numbers.insert(std::to_string(run.id));
  }
  const auto is_wanted = [&](const std::string& machine) { return machine.starts_with(options.machine); };
  if (std::none_of(machines.begin(), machines.end(), is_wanted) && !options.machine.empty()) {
    refuse_unknown(file, "--machine", "machine " + options.machine, machines);
  }
  if (options.run && numbers.count(std::to_string(*options.run)) == 0) {
    refuse_unknown(file, "--run", "tuning run " + std::to_string(*options.run), numbers);
  }
  db::Filter filter;
  filter.run = options.run;
  filter.machine = options.machine;
  filter.library = options.library;
  if (!options.kernel.empty()) filter.kernel = parse_kernel(options.kernel);
  return filter;
}

int show(const Common& common, const Store& store, const db::Answer& answer, const Columns& columns) {
  if (common.json) {
    output::print(std::cout, {{"database", store.file().string()}, {"rows", output::to_json(answer)}});
    return kDone;
  }
  Page page(std::cout);
  page.title(store.file().string());
  if (answer.rows.empty()) {
    page.fact("", "nothing");
  } else {
    output::print(page, answer, columns);
  }
  return kDone;
}

int show_samples(const Common& common, const DbOptions& options) {
  refuse_overwriting(common, {{"--csv", options.csv}}, {});
  const Store store = store_to_ask(common);
  db::Filter filter = filter_of(store, options);
  filter.strategy = options.strategy;
  filter.n = options.n;
  if (!options.csv.empty()) {
    output::Replacement csv("--csv", options.csv);
    tuning::write_csv(csv.stream(), store.samples(filter));
    csv.put();
  }
  return show(common, store, store.sample_rows(filter),
              {{"machine", "machine"},
               {"kernel", "kernel"},
               {"n", "n"},
               {"nnz", "nnz"},
               {"groups", "groups"},
               {"strategy", "strategy"},
               {"seconds", "one call"},
               {"spread", "spread"},
               {"backward_error", "error"}});
}

int show_best(const Common& common, const DbOptions& options) {
  const Store store = store_to_ask(common);
  return show(common, store, store.best(filter_of(store, options)),
              {{"machine", "machine"},
               {"kernel", "kernel"},
               {"n", "n"},
               {"nnz", "nnz"},
               {"groups", "groups"},
               {"strategy", "fastest"},
               {"seconds", "one instance"},
               {"runner_up", "next"},
               {"runner_up_takes", "takes"}});
}

int show_crossovers(const Common& common, const DbOptions& options) {
  const Store store = store_to_ask(common);
  return show(common, store, store.crossovers(filter_of(store, options)),
              {{"machine", "machine"},
               {"kernel", "kernel"},
               {"dense", "matrix"},
               {"groups", "groups"},
               {"n_before", "n up to"},
               {"strategy_before", "fastest"},
               {"n", "n from"},
               {"strategy", "fastest"}});
}

int show_models(const Common& common) {
  const Store store = store_to_ask(common);
  return show(common, store, store.models(),
              {{"machine", "machine"}, {"name", "model"}, {"made", "made"}, {"assur", "assur"}});
}

// Prints the result: a row for JSON, else a sentence.
int done(const Common& common, Json row, const std::string& sentence) {
  if (common.json) {
    output::print(std::cout, {{"rows", Json::array({std::move(row)})}});
  } else {
    std::cout << sentence << '\n';
  }
  return kDone;
}

int export_samples(const Common& common, const DbOptions& options) {
  const Store store = store_to_ask(common);
  const std::int64_t samples = store.export_to(options.file, filter_of(store, options));
  return done(common, {{"database", store.file().string()}, {"file", options.file}, {"samples", samples}},
              output::counted(samples, "sample") + " of " + store.file().string() + " in " + options.file);
}

int import_samples(const Common& common, const DbOptions& options) {
  db::require_readable(options.file);  // before a new database is created
  Store store = store_to_change(common, true);
  warn_of_database(common, store);
  const db::Imported imported = store.import_from(options.file);
  return done(common,
              {{"database", store.file().string()},
               {"file", options.file},
               {"samples", imported.samples},
               {"known", imported.known}},
              output::counted(imported.samples, "new sample") + " in " + store.file().string() + ", " +
                  output::grouped(imported.known) + " already there");
}

// Opening checks all of the database. Opening for writing also puts one that cannot be used aside; a read-only database
// is only examined.
Store store_to_check(const Common& common) {
  const fs::path file = own_database_of(common);
  try {
    db::require_readable(file);
  } catch (const db::Unusable& unusable) {
    if (unusable.trouble() == db::Trouble::absent) throw;  // do not create one
  }
  try {
    return Store(file, Access::write);
  } catch (const db::Unusable& unusable) {
    if (unusable.trouble() != db::Trouble::blocked) throw;
    return Store(file, Access::read);
  }
}

int check(const Common& common) {
  const Store store = store_to_check(common);
  const db::Counts counts = store.counts(db::this_host().fingerprint());
  if (common.json) {
    output::print(std::cout, {{"rows", Json::array({{{"database", store.file().string()},
                                                     {"samples", counts.samples},
                                                     {"stale", counts.stale},
                                                     {"unknown", counts.unknown},
                                                     {"put_aside", store.messages()}}})}});
    return kDone;
  }
  Page page(std::cout);
  page.title(store.file().string());
  page.list("put aside", store.messages());
  if (store.messages().empty()) page.fact("undamaged", "yes");
  page.fact("samples", output::grouped(counts.samples));
  if (counts.stale > 0) page.fact("stale", output::grouped(counts.stale) + " of library versions not installed now");
  if (counts.unknown > 0) page.fact("unknown", output::grouped(counts.unknown) + " of a newer assur");
  return kDone;
}

int forget(const Common& common, const DbOptions& options) {
  const bool some = options.run || !options.machine.empty() || !options.library.empty();
  if (some == options.all) {
    throw Error(Error::Kind::input, "select the samples to forget: --run N, --machine TEXT, --library NAME, or --all");
  }
  Store store = store_to_change(common, false);
  warn_of_database(common, store);
  const db::Forgotten forgotten = options.all ? store.forget_all() : store.forget(filter_of(store, options));
  return done(common, {{"database", store.file().string()}, {"samples", forgotten.samples}, {"runs", forgotten.runs}},
              output::counted(forgotten.samples, "sample") + " and " + output::counted(forgotten.runs, "tuning run") +
                  " removed from " + store.file().string());
}

}  // namespace

std::vector<db::DatabaseFile> databases_of(const Common& common) {
  if (!common.db.empty()) return {{common.db, db::DatabaseFile::Role::named}};
  return db::database_files();
}

fs::path own_database_of(const Common& common) {
  if (!common.db.empty()) return common.db;
  if (auto file = db::own_database()) return *file;
  throw Error(Error::Kind::environment,
              "there is no place for a tuning database: ASSUR_DB is empty or HOME is not set; use --db FILE");
}

MachineModel machine_model_of(const Common& common) {
  if (common.db.empty()) return machine_model();
  db::require_readable(common.db);
  return db::read_machine_model(databases_of(common), db::this_host(), db::library_at_hand);
}

OtherMachine other_machine(const Common& common, const std::string& fingerprint) {
  const std::vector<db::DatabaseFile> files = databases_of(common);
  std::string names;
  std::set<std::string> machines;
  std::int32_t threads = 0;
  for (const db::DatabaseFile& place : files) {
    names += (names.empty() ? "" : ", ") + place.file.string();
    if (!fs::exists(place.file)) continue;
    for (const db::Run& run : Store(place.file, Access::read).runs()) {
      machines.insert(run.machine);
      if (run.machine.starts_with(fingerprint)) threads = std::max(threads, run.threads);
    }
  }
  if (threads == 0) refuse_unknown(names, "--machine", "machine " + fingerprint, machines);
  return {db::read_model_of(files, fingerprint), ThreadBudget{threads}};
}

int db(const Common& common, const DbOptions& options) {
  const std::string& question = options.question;
  if (question == "info") return db_info(common);
  if (question == "samples") return show_samples(common, options);
  if (question == "best") return show_best(common, options);
  if (question == "crossovers") return show_crossovers(common, options);
  if (question == "models") return show_models(common);
  if (question == "export") return export_samples(common, options);
  if (question == "import") return import_samples(common, options);
  if (question == "check") return check(common);
  return forget(common, options);
}

}  // namespace assur::command
