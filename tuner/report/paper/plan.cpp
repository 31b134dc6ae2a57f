#include "report/paper/plan.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "assur/backend.hpp"
#include "assur/strategy.hpp"

namespace assur::report {
namespace {

constexpr int kQuickTotal = 1500, kQuickUnknowns = 144;
constexpr int kLargeUnknowns = 400;  // of table 5

bool runs_here(std::string_view id) { return find_backend(backends(), id).why_not({}, {}).empty(); }

std::string with(const std::string& head, Reading reading, const Split& split) {
  std::string text = head + (reading == Reading::separate ? "+separate" : "");
  if (split.p * split.q > 1) text += " " + std::to_string(split.p) + "x" + std::to_string(split.q);
  return text;
}

class Contests {
 public:
  Contests(int threads, bool quick, const StandIns& with) : threads_(threads), quick_(quick), with_(with) {}

  std::vector<PaperContest> all() {
    for (const PaperCell& cell : cells_of_table(2)) {
      if (!wanted(cell)) continue;
      for (const Reading r : {Reading::shared, Reading::separate}) {
        for (const Split& s : splits(threads_, 1)) {
          for (const std::string& solver : dense(s)) add(cell, {"GMKL", 1, s.q, r, with("global/" + solver, r, s)});
        }
        add(cell, {"GMA27", 1, 1, r, with("global/" + with_.sparse, r, {})});
      }
      if (with_.ma27) add(cell, {"MA27 itself", 1, 1, Reading::shared, "global/ma27"});
      for (const Split& s : splits(threads_, cell.groups)) add_groups(cell, s);
      add_ours(cell);
    }
    for (const PaperCell& cell : cells_of_table(3)) {
      if (!wanted(cell)) continue;
      add_groups(cell, {1, 1});
      add_groups(cell, {std::min(threads_, 4), 1});
      add_ours(cell);
    }
    for (const PaperCell& cell : cells_of_table(4)) {
      if (!wanted(cell)) continue;
      add_groups(cell, {1, 1});
      add_groups(cell, {std::min(threads_, 4), 1});
      add_ours(cell);
    }
    const auto [wide, narrow] = wide_and_narrow(threads_);
    for (const PaperCell& cell : cells_of_table(5)) {
      if (!wanted(cell)) continue;
      add_groups(cell, wide);
      add_groups(cell, narrow);
      add_ours(cell);
    }
    return std::move(contests_);
  }

 private:
  [[nodiscard]] bool wanted(const PaperCell& cell) const {
    return !quick_ || (cell.iterations == 1 ? cell.total() <= kQuickTotal : cell.n <= kQuickUnknowns);
  }

  [[nodiscard]] static std::string with(const std::string& head, Reading reading, const Split& split) {
    return report::with(head, reading, split);
  }
  // The solvers that can take a split: a BLAS with threads of its own serves one group at a time.
  [[nodiscard]] std::vector<std::string> dense(const Split& s) const {
    std::vector<std::string> out;
    if (s.p == 1 || s.q == 1) out.push_back(with_.dense);
    if (s.q > 1 && !with_.threaded.empty()) out.push_back(with_.threaded);
    return out;
  }

  void add_groups(const PaperCell& cell, const Split& s) {
    for (const Reading r : {Reading::shared, Reading::separate}) {
      if (r == Reading::separate && !reads_twice(cell)) continue;
      for (const std::string& solver : dense(s)) {
        add(cell, {"GEOMP+MKL", s.p, s.q, r, with("groups/" + solver, r, s)});
      }
      if (s.q == 1) add(cell, {"GEOMP+MA27", s.p, 1, r, with("groups/" + with_.sparse, r, s)});
    }
    if (with_.ma27 && s.p * s.q == 1) add(cell, {"MA27 itself", 1, 1, Reading::shared, "groups/ma27"});
  }

  void add_ours(const PaperCell& cell) {
    for (const char* strategy : {"auto", "groups/lanes:8", "irreducible/lanes:8"}) {
      add(cell, {strategy, 1, 1, Reading::shared, strategy});
    }
  }

  void add(const PaperCell& cell, Entrant entrant) {
    auto at =
        std::find_if(contests_.begin(), contests_.end(), [&](const PaperContest& c) { return c.cell.same_work(cell); });
    if (at == contests_.end()) at = contests_.insert(at, {cell, {}});
    const bool known = std::any_of(at->entrants.begin(), at->entrants.end(),
                                   [&](const Entrant& e) { return e.strategy == entrant.strategy; });
    if (!known) at->entrants.push_back(std::move(entrant));
  }

  int threads_;
  bool quick_;
  const StandIns& with_;
  std::vector<PaperContest> contests_;
};

}  // namespace

StandIns stand_ins() {
  StandIns out;
  out.dense = runs_here("lapack") ? "lapack" : "eigen";
  out.threaded = runs_here("team") ? "team" : "";
  out.sparse = runs_here("klu") ? "klu" : "lanes";
  out.ma27 = runs_here("ma27");
  return out;
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
constexpr double kPerEntrant = 0.05, kPerPrepared = 20e-6;                    // s; s for each unknown
constexpr double kStepsAtLeast = 7;  // as the start posture, its verification and three rounds take

bool is_dense(const Entrant& entrant) { return entrant.version == "GMKL" || entrant.version == "GEOMP+MKL"; }

double counted(const PaperCell& cell, const Entrant& entrant) {
  const double factorisations = cell.iterations + (entrant.reading == Reading::separate ? 2.0 : 1.0);
  const auto of = [&](double n, double times) {
    if (!is_dense(entrant)) return times * n * kPerUnknown;
    return times * (2.0 / 3 * n * n * n * kPerFlop + n * n * kPerCopied + n * kPerUnknown);
  };
  if (entrant.version.starts_with("GM")) return of(cell.total(), factorisations);
  return of(cell.terminal, 2) + cell.groups * of(cell.n, factorisations);
}

// What one of them tells of another one: the same solver and formulation.
std::string kind(const Entrant& entrant) {
  return entrant.strategy.substr(0, entrant.strategy.find_first_of("+ ")) + (entrant.q > 1 ? " threaded" : "");
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
