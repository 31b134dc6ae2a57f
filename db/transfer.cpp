// Store: export, import and removal of samples.
#include <set>

#include "db/store_impl.hpp"
#include "db/writer.hpp"

namespace assur::db {
namespace {

namespace fs = std::filesystem;

int execute(SQLite::Database& database, const std::string& sql) { return database.exec(sql); }

// Removes finished runs without samples, and then everything that nothing refers to.
std::int64_t prune(SQLite::Database& database) {
  const int runs =
      execute(database, "DELETE FROM tuning_run WHERE finished IS NOT NULL AND id NOT IN (SELECT run FROM sample)");
  for (const char* table : {"library", "shape", "strategy"}) {
    execute(database, std::string("DELETE FROM ") + table + " WHERE id NOT IN (SELECT " + table + " FROM sample)");
  }
  execute(database, "DELETE FROM machine WHERE id NOT IN (SELECT machine FROM tuning_run)");
  return runs;
}

// Keeps only the samples and runs that fit.
void restrict_to(const Filter& filter, Contents& contents) {
  auto& [tables, samples] = contents;
  std::set<std::int64_t> runs;
  std::erase_if(samples.rows, [&, &all = tables](const SampleRow& row) {
    const bool goes = !fits(filter, row, all);
    if (!goes) runs.insert(row.run);
    return goes;
  });
  std::erase_if(tables.runs, [&](const auto& run) { return !runs.contains(run.first); });
}

// Copies runs and samples, with all rows that they refer to, in one transaction. Rows whose uid exists already are not
// changed.
Imported copy(const Contents& contents, SQLite::Database& target) {
  const auto& [tables, samples] = contents;
  Imported copied;
  SQLite::Transaction transaction(target, SQLite::TransactionBehavior::IMMEDIATE);
  Writer writer(target);
  std::map<std::int64_t, std::int64_t> runs;  // id in `contents` -> id in `target`
  for (const auto& [id, run] : tables.runs) {
    runs[id] = writer.run(run.value, writer.machine(tables.machines.at(run.value.machine)));
  }
  for (const SampleRow& row : samples.rows) {
    const Run& run = tables.runs.at(row.run).value.run;
    const Library& library = tables.libraries.at(row.library).value;
    const bool is_new = writer.sample(row.sample, library, runs.at(row.run), run.uid, run.machine);
    ++(is_new ? copied.samples : copied.known);
  }
  transaction.commit();
  return copied;
}

}  // namespace

Forgotten Store::forget(const Filter& filter) {
  if (filter.n || !filter.strategy.empty())
    throw Error(Error::Kind::input, "forget() does not select samples by strategy or unknowns");
  if (!filter.run && filter.machine.empty() && filter.library.empty() && !filter.kernel) {
    throw Error(Error::Kind::input, "say which samples to forget: name a run, a machine, a library or a kernel");
  }
  return guarded(impl_->file, [&] {
    Forgotten forgotten;
    SQLite::Transaction transaction(impl_->database, SQLite::TransactionBehavior::IMMEDIATE);
    SQLite::Statement forget(
        impl_->database,
        "DELETE FROM sample WHERE (?1 IS NULL OR run = ?1) AND (?2 = '' OR run IN (SELECT r.id FROM tuning_run r "
        "JOIN machine m ON m.id = r.machine WHERE substr(m.fingerprint, 1, length(?2)) = ?2)) AND (?3 = '' OR "
        "library IN (SELECT id FROM library WHERE name = ?3)) AND (?4 = '' OR kernel = ?4)");
    if (filter.run) forget.bind(1, *filter.run);
    forget.bind(2, filter.machine);
    forget.bind(3, filter.library);
    forget.bind(4, filter.kernel ? std::string(name(*filter.kernel)) : "");
    forgotten.samples = forget.exec();
    forgotten.runs = prune(impl_->database);
    transaction.commit();
    return forgotten;
  });
}

Forgotten Store::forget_all() {
  return guarded(impl_->file, [&] {
    Forgotten forgotten;
    SQLite::Transaction transaction(impl_->database, SQLite::TransactionBehavior::IMMEDIATE);
    forgotten.samples = execute(impl_->database, "DELETE FROM sample");
    forgotten.runs = execute(impl_->database, "DELETE FROM tuning_run");
    prune(impl_->database);
    transaction.commit();
    return forgotten;
  });
}

std::int64_t Store::export_to(const fs::path& file, const Filter& filter) const {
  if (fs::exists(file)) throw Error(Error::Kind::environment, file.string() + ": exists already; name another file");
  if (const fs::path folder = fs::absolute(file).parent_path(); !fs::is_directory(folder)) {
    throw Error(Error::Kind::environment, file.string() + ": there is no folder " + folder.string());
  }
  Contents contents = guarded(impl_->file, [&] { return read_all(impl_->database); });
  restrict_to(filter, contents);
  const fs::path part = file.string() + ".part";  // so that no other process finds a partial file
  std::error_code error;
  fs::remove(part, error);  // left by an interrupted export
  const std::int64_t copied = guarded(part, [&] {
    SQLite::Database target = open_to_write(part, true);  // without a log, which needs a writable folder
    const std::int64_t all = copy(contents, target).samples;
    target.exec("VACUUM");
    return all;
  });
  fs::rename(part, file, error);
  if (error) throw Error(Error::Kind::environment, file.string() + ": cannot be written: " + error.message());
  return copied;
}

Imported Store::import_from(const fs::path& file) {
  const Store source(file, Access::read);
  const Contents contents = guarded(file, [&] { return read_all(source.impl_->database); });
  return guarded(impl_->file, [&] { return copy(contents, impl_->database); });
}

}  // namespace assur::db
