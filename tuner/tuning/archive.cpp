#include "tuning/archive.hpp"

#include "db/libraries.hpp"

namespace assur::tuning {

Archive::Archive(const std::optional<std::filesystem::path>& database, const std::string& profile) : profile_(profile) {
  if (!database) return;
  host_ = db::this_host();
  store_.emplace(*database, db::Access::write);
  messages_ = store_->messages();
  if (const auto unfinished = store_->unfinished_run(host_, profile)) {
    run_ = *unfinished;
    db::Filter filter;
    filter.run = run_;
    earlier_ = store_->samples(filter);
  } else {
    run_ = store_->begin_run(host_, profile);
  }
}

void Archive::add(const CellResult& cell, double pace) {
  if (!store_) return;
  std::vector<Sample> samples;
  for (const Result& r : cell.results) samples.push_back(r.sample);
  store_->add(run_, samples, pace);
}

void Archive::finish(const db::RunResult& result, const std::string& learned) {
  if (!store_) return;
  store_->finish_run(run_, result);
  store_->put_model(host_, profile_, learned);
}

std::optional<double> Archive::usual_pace() const { return store_ ? store_->usual_pace(host_) : std::nullopt; }

}  // namespace assur::tuning
