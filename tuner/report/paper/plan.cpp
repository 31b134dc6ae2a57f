#include "report/paper/plan.hpp"

#include <algorithm>
#include <utility>

#include "assur/backend.hpp"
#include "backends/backends.hpp"

namespace assur::report {
namespace {

constexpr int kQuickTotal = 1500, kQuickUnknowns = 144;  // largest mechanism and group of `report --quick`
constexpr int kLargeUnknowns = 400;                      // large groups of table 5

constexpr std::string_view kMa27 = "ma27";    // the solver of the paper
constexpr std::string_view kSixLanes = ":8";  // all six groups at once on a GPU

// The first backend of this build that runs here and has these properties; "" if there is none.
std::string first(bool (*is)(const Backend&)) {
  for (const Backend& b : backends()) {
    if (is(b) && b.why_not({}, {}).empty()) return std::string(b.id);
  }
  return "";
}

class Contests {
 public:
  Contests(int threads, bool quick, const StandIns& with) : threads_(threads), quick_(quick), with_(with) {}

  std::vector<PaperContest> all() {
    const auto [wide, narrow] = wide_and_narrow(threads_);
    const std::vector<Split> few = {{1, 1}, {std::min(threads_, 4), 1}};
    for (const PaperCell& cell : cells_of_table(2)) {
      if (!wanted(cell)) continue;
      add_global(cell);
      add_groups(cell, splits(threads_, cell.groups));
    }
    for (const auto& [table, splits] : {std::pair(3, few), {4, few}, {5, {wide, narrow}}}) {
      for (const PaperCell& cell : cells_of_table(table)) {
        if (!wanted(cell)) continue;
        add_groups(cell, splits);
        if (table >= 4) add_devices(cell);
      }
    }
    return std::move(contests_);
  }

 private:
  [[nodiscard]] bool wanted(const PaperCell& cell) const {
    return !quick_ || (cell.iterations == 1 ? cell.total() <= kQuickTotal : cell.n <= kQuickUnknowns);
  }

  // The solvers for a split: a BLAS with its own threads solves one group at a time.
  [[nodiscard]] std::vector<std::string> dense(const Split& s) const {
    std::vector<std::string> out;
    if (s.p == 1 || s.q == 1) out.push_back(with_.dense);
    if (s.q > 1 && !with_.threaded.empty()) out.push_back(with_.threaded);
    return out;
  }

  void add_global(const PaperCell& cell) {
    for (const Reading r : {Reading::shared, Reading::separate}) {
      for (const Split& s : splits(threads_, 1)) {
        for (const std::string& solver : dense(s)) add(cell, kGlobalDense, "global/" + solver, s, r);
      }
      add(cell, kGlobalSparse, "global/" + with_.sparse, {}, r);
    }
    if (with_.ma27) add(cell, "MA27 itself", "global/" + std::string(kMa27));
  }

  void add_groups(const PaperCell& cell, const std::vector<Split>& splits) {
    for (const Split& s : splits) {
      for (const Reading r : {Reading::shared, Reading::separate}) {
        if (r == Reading::separate && !reads_twice(cell)) continue;
        for (const std::string& solver : dense(s)) add(cell, kDense, "groups/" + solver, s, r);
        if (s.q == 1) add(cell, kSparse, "groups/" + with_.sparse, s, r);
      }
      if (with_.ma27 && s == Split{}) add(cell, "MA27 itself", "groups/" + std::string(kMa27));
    }
    for (const std::string& strategy : ours()) add(cell, strategy, strategy);
  }

  void add_devices(const PaperCell& cell) {
    for (const std::string& id : with_.devices) {
      for (const Reading r : {Reading::shared, Reading::separate}) {
        if (r == Reading::separate && !reads_twice(cell)) continue;
        add(cell, kGpu, "groups/" + id, {}, r);
        if (properties_of(id).fills_lanes) add(cell, kGpu, "groups/" + id + std::string(kSixLanes), {}, r);
      }
    }
  }

  void add(const PaperCell& cell, std::string_view version, std::string strategy, const Split& split = {},
           Reading reading = Reading::shared) {
    if (reading == Reading::separate) strategy += "+separate";
    if (split != Split{}) strategy += " " + text_of(split);
    auto at =
        std::find_if(contests_.begin(), contests_.end(), [&](const PaperContest& c) { return c.cell.same_work(cell); });
    if (at == contests_.end()) at = contests_.insert(at, {cell, {}});
    const bool known =
        std::any_of(at->entrants.begin(), at->entrants.end(), [&](const Entrant& e) { return e.strategy == strategy; });
    if (!known) at->entrants.push_back({std::string(version), split, reading, std::move(strategy)});
  }

  int threads_;
  bool quick_;
  const StandIns& with_;
  std::vector<PaperContest> contests_;
};

}  // namespace

StandIns stand_ins() {
  StandIns out;
  out.dense = first([](const Backend& b) { return b.dense && b.threads && !b.own_loops; });  // a BLAS like MKL
  if (out.dense.empty()) out.dense = first([](const Backend& b) { return b.dense; });
  out.threaded = first([](const Backend& b) { return b.dense && b.threads && b.own_loops; });
  // Like MA27: one matrix after another, without allocations.
  out.sparse = first([](const Backend& b) { return !b.dense && b.keeps_pivots && !b.fills_lanes; });
  if (out.sparse.empty()) out.sparse = first([](const Backend& b) { return !b.dense && b.keeps_pivots; });
  out.ma27 = find_backend(backends(), kMa27).why_not({}, {}).empty();
  for (const Backend& b : backends()) {
    if (b.device && b.why_not({}, {}).empty()) out.devices.emplace_back(b.id);
  }
  return out;
}

const std::vector<std::string>& ours() {
  static const std::string kLanes = first([](const Backend& b) { return b.fills_lanes; }) + ":8";
  static const std::vector<std::string> kOurs = {std::string(kAuto), "groups/" + kLanes, "irreducible/" + kLanes};
  return kOurs;
}

std::vector<Split> splits(int threads, int groups) {
  std::vector<int> steps;
  for (int s = 1; s <= std::max(threads, 1); s += s < 4 ? 1 : s < 8 ? 2 : s < 16 ? 4 : s < 32 ? 8 : 16) {
    steps.push_back(s);
  }
  std::vector<Split> out;
  for (const int p : steps) {
    for (const int q : steps) {
      if (p <= groups && p * q <= threads) out.push_back({p, q});
    }
  }
  return out;
}

WideAndNarrow wide_and_narrow(int threads) {
  const int few = threads >= 6 ? 2 : 1;
  const int many = std::clamp(threads / few, 1, 6);
  return {{many, few}, {few, many}};
}

bool reads_twice(const PaperCell& cell) { return cell.iterations == 1 || cell.n < kLargeUnknowns; }

std::vector<PaperContest> contests(int threads, bool quick, const StandIns& with) {
  return Contests(threads, quick, with).all();
}

// ---- costs

namespace {

constexpr double kPerFlop = 0.5e-9, kPerCopied = 2e-9, kPerUnknown = 0.3e-6;  // s, of a typical processor
constexpr double kPerLaunch = 1e-4, kPerColumn = 1e-6, kPerFlopOfGpu = 1e-12, kPerCopiedToGpu = 1e-9;  // s, of a GPU
constexpr double kPerEntrant = 0.05, kPerPrepared = 20e-6;  // s; s for each unknown
constexpr double kStepsAtLeast = 7;  // steps for the start posture, the verification and three rounds

bool is_dense(const Entrant& e) { return e.version == kGlobalDense || e.version == kDense; }

double counted(const PaperCell& cell, const Entrant& entrant) {
  const double factorisations = cell.iterations + (entrant.reading == Reading::separate ? 2.0 : 1.0);
  const auto of = [&](double n, double times) {
    if (entrant.version == kGpu) {
      return times * (kPerLaunch + n * kPerColumn + n * n * kPerCopiedToGpu + 2.0 / 3 * n * n * n * kPerFlopOfGpu);
    }
    if (!is_dense(entrant)) return times * n * kPerUnknown;
    return times * (2.0 / 3 * n * n * n * kPerFlop + n * n * kPerCopied + n * kPerUnknown);
  };
  if (entrant.version.starts_with("GM")) return of(cell.total(), factorisations);
  return of(cell.terminal, 2) + cell.groups * of(cell.n, factorisations);
}

// Entrants of one kind, with the same solver and formulation, share a correction of their costs.
std::string kind(const Entrant& entrant) {
  return entrant.strategy.substr(0, entrant.strategy.find_first_of("+ ")) + (entrant.split.q > 1 ? " threaded" : "");
}

}  // namespace

double PaperCosts::step(const PaperCell& cell, const Entrant& entrant) const {
  const auto at = correction_.find(kind(entrant));
  return counted(cell, entrant) * (at == correction_.end() ? 1 : at->second);
}

double PaperCosts::least(const PaperCell& cell, const Entrant& entrant) const {
  return kPerEntrant + kPerPrepared * cell.total() + kStepsAtLeast * step(cell, entrant);
}

void PaperCosts::learn(const PaperCell& cell, const Entrant& entrant, double seconds) {
  correction_[kind(entrant)] = seconds / counted(cell, entrant);
}

std::vector<std::vector<bool>> affordable(std::span<const PaperContest> contests, const PaperCosts& costs,
                                          double seconds) {
  struct Item {
    double cost;
    std::size_t contest, entrant;
  };
  std::vector<Item> items;
  std::vector<std::vector<bool>> out;
  for (std::size_t c = 0; c < contests.size(); ++c) {
    out.emplace_back(contests[c].entrants.size(), false);
    for (std::size_t e = 0; e < contests[c].entrants.size(); ++e) {
      items.push_back({costs.least(contests[c].cell, contests[c].entrants[e]), c, e});
    }
  }
  std::stable_sort(items.begin(), items.end(), [](const Item& a, const Item& b) { return a.cost < b.cost; });
  for (const Item& item : items) {
    if (item.cost > seconds) break;
    seconds -= item.cost;
    out[item.contest][item.entrant] = true;
  }
  return out;
}

}  // namespace assur::report
