// The model that was fitted to the samples of a machine, kept with them: reading all samples and fitting takes most of
// what a program waits for before its first step.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "db/contents.hpp"

namespace assur::db {

using IsAtHand = std::function<bool(const Library&)>;

// For every machine whose samples are all whole, known and of libraries at hand. Throws SQLite::Exception.
void fit_models(SQLite::Database& database, const IsAtHand& is_at_hand);

struct Fit {
  PerformanceModel model;
  bool of_this_file = false;  // bit for bit; else its samples have to be looked at
};

// nullopt: there is none, or none that can be believed. Throws SQLite::Exception.
[[nodiscard]] std::optional<Fit> find_fit(SQLite::Database& database, std::int64_t machine, std::string source);

}  // namespace assur::db
