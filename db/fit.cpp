#include "db/fit.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <set>
#include <span>

#include "db/checksum.hpp"

namespace assur::db {
namespace {

// In four strands, each of which waits for its own multiplications only: every program that opens the database sums up
// all of it.
std::int64_t sum_of(std::span<const std::byte> bytes) {
  constexpr std::size_t kWord = sizeof(std::int64_t);
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

void keep(SQLite::Database& database, std::int64_t machine, const PerformanceModel& model) {
  const std::vector<std::byte> content = model.bytes();
  SQLite::Statement put(database, "INSERT OR REPLACE INTO fit (machine, content, checksum) VALUES (?1, ?2, ?3)");
  put.bind(1, machine);
  put.bind(2, content.data(), static_cast<int>(content.size()));
  put.bind(3, sum_of(content));
  put.exec();
}

}  // namespace

void fit_models(SQLite::Database& database, const IsAtHand& is_at_hand) {
  SQLite::Transaction transaction(database, SQLite::TransactionBehavior::IMMEDIATE);
  database.exec("DELETE FROM fit");
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
    keep(database, machine, PerformanceModel(std::move(samples)));
  }
  transaction.commit();
}

std::optional<PerformanceModel> fitted_model(SQLite::Database& database, std::int64_t machine, std::string source) {
  SQLite::Statement find(database, "SELECT content, checksum FROM fit WHERE machine = ?1");
  find.bind(1, machine);
  if (!find.executeStep()) return std::nullopt;
  const SQLite::Column content = find.getColumn(0);
  const auto size = static_cast<std::size_t>(content.getBytes());
  const auto* const bytes = static_cast<const std::byte*>(content.getBlob());
  if (sum_of({bytes, size}) != find.getColumn(1).getInt64()) return std::nullopt;
  return PerformanceModel::from_bytes({bytes, size}, std::move(source));
}

}  // namespace assur::db
