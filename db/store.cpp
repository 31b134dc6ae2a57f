#include "db/store.hpp"

#include <SQLiteCpp/VariadicBind.h>

#include <random>

#include "db/aside.hpp"
#include "db/checksum.hpp"
#include "db/store_impl.hpp"

namespace assur::db {
namespace {

SQLite::Database open(const std::filesystem::path& file, Access access, std::vector<std::string>& messages) {
  return access == Access::write ? open_or_put_aside(file, messages) : open_to_read_checked(file);
}

}  // namespace

std::string_view name(Grade grade) noexcept {
  switch (grade) {
    case Grade::good:
      return "good";
    case Grade::fair:
      return "fair";
    case Grade::noisy:
      return "noisy";
  }
  return "";
}

std::string new_uid() {
  // The system provides a new seed each time, so two processes, or two forks of one process, never draw the same
  // numbers.
  std::random_device device;
  const auto draw = [&] { return std::uint64_t{device()} << 32 | device(); };
  return hexadecimal(draw()) + hexadecimal(draw());
}

Store::Impl::Impl(std::filesystem::path path, Access how)
    : file(std::move(path)), access(how), database(open(file, access, messages)) {}

Store::Impl::~Impl() {
  if (access == Access::write) leave(database);
}

const Library& Store::Impl::library(const std::string& name) {
  const auto found = at_hand.find(name);
  return found != at_hand.end() ? found->second : at_hand.emplace(name, library_at_hand(name)).first->second;
}

Store::Store(std::filesystem::path file, Access access) : impl_(std::make_unique<Impl>(std::move(file), access)) {}
Store::Store(Store&&) noexcept = default;
Store& Store::operator=(Store&&) noexcept = default;
Store::~Store() = default;

const std::filesystem::path& Store::file() const { return impl_->file; }
const std::vector<std::string>& Store::messages() const { return impl_->messages; }

bool fits(const Filter& filter, const SampleRow& row, const Tables& tables) {
  return (!filter.run || *filter.run == row.run) &&
         tables.runs.at(row.run).value.run.machine.starts_with(filter.machine) &&
         (filter.library.empty() || tables.libraries.at(row.library).value.name == filter.library) &&
         (!filter.kernel || *filter.kernel == row.sample.kernel) && (!filter.n || *filter.n == row.sample.shape.n) &&
         (filter.strategy.empty() || to_string(row.sample.strategy).find(filter.strategy) != std::string::npos);
}

std::vector<Sample> Store::samples(const Filter& filter) const {
  return guarded(impl_->file, [&] {
    auto [tables, samples] = read_all(impl_->database);
    at_usual_pace(samples, tables);
    std::vector<Sample> found;
    for (SampleRow& row : samples.rows) {
      if (fits(filter, row, tables)) found.push_back(std::move(row.sample));
    }
    return found;
  });
}

std::optional<double> Store::usual_pace(const Host& host) const {
  return guarded(impl_->file, [&]() -> std::optional<double> {
    SQLite::Statement find(impl_->database,
                           "SELECT slowness FROM usual_pace u JOIN machine m ON m.id = u.machine "
                           "WHERE fingerprint = ?1 AND assur = ?2 AND build = ?3");
    SQLite::bind(find, host.fingerprint(), std::string(assur_version()), library_at_hand("assur").build);
    return find.executeStep() ? std::optional(find.getColumn(0).getDouble()) : std::nullopt;
  });
}

Counts Store::counts(const std::string& machine) const {
  return guarded(impl_->file, [&] {
    const auto [tables, samples] = read_all(impl_->database);
    Counts counts{static_cast<std::int64_t>(samples.rows.size()), samples.unknown};
    for (const SampleRow& row : samples.rows) {
      const std::int64_t measured_on = tables.runs.at(row.run).value.machine;
      if (tables.machines.at(measured_on).fingerprint() != machine) continue;
      const Library& library = tables.libraries.at(row.library).value;
      if (library != impl_->library(library.name)) ++counts.stale;
    }
    return counts;
  });
}

void require_readable(const std::filesystem::path& file) { (void)open_to_read(file); }

}  // namespace assur::db
