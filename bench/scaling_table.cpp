#include "scaling_table.hpp"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <utility>

#include "assur/strategy.hpp"
#include "decimal.hpp"
#include "output/csv_text.hpp"
#include "output/page.hpp"

namespace assur::bench {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// Figures derived from the measurements of an entry; NaN: does not apply.
struct Figures {
  Strategy strategy;
  int threads = 1;
  Spread seconds;  // by the clock
  Spread telling;
  Spread over_base{kNone, kNone, kNone}, over_one_thread{kNone, kNone, kNone};
  double fastest = kNone, at_best = kNone;  // fastest round, s; its speed-up over that of one thread
  double per_leg = kNone, growth = kNone;
  double p50 = kNone, p99 = kNone, longest = kNone;
};

double fastest(const Entry& entry) {
  return entry.seconds.empty() ? kNone : *std::min_element(entry.seconds.begin(), entry.seconds.end());
}

Figures figures_of(const std::vector<Entry>& contest, const Entry& entry) {
  Figures f;
  f.strategy = parse_strategy(entry.strategy);
  f.threads = f.strategy.run.threads * f.strategy.solver.threads;
  f.seconds = spread(entry.seconds);
  f.telling = spread(telling(entry));
  f.fastest = fastest(entry);
  if (entry.base != Entry::kItself) f.over_base = speed_up(entry, contest[entry.base]);
  if (entry.alone != Entry::kItself) {
    f.over_one_thread = speed_up(entry, contest[entry.alone]);
    f.at_best = fastest(contest[entry.alone]) / f.fastest;
  }
  if (entry.legs > 0) {
    f.per_leg = f.telling.median / entry.legs;
    const Entry& fewest =
        *std::find_if(contest.begin(), contest.end(), [&](const Entry& e) { return e.strategy == entry.strategy; });
    f.growth = f.per_leg / (spread(telling(fewest)).median / fewest.legs);
  }
  if (entry.contender && entry.contender->step_times() != nullptr) {
    const measure::StepTimes::Figures times = entry.contender->step_times()->figures();
    f.p50 = times.median;
    f.p99 = times.p99;
    f.longest = times.max;
  }
  return f;
}

struct Column {
  const char* head;
  int decimals;
  double value;  // for one entry
};

std::vector<Column> columns_of(Show show, const Figures& f) {
  const double microseconds = 1e6;
  std::vector<Column> columns = {
      {"us/step", 3, microseconds * f.telling.median},
      {"+-%", 0, 50 * (f.telling.upper - f.telling.lower) / f.telling.median},
      {"by clock", 3, microseconds * f.seconds.median},
  };
  const auto add = [&](std::initializer_list<Column> more) { columns.insert(columns.end(), more); };
  switch (show) {
    case Show::threads:
      add({{"speed-up", 2, f.over_one_thread.median},
           {"efficiency", 2, f.over_one_thread.median / f.threads},
           {"at best", 2, f.at_best}});
      break;
    case Show::lanes:
      add({{"speed-up", 2, f.over_base.median}, {"efficiency", 2, f.over_base.median / f.strategy.solver.lanes}});
      break;
    case Show::chunks:
      add({{"speed-up", 2, f.over_base.median},
           {"over 1 thread", 2, f.over_one_thread.median},
           {"efficiency", 2, f.over_one_thread.median / f.threads},
           {"at best", 2, f.at_best}});
      break;
    case Show::members:
      add({{"steps/s", 0, 1 / f.telling.median},
           {"x single", 2, f.over_base.median},
           {"per thread", 2, f.over_base.median / f.threads},
           {"over 1 thread", 2, f.over_one_thread.median},
           {"efficiency", 2, f.over_one_thread.median / f.threads},
           {"at best", 2, f.at_best}});
      break;
    case Show::legs:
      add({{"ns/leg", 1, 1e9 * f.per_leg},
           {"growth", 2, f.growth},
           {"over 1 thread", 2, f.over_one_thread.median},
           {"at best", 2, f.at_best}});
      break;
    case Show::single:
      add({{"p50, us", 3, microseconds * f.p50},
           {"p99, us", 3, microseconds * f.p99},
           {"longest, us", 1, microseconds * f.longest},
           {"p99/p50", 2, f.p99 / f.p50},
           {"slowdown", 2, 1 / f.over_base.median}});
      break;
  }
  return columns;
}

std::string exact(double value) { return std::isfinite(value) ? general(value, 9) : ""; }

}  // namespace

void print_table(const std::string& title, const std::vector<Entry>& contest, Show show) {
  using output::Table;
  std::vector<std::string> heads = {"scene", "strategy", ""};
  for (const Column& c : columns_of(show, Figures{})) heads.emplace_back(c.head);
  heads.insert(heads.end(), {"deviation", "residual", ""});
  std::vector<Table::Align> align(heads.size(), Table::Align::right);
  for (const std::size_t text : {std::size_t{0}, std::size_t{1}, std::size_t{2}, heads.size() - 1}) {
    align[text] = Table::Align::left;
  }
  Table table(align);
  table.row(heads);
  for (const Entry& e : contest) {
    std::vector<std::string> row = {e.scene, e.strategy, e.condition};
    if (e.failure.empty()) {
      for (const Column& c : columns_of(show, figures_of(contest, e))) {
        row.push_back(std::isfinite(c.value) ? fixed(c.value, c.decimals) : "");
      }
      row.insert(row.end(), {general(e.deviation, 1), general(e.residual, 1)});
    }
    row.resize(heads.size());
    row.back() = e.failure;
    table.row(std::move(row));
  }
  std::cout << '\n' << title << '\n';
  table.print(std::cout, 2);
  std::cout.flush();
}

void write_csv_header(std::ostream& out) {
  out << "experiment,scene,strategy,condition,p,q,lanes,chunks,members,legs,rounds,seconds_per_step,processor_seconds_"
         "per_step,lower_quartile,"
         "upper_quartile,fastest,steps_per_second,over_base,over_base_lower,over_base_upper,over_one_thread,"
         "over_one_thread_lower,over_one_thread_upper,at_best,efficiency,seconds_per_leg,growth_per_leg,p50,p99,"
         "longest,"
         "deviation,bound,residual,outcome\n";
}

void write_csv_rows(std::ostream& out, const std::string& experiment, const std::vector<Entry>& contest) {
  for (const Entry& e : contest) {
    const Figures f = figures_of(contest, e);
    out << experiment << ',' << output::csv_text(e.scene) << ',' << output::csv_text(e.strategy) << ','
        << output::csv_text(e.condition);
    for (const int count : {f.strategy.run.threads, f.strategy.solver.threads, f.strategy.solver.lanes,
                            f.strategy.run.chunks, e.members, e.legs}) {
      out << ',' << count;
    }
    out << ',' << e.seconds.size();
    for (const double value : {f.seconds.median,
                               f.seconds.lower,
                               f.seconds.upper,
                               f.fastest,
                               1 / f.seconds.median,
                               f.over_base.median,
                               f.over_base.lower,
                               f.over_base.upper,
                               f.over_one_thread.median,
                               f.over_one_thread.lower,
                               f.over_one_thread.upper,
                               f.at_best,
                               f.over_one_thread.median / f.threads,
                               f.per_leg,
                               f.growth,
                               f.p50,
                               f.p99,
                               f.longest,
                               e.deviation,
                               e.bound,
                               e.residual}) {
      out << ',' << exact(value);
    }
    out << ',' << output::csv_text(e.failure.empty() ? "ok" : e.failure) << '\n';
  }
  out.flush();
}

}  // namespace assur::bench
