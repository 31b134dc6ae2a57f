// The part of Store that its source files share.
#pragma once

#include <map>

#include "db/connection.hpp"
#include "db/reader.hpp"
#include "db/store.hpp"

namespace assur::db {

struct Store::Impl {
  std::filesystem::path file;
  Access access;
  std::vector<std::string> messages;
  SQLite::Database database;
  std::map<std::string, Library, std::less<>> at_hand;  // libraries of this build that were needed so far

  Impl(std::filesystem::path file, Access access);
  ~Impl();
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  const Library& library(const std::string& name);
};

// True if the filter selects the row; `tables` has its run, machine and library.
[[nodiscard]] bool fits(const Filter& filter, const SampleRow& row, const Tables& tables);

}  // namespace assur::db
