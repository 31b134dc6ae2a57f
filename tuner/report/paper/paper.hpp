// The experiments of the paper, and the numbers that it prints: "Exploiting Hybrid Parallelism in the Kinematic
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

// A row of one of the paper's tables: nSG, nSG-HS, nSG-T, tEnd / dt and tEnd2.
struct PaperCell {
  int groups = 6;  // after the terminal
  int n = 15;      // unknowns of each
  int terminal = 12;
  int steps = 20000;
  int iterations = 1;  // of Newton's method, in every group but the terminal

  [[nodiscard]] int total() const { return terminal + groups * n; }  // "total size": that of the global matrix
  // The sample that is run for it: the Stewart platform where the groups are its legs, else rings.
  [[nodiscard]] std::string scene() const;
  // The same mechanism with as much work in a step; how many steps the paper took is of no account.
  [[nodiscard]] bool same_work(const PaperCell& o) const {
    return groups == o.groups && n == o.n && terminal == o.terminal && iterations == o.iterations;
  }

  friend bool operator==(const PaperCell&, const PaperCell&) = default;
};

// Rows of the paper's tables 2 to 5, as it prints them. T is 12 where n = 15, else 24 in tables 2 and 3; n / 1.5 in
// table 4; n / 1.5 up to n = 108, then n in table 5.
[[nodiscard]] std::vector<PaperCell> cells_of_table(int table);

// How often is factorised in a step beyond its Newton iterations, which the paper does not say.
enum class Reading : std::uint8_t {
  shared,    // once, for velocity and acceleration
  separate,  // once for each
};

// Groups at once x threads in the linear algebra of each.
struct Split {
  int p = 1, q = 1;

  friend bool operator==(const Split&, const Split&) = default;
};
[[nodiscard]] std::string text_of(const Split& split);  // "3x1"

// Names of versions: the paper's are these (with one OpenMP thread: GEMKL); ours are kAuto and texts of strategies.
inline constexpr std::string_view kGlobalDense = "GMKL", kGlobalSparse = "GMA27", kDense = "GEOMP+MKL",
                                  kSparse = "GEOMP+MA27", kGpu = "GEMAGMA", kAuto = "auto";

// The time of one step of a cell.
struct PaperTiming {
  PaperCell cell;
  std::string version;
  Split split;           // of the paper's versions
  std::string strategy;  // ours: what was run; theirs: ""
  Reading reading = Reading::shared;
  double seconds = kNan;  // of one step; NaN: none
  double spread = 0;      // median absolute deviation, s
  int rounds = 0;         // blocks that were timed
  std::int64_t steps_timed = 0;
  double deviation = kNan;        // from the reference motion, which was verified before
  double joules = kNan;           // of cell.steps steps; ours: by the machine's own counters
  double newton = 0;              // iterations of a group and step, mean
  std::string why_not = {};       // there is no time; "": there is
  std::string_view machine = {};  // of the paper's, as paper_machine() knows it

  [[nodiscard]] bool timed() const { return seconds > 0; }
};

using Times = std::span<const PaperTiming>;
using Splits = std::function<bool(const Split&)>;
[[nodiscard]] Splits just(Split split);

// The fastest of a version in a cell with one of these splits (empty: any); null if there is none with a time.
[[nodiscard]] const PaperTiming* fastest(Times times, const PaperCell& cell, std::string_view version,
                                         const Splits& splits = {}, Reading reading = Reading::shared);
// Its time; NaN if there is none.
[[nodiscard]] double best(Times times, const PaperCell& cell, std::string_view version, const Splits& splits = {},
                          Reading reading = Reading::shared);

// Three digits, below 0.1 two: "0.0063", "0.127", "3.83", "163".
[[nodiscard]] std::string ratio_text(double ratio);

struct PaperMachine {
  std::string_view id, name;
  double watts;  // that table 4 counts with
};

// "i5" (tables 2 to 4), "E5" (figure 3, tables 4 and 5), "RP2", "RP3" (table 4), "GTX" (table 5).
[[nodiscard]] const PaperMachine& paper_machine(std::string_view id);

// What the paper's tables 2 to 5 print, cell by cell, with the threads that it says; none of other tables.
[[nodiscard]] const std::vector<PaperTiming>& paper_times(int table);

}  // namespace assur::report
