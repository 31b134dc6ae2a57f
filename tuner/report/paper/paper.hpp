// The experiments of the paper with its numbers: "Exploiting Hybrid Parallelism in the Kinematic
// Analysis of Multibody Systems Based on Group Equations", tables 2 to 5.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "numbers.hpp"

namespace assur::report {

// A row of a table of the paper: nSG, nSG-HS, nSG-T, tEnd / dt and tEnd2.
struct PaperCell {
  int groups = 6;  // after the terminal
  int n = 15;      // unknowns of each group
  int terminal = 12;
  int steps = 20000;
  int iterations = 1;  // of Newton's method, in every group except the terminal

  [[nodiscard]] int total() const { return terminal + groups * n; }  // "total size": order of the global matrix
  // The sample that repeats it: the Stewart platform if the groups are its legs, else rings.
  [[nodiscard]] std::string scene() const;
  // True for the same mechanism with the same work in a step; the numbers of steps may differ.
  [[nodiscard]] bool same_work(const PaperCell& o) const {
    return groups == o.groups && n == o.n && terminal == o.terminal && iterations == o.iterations;
  }

  friend bool operator==(const PaperCell&, const PaperCell&) = default;
};

// Rows of tables 2 to 5 of the paper in its order. The terminal has 12 unknowns if n = 15. Otherwise it has 24 in
// tables 2 and 3, n / 1.5 in table 4, and in table 5 n / 1.5 up to n = 108, then n.
[[nodiscard]] std::vector<PaperCell> cells_of_table(int table);

// Factorisations of a step after its Newton iterations; the paper does not state their number.
enum class Reading : std::uint8_t {
  shared,    // once, for velocity and acceleration
  separate,  // once for each
};

// p groups at once, with q threads in the linear algebra of each one.
struct Split {
  int p = 1, q = 1;

  friend bool operator==(const Split&, const Split&) = default;
};
[[nodiscard]] std::string text_of(const Split& split);  // "3x1"

// Names of versions: those of the paper (with one OpenMP thread: GEMKL), and kAuto. Other versions are texts of
// strategies.
inline constexpr std::string_view kGlobalDense = "GMKL", kGlobalSparse = "GMA27", kDense = "GEOMP+MKL",
                                  kSparse = "GEOMP+MA27", kGpu = "GEMAGMA", kAuto = "auto";

// The time of one step of a cell.
struct PaperTiming {
  PaperCell cell;
  std::string version;
  Split split;           // of the paper's versions
  std::string strategy;  // strategy that was run; "" for times of the paper
  Reading reading = Reading::shared;
  double seconds = kNan;  // of one step; NaN: none
  double spread = 0;      // median absolute deviation, s
  int rounds = 0;         // blocks that were timed
  std::int64_t steps_timed = 0;
  double deviation = kNan;        // deviation from the verified reference motion
  double joules = kNan;           // energy of cell.steps steps; on this machine by its own counters
  double newton = 0;              // mean number of iterations of a group in a step
  std::string why_not = {};       // reason why there is no time; "": there is one
  std::string_view machine = {};  // machine of the paper: id for paper_machine()

  [[nodiscard]] bool timed() const { return seconds > 0; }
};

using Times = std::span<const PaperTiming>;
using Splits = std::function<bool(const Split&)>;
[[nodiscard]] Splits just(Split split);

// The fastest time of a version in a cell with one of these splits (empty: any); null if there is none.
[[nodiscard]] const PaperTiming* fastest(Times times, const PaperCell& cell, std::string_view version,
                                         const Splits& splits = {}, Reading reading = Reading::shared);
// The time of fastest(), s; NaN if there is none.
[[nodiscard]] double best(Times times, const PaperCell& cell, std::string_view version, const Splits& splits = {},
                          Reading reading = Reading::shared);

// Three digits, below 0.1 two: "0.0063", "0.127", "3.83", "163".
[[nodiscard]] std::string ratio_text(double ratio);

struct PaperMachine {
  std::string_view id, name;
  double watts;  // power that table 4 assumes
};

// "i5" (tables 2 to 4), "E5" (figure 3, tables 4 and 5), "RP2", "RP3" (table 4), "GTX" (table 5).
[[nodiscard]] const PaperMachine& paper_machine(std::string_view id);

// The times in tables 2 to 5 of the paper, cell by cell, with the stated threads; none for other tables.
[[nodiscard]] const std::vector<PaperTiming>& paper_times(int table);

}  // namespace assur::report
