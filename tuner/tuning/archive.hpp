// Where the samples of a tuning run go, and what an interrupted one has left there.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "db/store.hpp"
#include "tuning/campaign.hpp"

namespace assur::tuning {

class Archive {
 public:
  // database: none, and samples are stored nowhere. Goes on with the last run of this profile if it was not finished,
  // else begins one. Throws Error (environment) if the database cannot be written.
  Archive(const std::optional<std::filesystem::path>& database, const std::string& profile);

  // In one transaction. pace: as Store::add() has it.
  void add(const CellResult& cell, double pace);
  // learned: JSON, what the run found beside its samples.
  void finish(const db::RunResult& result, const std::string& learned);

  [[nodiscard]] const std::vector<Sample>& earlier() const { return earlier_; }  // of the run that is gone on with
  [[nodiscard]] std::optional<std::int64_t> run() const { return store_ ? std::optional(run_) : std::nullopt; }
  [[nodiscard]] std::string file() const { return store_ ? store_->file().string() : ""; }
  // Of this build on this host, as all samples so far tell it; nullopt: there are none.
  [[nodiscard]] std::optional<double> usual_pace() const;
  // What opening the database has found, for people.
  [[nodiscard]] const std::vector<std::string>& messages() const { return messages_; }

 private:
  std::optional<db::Store> store_;  // empty: samples are stored nowhere
  db::Host host_;
  std::string profile_;
  std::int64_t run_ = 0;
  std::vector<Sample> earlier_;
  std::vector<std::string> messages_;
};

}  // namespace assur::tuning
