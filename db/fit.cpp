#include "db/fit.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <memory>
#include <new>
#include <set>
#include <span>

#include "db/checksum.hpp"

namespace assur::db {
namespace {

constexpr std::size_t kWord = sizeof(std::int64_t);

// In four strands, each of which waits for its own multiplications only: every program that opens the database sums up
// all of it.
std::int64_t sum_of(std::span<const std::byte> bytes) {
  std::array<Checksum, 4> strands;
  for (; bytes.size() >= strands.size() * kWord; bytes = bytes.subspan(strands.size() * kWord)) {
    for (std::size_t i = 0; i < strands.size(); ++i) {
      std::int64_t word = 0;
      std::memcpy(&word, &bytes[i * kWord], kWord);
      strands[i] << word;
    }
  }
  Checksum sum;
  for (const Checksum& strand : strands) sum << static_cast<std::int64_t>(strand.value());
  sum << std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return static_cast<std::int64_t>(sum.value());
}

// Over all pages of the file but those of the table `fit`, and without the header, which counts changes.
std::int64_t sum_of_samples(SQLite::Database& database) {
  constexpr std::size_t kHeader = 100;
  const auto page_size = static_cast<std::size_t>(database.execAndGet("PRAGMA page_size").getInt());
  std::set<std::size_t> left_out;
  SQLite::Statement own(database, "SELECT pageno FROM dbstat WHERE name = 'fit'");
  while (own.executeStep()) left_out.insert(static_cast<std::size_t>(own.getColumn(0).getInt64()) - 1);
  sqlite3_int64 size = 0;
  const std::unique_ptr<unsigned char, void (*)(void*)> image(sqlite3_serialize(database.getHandle(), "main", &size, 0),
                                                              sqlite3_free);
  if (!image) throw SQLite::Exception("its pages cannot be read", SQLITE_CORRUPT);
  const std::span<const std::byte> bytes(reinterpret_cast<const std::byte*>(image.get()),
                                         static_cast<std::size_t>(size));
  Checksum sum;
  for (std::size_t page = 0; page * page_size < bytes.size(); ++page) {
    if (left_out.contains(page)) continue;
    const std::size_t from = page == 0 ? kHeader : 0;
    sum << sum_of(bytes.subspan(page * page_size + from, page_size - from));
  }
  return static_cast<std::int64_t>(sum.value());
}

void keep(SQLite::Database& database, std::int64_t machine, const std::vector<std::byte>& model, std::int64_t samples) {
  std::vector<std::byte> content = model;
  content.resize(model.size() + kWord);
  std::memcpy(&content[model.size()], &samples, kWord);
  SQLite::Statement put(database,
                        "INSERT INTO fit (machine, content, checksum) VALUES (?1, ?2, ?3) "
                        "ON CONFLICT DO UPDATE SET content = excluded.content, checksum = excluded.checksum");
  put.bind(1, machine);
  put.bind(2, content.data(), static_cast<int>(content.size()));
  put.bind(3, sum_of(content));
  put.exec();
}

}  // namespace

void fit_models(SQLite::Database& database, const IsAtHand& is_at_hand) {
  SQLite::Transaction transaction(database, SQLite::TransactionBehavior::IMMEDIATE);
  database.exec("DELETE FROM fit");
  if (sqlite3_compileoption_used("ENABLE_DBSTAT_VTAB") == 0) return transaction.commit();
  std::map<std::int64_t, std::vector<std::byte>> models;
  const Tables tables = read_tables(database);
  std::set<std::int64_t> at_hand;
  for (const auto& [id, library] : tables.libraries) {
    if (is_at_hand(library.value)) at_hand.insert(id);
  }
  for (const auto& [machine, host] : tables.machines) {
    std::vector<std::int64_t> runs;
    for (const auto& [id, run] : tables.runs) {
      if (run.value.machine == machine) runs.push_back(id);
    }
    if (runs.empty()) continue;
    Samples found = read_samples(database, tables, Care::trusting, runs);
    const auto is_of_another = [&](const SampleRow& row) { return !at_hand.contains(row.library); };
    const auto& rows = found.rows;
    if (rows.empty() || found.damaged > 0 || found.unknown > 0) continue;
    if (std::any_of(rows.begin(), rows.end(), is_of_another)) continue;
    std::vector<Sample> samples;
    for (SampleRow& row : found.rows) samples.push_back(std::move(row.sample));
    models[machine] = PerformanceModel(std::move(samples)).bytes();
  }
  // First their room, then the sum over what is around it.
  for (const auto& [machine, model] : models) keep(database, machine, model, 0);
  const std::int64_t samples = models.empty() ? 0 : sum_of_samples(database);
  for (const auto& [machine, model] : models) keep(database, machine, model, samples);
  transaction.commit();
}

std::optional<Fit> find_fit(SQLite::Database& database, std::int64_t machine, std::string source) {
  SQLite::Statement find(database, "SELECT content, checksum FROM fit WHERE machine = ?1");
  find.bind(1, machine);
  if (!find.executeStep()) return std::nullopt;
  const SQLite::Column content = find.getColumn(0);
  const std::span bytes(static_cast<const std::byte*>(content.getBlob()), static_cast<std::size_t>(content.getBytes()));
  if (bytes.size() < kWord || sum_of(bytes) != find.getColumn(1).getInt64()) return std::nullopt;
  std::int64_t samples = 0;
  std::memcpy(&samples, &bytes[bytes.size() - kWord], kWord);
  auto model = PerformanceModel::from_bytes(bytes.first(bytes.size() - kWord), std::move(source));
  if (!model) return std::nullopt;
  return Fit{*std::move(model), samples == sum_of_samples(database)};
}

}  // namespace assur::db
