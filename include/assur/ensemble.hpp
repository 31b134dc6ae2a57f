// Throughput: many variants of one mechanism over the same times, side by side in SIMD lanes and threads.
#pragma once

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "assur/plan.hpp"
#include "assur/report.hpp"
#include "assur/simulator.hpp"

namespace assur {

// Results of an ensemble in SI units, contiguous [member][time][output]; NaN in rows that a member did not reach.
// Copies share the values.
class EnsembleTrajectory {
 public:
  [[nodiscard]] const std::vector<std::string>& columns() const { return columns_; }
  [[nodiscard]] const std::vector<double>& times() const { return times_; }
  [[nodiscard]] std::size_t members() const { return rows_.size(); }
  // Rows of one member that are there.
  [[nodiscard]] std::size_t rows(std::size_t member) const { return rows_[member]; }
  [[nodiscard]] std::span<const double> row(std::size_t member, std::size_t k) const {
    return {values_.get() + (member * times_.size() + k) * columns_.size(), columns_.size()};
  }
  [[nodiscard]] double operator()(std::size_t member, std::size_t row, std::size_t column) const {
    return this->row(member, row)[column];
  }
  [[nodiscard]] std::span<const double> values() const {
    return {values_.get(), rows_.size() * times_.size() * columns_.size()};
  }

 private:
  friend class Ensemble;
  std::vector<std::string> columns_;
  std::vector<double> times_;
  std::vector<std::size_t> rows_;
  // Memory as it comes: each thread is the first to write where its members are.
  std::shared_ptr<double[]> values_;
};

// member, counted from 1, t, then every column: the shortest text that reads back as the same double, nothing for NaN.
void write_csv(std::ostream& out, const EnsembleTrajectory& trajectory);

// Safe as simulators are: one ensemble for each thread of the program's, one thread at a time for each ensemble, and
// the child of a fork() may run those that were not running.
class Ensemble {
 public:
  // How one member ended.
  struct Outcome {
    Status status;       // ok, inaccurate (it arrived all the same), or why it stopped
    double reached = 0;  // last time with a valid posture
    std::string cannot;  // why it could not be started; empty: it was
    bool alone = false;  // not in lockstep with others, from the time `alone_from` on
    double alone_from = 0;
    std::vector<Event> events;
  };

  // `member` prepares the i-th variant; it is called here, in order, on the calling thread. What it throws as Error of
  // kind input or numerical is the outcome of that member; if all throw, so does this. The first member that can be
  // prepared gives the plan: W lanes of a strategy are W members, p threads take packs of members in turn. Members with
  // another structure or start time run alone, and so do those with callbacks, but for copies of one Prepared; a member
  // with other outputs than the first cannot take part. Throws Error: input for no members or a deadline in `limits`,
  // environment if a backend of the plan cannot run here.
  Ensemble(std::size_t members, const std::function<Prepared(std::size_t)>& member, StepLimits limits = {});
  Ensemble(Ensemble&&) noexcept;
  Ensemble& operator=(Ensemble&&) noexcept;
  ~Ensemble();

  // Every member over the time grid of the first one, or over `times`, which begin with its start. The results do not
  // depend on the number of threads, and on that of lanes by their last bits only (the bound: docs/strategies.md).
  // `observer` (rows done, of all members) is called on the calling thread and may return false to stop. Laws and
  // callbacks are called by all threads of the plan; what they throw comes from run(). Throws Error: input if `times`
  // begin elsewhere, descend anywhere or are not finite; environment if there is no memory for the results.
  EnsembleTrajectory run(const Simulator::Observer& observer = {});
  EnsembleTrajectory run(std::span<const double> times, const Simulator::Observer& observer = {});

  [[nodiscard]] std::size_t members() const;
  [[nodiscard]] const Prepared& prepared() const;  // of the first member
  // Of the last run: all members together, and one by one.
  [[nodiscard]] const Report& report() const;
  [[nodiscard]] const std::vector<Outcome>& outcomes() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace assur
