// Stores the samples of a tuning run, and reads those of an interrupted run.
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
  // Continues the last run of this profile if it is unfinished; else begins a new one. Without a database it stores
  // nothing. Throws Error (environment) if the database cannot be written.
  Archive(const std::optional<std::filesystem::path>& database, const std::string& profile);

  // Stores a cell in one transaction. pace: see Store::add().
  void add(const CellResult& cell, double pace);
  // Ends the run. learned: JSON with its results beyond the samples.
  void finish(const db::RunResult& result, const std::string& learned);

  [[nodiscard]] const std::vector<Sample>& earlier() const { return earlier_; }  // samples of the continued run
  [[nodiscard]] std::optional<std::int64_t> run() const { return store_ ? std::optional(run_) : std::nullopt; }
  [[nodiscard]] std::string file() const { return store_ ? store_->file().string() : ""; }
  // Usual pace of this build on this host by all samples so far; empty if there are none.
  [[nodiscard]] std::optional<double> usual_pace() const;
  // Notes of opening the database, for people.
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
