#include "report/paper/paper.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "assur/status.hpp"
#include "decimal.hpp"

namespace assur::report {
namespace {

constexpr std::array kMachines = {
    PaperMachine{"i5", "Core i5-2400, 4 cores", 15}, PaperMachine{"E5", "2 x Xeon E5-2620, 12 cores", 95},
    PaperMachine{"RP2", "Raspberry Pi 2 B, 4 cores", 4}, PaperMachine{"RP3", "Raspberry Pi 3 B, 4 cores", 5},
    PaperMachine{"GTX", "GeForce GTX 950, MAGMA", 365}};

// A column of a table: for each cell one number for all steps.
struct Column {
  struct {
    int table;
    std::string_view version, machine;
  } of;
  std::vector<Split> splits;  // splits of the first cells; the last one applies to all further cells
  std::vector<double> seconds;
  std::vector<double> joules = {};
};

const std::vector<Column>& columns() {
  static const std::vector<Column> kColumns = {
      {{2, kGlobalDense, "i5"},
       {{1, 1}, {1, 3}, {1, 3}, {1, 4}},
       {2.52, 9.11, 32.43, 151.94, 1127.25, 3579.63, 7149.04, 22840.51}},
      {{2, kGlobalSparse, "i5"}, {{1, 1}}, {4.19, 9.02, 13.45, 25.29, 48.26, 71.27, 94.19, 140.13}},
      {{2, kDense, "i5"},
       {{3, 1}, {3, 1}, {3, 1}, {3, 1}, {3, 1}, {3, 1}, {3, 1}, {1, 4}},
       {0.53, 1.13, 2.39, 8.40, 42.33, 147.41, 323.77, 828.97}},
      {{2, kSparse, "i5"}, {{3, 1}}, {0.74, 1.40, 2.84, 5.71, 12.23, 18.23, 24.35, 36.59}},
      {{3, kDense, "i5"}, {{1, 1}}, {0.85, 2.13, 5.54, 20.18, 2.07, 4.91, 14.02, 52.71, 3.00, 7.15, 20.77, 78.89}},
      {{3, kSparse, "i5"}, {{1, 1}}, {1.9, 3.33, 7.24, 15.96, 4.86, 8.61, 18.69, 41.43, 7.18, 12.96, 27.95, 61.01}},
      {{3, kDense, "i5"}, {{4, 1}}, {0.65, 1.42, 2.72, 9.61, 0.98, 2.35, 4.65, 16.16, 1.35, 2.62, 6.53, 23.47}},
      {{3, kSparse, "i5"}, {{4, 1}}, {0.76, 1.79, 3.13, 6.49, 1.66, 3.07, 5.68, 13.23, 2.19, 4.27, 8.02, 19.38}},
      {{4, kDense, "RP2"},
       {{4, 1}},
       {1.15, 5.90, 15.67, 31.11, 58.84, 93.38, 148.42, 214.06},
       {4.6, 23.6, 62.7, 124.4, 235.4, 373.5, 593.7, 856.2}},
      {{4, kDense, "RP3"},
       {{4, 1}},
       {0.68, 4.08, 11.67, 26.72, 53.36, 89.17, 137.69, 204.77},
       {3.4, 20.4, 58.4, 133.6, 266.8, 445.9, 688.5, 1023.9}},
      {{4, kDense, "i5"},
       {{4, 1}},
       {0.40, 1.46, 1.94, 2.95, 5.14, 7.17, 9.64, 12.85},
       {6.0, 21.9, 29.1, 44.3, 77.1, 107.6, 144.6, 192.8}},
      {{4, kDense, "E5"},
       {{6, 1}},
       {0.11, 0.26, 0.48, 0.69, 1.09, 1.48, 2.10, 2.67},
       {10.5, 24.7, 45.6, 65.6, 103.4, 140.6, 199.5, 253.7}},
      {{5, kDense, "E5"},
       {{6, 2}},
       {0.006, 0.008, 0.010, 0.025, 0.034, 0.047, 0.721, 1.819, 3.211, 6.928, 43.728, 143.072, 328.249}},
      {{5, kDense, "E5"},
       {{2, 6}},
       {0.010, 0.013, 0.021, 0.057, 0.067, 0.077, 0.697, 2.023, 4.399, 7.376, 40.588, 115.185, 253.709}},
      {{5, kGpu, "GTX"},
       {{1, 1}},
       {0.331, 0.336, 0.373, 0.417, 0.492, 0.563, 3.638, 5.995, 8.808, 13.470, 53.038, 138.463, 293.713}},
  };
  return kColumns;
}

std::vector<PaperTiming> times_of(int table) {
  const std::vector<PaperCell> cells = cells_of_table(table);
  std::vector<PaperTiming> out;
  for (std::size_t r = 0; r < cells.size(); ++r) {
    for (const Column& c : columns()) {
      if (c.of.table != table) continue;
      PaperTiming& t = out.emplace_back();
      t.cell = cells[r];
      t.version = c.of.version;
      t.machine = c.of.machine;
      t.split = c.splits[std::min(r, c.splits.size() - 1)];
      t.seconds = c.seconds[r] / cells[r].steps;
      if (!c.joules.empty()) t.joules = c.joules[r];
    }
  }
  return out;
}

}  // namespace

std::string PaperCell::scene() const {
  if (n == 15 && terminal == 12) return groups == 6 ? "stewart" : "stewart:legs=" + std::to_string(groups);
  return "rings:legs=" + std::to_string(groups) + ",n=" + std::to_string(n) + ",terminal=" + std::to_string(terminal);
}

std::vector<PaperCell> cells_of_table(int table) {
  std::vector<PaperCell> cells;
  const auto terminal = [](int n) { return n == 15 ? 12 : 24; };
  switch (table) {
    case 2:
      for (const int n : {15, 30, 60, 120, 240, 360, 480, 720}) cells.push_back({6, n, terminal(n), 20000, 1});
      return cells;
    case 3:
      for (const int groups : {6, 16, 22}) {
        for (const int n : {15, 30, 60, 120}) cells.push_back({groups, n, terminal(n), 20000, 1});
      }
      return cells;
    case 4:
      for (int t = 12; t <= 96; t += 12) cells.push_back({6, t + t / 2, t, 300, 20});
      return cells;
    case 5:
      for (int t = 12; t <= 72; t += 12) cells.push_back({6, t + t / 2, t, 10, 10});
      for (const int n : {400, 600, 800, 1000, 2000, 3000, 4000}) cells.push_back({6, n, n, 10, 10});
      return cells;
    default:
      throw Error(Error::Kind::input, "the paper's tables with cells are 2, 3, 4 and 5, not " + std::to_string(table));
  }
}

std::string text_of(const Split& split) { return std::to_string(split.p) + "x" + std::to_string(split.q); }

Splits just(Split split) {
  return [split](const Split& s) { return s == split; };
}

const PaperTiming* fastest(Times times, const PaperCell& cell, std::string_view version, const Splits& splits,
                           Reading reading) {
  const PaperTiming* best = nullptr;
  for (const PaperTiming& t : times) {
    const bool it = t.timed() && t.version == version && t.reading == reading && t.cell.same_work(cell);
    if (it && (!splits || splits(t.split)) && (best == nullptr || t.seconds < best->seconds)) best = &t;
  }
  return best;
}

double best(Times times, const PaperCell& cell, std::string_view version, const Splits& splits, Reading reading) {
  const PaperTiming* const t = fastest(times, cell, version, splits, reading);
  return t == nullptr ? kNan : t->seconds;
}

std::string ratio_text(double ratio) {
  if (ratio < 0.0995) return fixed(ratio, ratio > 0 ? 1 - static_cast<int>(std::floor(std::log10(ratio))) : 2);
  return fixed(ratio, ratio < 0.9995 ? 3 : ratio < 9.995 ? 2 : ratio < 99.95 ? 1 : 0);
}

const PaperMachine& paper_machine(std::string_view id) {
  const auto* const at =
      std::find_if(kMachines.begin(), kMachines.end(), [id](const PaperMachine& m) { return m.id == id; });
  if (at != kMachines.end()) return *at;
  throw Error(Error::Kind::input, "the paper has no machine " + std::string(id) + "; it has i5, E5, RP2, RP3 and GTX");
}

const std::vector<PaperTiming>& paper_times(int table) {
  static const std::array<std::vector<PaperTiming>, 4> kTables = {times_of(2), times_of(3), times_of(4), times_of(5)};
  static const std::vector<PaperTiming> kNone;
  return table < 2 || table > 5 ? kNone : kTables[static_cast<std::size_t>(table - 2)];
}

}  // namespace assur::report
