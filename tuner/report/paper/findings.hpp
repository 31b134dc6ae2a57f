// What the times of the paper's experiments say about its conclusions, whoever measured them.
#pragma once

#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "report/paper/cells.hpp"

namespace assur::report {

using Times = std::span<const PaperTiming>;

// Times to ask: those of the paper are kept table by table, for two of its tables have cells in common.
struct Source {
  Times table_2, table_3, table_5;
  int threads;  // that the versions could use
};

struct Finding {
  std::optional<bool> holds;  // empty: cannot be told
  std::string numbers;        // or why it cannot
};
[[nodiscard]] inline Finding not_run() { return {std::nullopt, "not run"}; }

// Global formulation and groups, dense and sparse.
[[nodiscard]] Finding dense_for_the_case_study(const Source& source);
[[nodiscard]] Finding sparse_for_large(const Source& source);
[[nodiscard]] Finding groups_beat_global(const Source& source);
[[nodiscard]] Finding four_times_for_the_largest(const Source& source);
[[nodiscard]] Finding crossover_of_sparsity(const Source& source);
[[nodiscard]] Finding sparse_large_dense_small(const Source& source);
[[nodiscard]] Finding method_depends(const Source& source);
[[nodiscard]] Finding four_to_eight(const Source& source);
[[nodiscard]] Finding auto_is_the_fastest(const Source& source);

// Threads, and the GPU.
[[nodiscard]] Finding openmp_beats_mkl(const Source& source);
[[nodiscard]] Finding three_threads(const Source& source);
[[nodiscard]] Finding parallelism_grows(const Source& source);
[[nodiscard]] Finding hybrid_for_large(const Source& source);
[[nodiscard]] Finding wide_for_small_narrow_for_large(const Source& source);
[[nodiscard]] Finding gpu_for_large_only(const Source& source);

// Time of one step of the fastest; NaN if there is none.
[[nodiscard]] double best(Times times, const PaperCell& cell, std::string_view version);

// "total size 102"
[[nodiscard]] std::string total(const PaperCell& cell);

// Ratios of several cells; what is not known is left out.
struct Range {
  double least = HUGE_VAL, most = 0;

  void add(double value);
  [[nodiscard]] bool empty() const { return most == 0; }
  [[nodiscard]] std::string text() const;  // "3.83 to 7.98"
};

}  // namespace assur::report
