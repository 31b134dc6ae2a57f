#include "report/paper/conclusions.hpp"

#include <algorithm>
#include <array>

#include "report/paper/figures.hpp"
#include "report/paper/findings.hpp"

namespace assur::report {
namespace {

Finding no_raspberry_pi(const Source&) { return {std::nullopt, "no Raspberry Pi here"}; }

struct Rule {
  const char *where, *claim;
  Finding (*find)(const Source&);
};

constexpr std::array kRules = {
    Rule{"5.1", "Multithreading MKL is preferable to MA27 for the case study", dense_for_the_case_study},
    Rule{"5.1", "With larger matrices sparsity pays: O(n) of MA27 against O(n³) of MKL", sparse_for_large},
    Rule{"5.1, 6", "Group equations clearly outperform the global formulation", groups_beat_global},
    Rule{"5.1", "... with a speed-up of close to four for the largest", four_times_for_the_largest},
    Rule{"5.1", "OpenMP achieves more than MKL's threads from the smallest size, except for the largest",
         openmp_beats_mkl},
    Rule{"5.1", "Three OpenMP threads are best for six groups", three_threads},
    Rule{"5.1", "Parallelism pays, and more so with more groups and coordinates", parallelism_grows},
    Rule{"5.1", "Exploiting sparsity is advantageous from between 60 and 120 coordinates", crossover_of_sparsity},
    Rule{"5.1", "OpenMP alone for small problems, OpenMP and MKL together for larger ones (figure 3)",
         hybrid_for_large},
    Rule{"5.2, 6", "A Raspberry Pi is competitive for small control problems", no_raspberry_pi},
    Rule{"5.3", "OpenMP for small sizes, hybrid parallelism for medium ones", wide_for_small_narrow_for_large},
    Rule{"5.3, 6", "The GPU is for large problems only", gpu_for_large_only},
    Rule{"6", "Sparse for large matrices, dense for small ones", sparse_large_dense_small},
    Rule{"6", "The preferred method depends on the number of groups and coordinates", method_depends},
    Rule{"6", "Speed-up over the global formulation: between four and eight", four_to_eight},
    Rule{"6", "Outlook: auto-tuning should select the best strategy by itself", auto_is_the_fastest},
};

// What table 4 says of the first and the last size.
std::string raspberry_pi_of_the_paper() {
  const auto of = [](std::string_view machine, const PaperCell& cell) {
    const auto& all = paper_energies();
    return *std::find_if(all.begin(), all.end(),
                         [&](const PaperEnergy& e) { return e.machine == machine && e.cell == cell; });
  };
  const std::vector<PaperCell> cells = cells_of_table(4);
  const auto line = [&](const PaperCell& cell) {
    const PaperEnergy pi = of("RP3", cell), i5 = of("i5", cell);
    return ratio_text(pi.seconds / i5.seconds) + " times the i5's time and " + ratio_text(pi.joules / i5.joules) +
           " times its energy at n = " + std::to_string(cell.n);
  };
  return "RP3: " + line(cells.front()) + ", " + line(cells.back());
}

Verdict verdict(const Finding& finding) {
  if (!finding.holds) return Verdict::cannot_be_tested;
  return *finding.holds ? Verdict::holds : Verdict::does_not_hold;
}

Source source_of_the_paper() { return {paper_times(2), paper_times(3), paper_times(5), 12}; }

std::string numbers_of_the_paper(const Rule& rule) {
  if (rule.find == no_raspberry_pi) return raspberry_pi_of_the_paper();
  if (rule.find == hybrid_for_large) return "in figure 3 only, without numbers";
  return rule.find(source_of_the_paper()).numbers;
}

}  // namespace

std::string_view verdict_text(Verdict verdict) noexcept {
  switch (verdict) {
    case Verdict::holds:
      return "holds here";
    case Verdict::does_not_hold:
      return "does not hold here";
    case Verdict::cannot_be_tested:
      break;
  }
  return "cannot be tested here";
}

std::vector<Conclusion> conclusions(std::span<const PaperTiming> times, int threads) {
  std::vector<Conclusion> out;
  for (const Rule& rule : kRules) {
    const Finding finding = rule.find({times, times, times, threads});
    out.push_back({rule.where, rule.claim, numbers_of_the_paper(rule), finding.numbers, verdict(finding)});
  }
  return out;
}

std::vector<Conclusion> conclusions_of_the_paper() {
  std::vector<Conclusion> out;
  for (const Rule& rule : kRules) {
    // The best splits that table 2 names are those of four cores; what figure 3 shows is nowhere in numbers.
    const bool untold = rule.find == hybrid_for_large;
    const Finding finding = untold ? Finding{} : rule.find(source_of_the_paper());
    out.push_back({rule.where, rule.claim, numbers_of_the_paper(rule), finding.numbers, verdict(finding)});
  }
  return out;
}

}  // namespace assur::report
