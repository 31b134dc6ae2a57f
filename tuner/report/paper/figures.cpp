#include "report/paper/figures.hpp"

#include <array>
#include <utility>

#include "assur/status.hpp"

namespace assur::report {
namespace {

constexpr std::array kMachines = {
    PaperMachine{"i5", "Core i5-2400, 4 cores", 15}, PaperMachine{"E5", "2 x Xeon E5-2620, 12 cores", 95},
    PaperMachine{"RP2", "Raspberry Pi 2 B, 4 cores", 4}, PaperMachine{"RP3", "Raspberry Pi 3 B, 4 cores", 5},
    PaperMachine{"GTX", "GeForce GTX 950, MAGMA", 365}};

struct Split {
  double seconds;
  int p, q;
};

// GMKL, GMA27, GEOMP+MKL, GEOMP+MA27; the global versions' threads are all in the linear algebra.
constexpr std::array<std::array<Split, 4>, 8> kTable2 = {{
    {{{2.52, 1, 1}, {4.19, 1, 1}, {0.53, 3, 1}, {0.74, 3, 1}}},
    {{{9.11, 1, 3}, {9.02, 1, 1}, {1.13, 3, 1}, {1.40, 3, 1}}},
    {{{32.43, 1, 3}, {13.45, 1, 1}, {2.39, 3, 1}, {2.84, 3, 1}}},
    {{{151.94, 1, 4}, {25.29, 1, 1}, {8.40, 3, 1}, {5.71, 3, 1}}},
    {{{1127.25, 1, 4}, {48.26, 1, 1}, {42.33, 3, 1}, {12.23, 3, 1}}},
    {{{3579.63, 1, 4}, {71.27, 1, 1}, {147.41, 3, 1}, {18.23, 3, 1}}},
    {{{7149.04, 1, 4}, {94.19, 1, 1}, {323.77, 3, 1}, {24.35, 3, 1}}},
    {{{22840.51, 1, 4}, {140.13, 1, 1}, {828.97, 1, 4}, {36.59, 3, 1}}},
}};

// MKL and MA27 by one thread, GEOMP+MKL and GEOMP+MA27 by four.
constexpr std::array<std::array<double, 4>, 12> kTable3 = {{
    {0.85, 1.9, 0.65, 0.76},
    {2.13, 3.33, 1.42, 1.79},
    {5.54, 7.24, 2.72, 3.13},
    {20.18, 15.96, 9.61, 6.49},
    {2.07, 4.86, 0.98, 1.66},
    {4.91, 8.61, 2.35, 3.07},
    {14.02, 18.69, 4.65, 5.68},
    {52.71, 41.43, 16.16, 13.23},
    {3.00, 7.18, 1.35, 2.19},
    {7.15, 12.96, 2.62, 4.27},
    {20.77, 27.95, 6.53, 8.02},
    {78.89, 61.01, 23.47, 19.38},
}};

constexpr std::array<std::string_view, 4> kMachinesOfTable4 = {"RP2", "RP3", "i5", "E5"};
struct Row4 {
  std::array<double, 4> seconds, joules;
};
constexpr std::array<Row4, 8> kTable4 = {{
    {{1.15, 0.68, 0.40, 0.11}, {4.6, 3.4, 6.0, 10.5}},
    {{5.90, 4.08, 1.46, 0.26}, {23.6, 20.4, 21.9, 24.7}},
    {{15.67, 11.67, 1.94, 0.48}, {62.7, 58.4, 29.1, 45.6}},
    {{31.11, 26.72, 2.95, 0.69}, {124.4, 133.6, 44.3, 65.6}},
    {{58.84, 53.36, 5.14, 1.09}, {235.4, 266.8, 77.1, 103.4}},
    {{93.38, 89.17, 7.17, 1.48}, {373.5, 445.9, 107.6, 140.6}},
    {{148.42, 137.69, 9.64, 2.10}, {593.7, 688.5, 144.6, 199.5}},
    {{214.06, 204.77, 12.85, 2.67}, {856.2, 1023.9, 192.8, 253.7}},
}};

// 6x2, 2x6, MAGMA
constexpr std::array<std::array<double, 3>, 13> kTable5 = {{
    {0.006, 0.010, 0.331},
    {0.008, 0.013, 0.336},
    {0.010, 0.021, 0.373},
    {0.025, 0.057, 0.417},
    {0.034, 0.067, 0.492},
    {0.047, 0.077, 0.563},
    {0.721, 0.697, 3.638},
    {1.819, 2.023, 5.995},
    {3.211, 4.399, 8.808},
    {6.928, 7.376, 13.470},
    {43.728, 40.588, 53.038},
    {143.072, 115.185, 138.463},
    {328.249, 253.709, 293.713},
}};

PaperTiming theirs(const PaperCell& cell, std::string_view version, const Split& split) {
  PaperTiming t;
  t.cell = cell;
  t.version = version;
  t.p = split.p;
  t.q = split.q;
  t.seconds = split.seconds / cell.steps;
  return t;
}

std::vector<PaperTiming> table_2() {
  constexpr std::array<std::string_view, 4> kVersions = {"GMKL", "GMA27", "GEOMP+MKL", "GEOMP+MA27"};
  const std::vector<PaperCell> cells = cells_of_table(2);
  std::vector<PaperTiming> out;
  for (std::size_t r = 0; r < cells.size(); ++r) {
    for (std::size_t c = 0; c < 4; ++c) out.push_back(theirs(cells[r], kVersions[c], kTable2[r][c]));
  }
  return out;
}

std::vector<PaperTiming> table_3() {
  const std::vector<PaperCell> cells = cells_of_table(3);
  std::vector<PaperTiming> out;
  for (std::size_t r = 0; r < cells.size(); ++r) {
    const std::array<double, 4>& row = kTable3[r];
    out.push_back(theirs(cells[r], "GEOMP+MKL", {row[0], 1, 1}));
    out.push_back(theirs(cells[r], "GEOMP+MA27", {row[1], 1, 1}));
    out.push_back(theirs(cells[r], "GEOMP+MKL", {row[2], 4, 1}));
    out.push_back(theirs(cells[r], "GEOMP+MA27", {row[3], 4, 1}));
  }
  return out;
}

std::vector<PaperTiming> table_5() {
  const std::vector<PaperCell> cells = cells_of_table(5);
  std::vector<PaperTiming> out;
  for (std::size_t r = 0; r < cells.size(); ++r) {
    out.push_back(theirs(cells[r], "GEOMP+MKL", {kTable5[r][0], 6, 2}));
    out.push_back(theirs(cells[r], "GEOMP+MKL", {kTable5[r][1], 2, 6}));
    out.push_back(theirs(cells[r], "GEMAGMA", {kTable5[r][2], 1, 1}));
  }
  return out;
}

std::vector<PaperEnergy> table_4() {
  const std::vector<PaperCell> cells = cells_of_table(4);
  std::vector<PaperEnergy> out;
  for (std::size_t r = 0; r < cells.size(); ++r) {
    for (std::size_t m = 0; m < kMachinesOfTable4.size(); ++m) {
      out.push_back({cells[r], kMachinesOfTable4[m], kTable4[r].seconds[m], kTable4[r].joules[m]});
    }
  }
  return out;
}

}  // namespace

const PaperMachine& paper_machine(std::string_view id) {
  for (const PaperMachine& m : kMachines) {
    if (m.id == id) return m;
  }
  throw Error(Error::Kind::input, "the paper has no machine " + std::string(id) + "; it has i5, E5, RP2, RP3 and GTX");
}

const std::vector<PaperTiming>& paper_times(int table) {
  static const std::vector<PaperTiming> second = table_2(), third = table_3(), fifth = table_5(), none;
  return table == 2 ? second : table == 3 ? third : table == 5 ? fifth : none;
}

const std::vector<PaperEnergy>& paper_energies() {
  static const std::vector<PaperEnergy> all = table_4();
  return all;
}

}  // namespace assur::report
