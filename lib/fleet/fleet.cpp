#include "assur/fleet.hpp"

#include <algorithm>
#include <atomic>
#include <string>
#include <utility>

#include "fleet/linkage_run.hpp"
#include "numbers.hpp"
#include "parallel/team.hpp"
#include "runs/row_consumers.hpp"
#include "simulation/run_arguments.hpp"

namespace assur {
namespace {

constexpr std::size_t kTogether = 32;  // linkages that a thread takes at once

// Throws for a linkage that is not valid.
void take(const Linkage& linkage, std::size_t i, PreparedLinkage& to) {
  const std::string trouble = to.take(linkage);
  if (trouble.empty()) return;
  throw Error(Error::Kind::input, "linkage " + std::to_string(i) + " (counted from 0): " + trouble);
}

void count(const LinkageMotion& motion, std::int64_t dyads, FleetReport& report) {
  ++report.linkages;
  report.done += motion.status.arrived() ? 1 : 0;
  report.inaccurate += motion.status.code == Code::inaccurate ? 1 : 0;
  report.not_closed += motion.path.empty() ? 1 : 0;
  report.jammed += !motion.status.arrived() && !motion.path.empty() ? 1 : 0;
  report.dyads += dyads * static_cast<std::int64_t>(motion.path.size());
  report.residual = std::max(report.residual, motion.residual);
}

void merge(FleetReport& sum, const FleetReport& o) {
  sum.linkages += o.linkages;
  sum.done += o.done;
  sum.inaccurate += o.inaccurate;
  sum.not_closed += o.not_closed;
  sum.jammed += o.jammed;
  sum.dyads += o.dyads;
  sum.divided += o.divided;
  sum.residual = std::max(sum.residual, o.residual);
}

}  // namespace

Fleet::Fleet(std::vector<Linkage> linkages) : size_(linkages.size()) {
  PreparedLinkage check;
  for (std::size_t i = 0; i < size_; ++i) take(linkages[i], i, check);
  source_ = [stored = std::make_shared<const std::vector<Linkage>>(std::move(linkages))](std::size_t i, Linkage& to) {
    to = (*stored)[i];
  };
}

Fleet::Fleet(std::size_t linkages, Source source) : size_(linkages), source_(std::move(source)) {}

FleetReport Fleet::stream(const Sink& sink, std::span<const double> times, const FleetOptions& options) const {
  const std::size_t first = options.first, last = options.last == FleetOptions::kAll ? size_ : options.last;
  if (times.empty()) throw Error(Error::Kind::input, "a fleet needs at least one time");
  check_times(times);
  if (first > last || last > size_) {
    throw Error(Error::Kind::input, "a fleet of " + std::to_string(size_) + " linkages has no range from " +
                                        std::to_string(first) + " to " + std::to_string(last));
  }
  if (!(options.accuracy > 0)) throw Error(Error::Kind::input, "the accuracy of a fleet must be positive");
  if (options.threads < 1) throw Error(Error::Kind::input, "a fleet needs at least one thread");
  const std::size_t parts = std::max<std::size_t>((last - first + kTogether - 1) / kTogether, 1);
  Team team(static_cast<int>(std::min(parts, static_cast<std::size_t>(options.threads))));
  std::vector<FleetReport> reports(static_cast<std::size_t>(team.size()));
  std::atomic<std::size_t> next{first};
  std::atomic<std::int64_t> done{0};
  std::atomic<bool> stopped{false}, failed{false};
  const auto wants_stop = [&] {
    return options.observer &&
           options.observer(done.load(std::memory_order_relaxed), static_cast<std::int64_t>(last - first));
  };
  team.run([&](int rank) {
    FleetReport& report = reports[static_cast<std::size_t>(rank)];
    Linkage linkage;
    PreparedLinkage prepared;
    LinkageRun run;
    try {
      for (std::size_t begin; (begin = next.fetch_add(kTogether)) < last;) {
        for (std::size_t i = begin; i < std::min(begin + kTogether, last); ++i) {
          if (failed.load(std::memory_order_relaxed) || stopped.load(std::memory_order_relaxed)) return;
          if (rank == 0 && wants_stop()) {
            stopped = true;
            return;
          }
          source_(i, linkage);
          take(linkage, i, prepared);
          const LinkageMotion& motion = run.run(prepared, times, options);
          count(motion, prepared.dyads(), report);
          report.divided = run.divided();
          sink(i, motion);
          ++done;
        }
      }
    } catch (...) {
      failed = true;  // the other threads need not continue
      throw;
    }
  });
  if (!stopped) (void)wants_stop();  // all are done; nothing is left to stop
  FleetReport sum;
  for (const FleetReport& report : reports) merge(sum, report);
  sum.interrupted = stopped;
  return sum;
}

FleetSummary Fleet::summarize(std::span<const double> times, const FleetOptions& options) const {
  FleetSummary out;
  out.members.resize(size_);
  for (FleetSummary::Member& member : out.members) {
    member.status.code = Code::interrupted;
    member.reached = kNan;
  }
  static constexpr std::array<std::size_t, 2> kColumns = {0, 1};
  const auto sink = [&](std::size_t i, const LinkageMotion& motion) {
    std::array<ColumnSummary, 2> columns;
    RowSummary summary(kColumns, columns);
    for (std::size_t k = 0; k < motion.path.size(); ++k) summary.add_row(times[k], motion.path[k].data());
    summary.finish();
    out.members[i] = {motion.status, motion.reached, columns[0], columns[1]};
  };
  (void)stream(sink, times, options);
  return out;
}

}  // namespace assur
