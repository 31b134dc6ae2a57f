// Rules that decide whether a conclusion holds, applied to the times of the paper and to artificial ones.
#include "report/paper/conclusions.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "report/paper/plan.hpp"

namespace assur::report {
namespace {

const Conclusion& about(const std::vector<Conclusion>& all, const std::string& words) {
  const auto at = std::find_if(all.begin(), all.end(),
                               [&](const Conclusion& c) { return c.claim.find(words) != std::string::npos; });
  if (at == all.end()) throw std::runtime_error("no conclusion about " + words);
  return *at;
}

// Times by a formula for every version in every cell of tables 2 and 3.
using Law = std::function<double(const PaperCell&, const std::string& version, int p, int q)>;
std::vector<PaperTiming> made_up(const Law& law, int threads) {
  std::vector<PaperTiming> out;
  for (const int table : {2, 3}) {
    for (const PaperCell& cell : cells_of_table(table)) {
      for (const std::string version : {"GMKL", "GMA27", "GEOMP+MKL", "GEOMP+MA27", "auto"}) {
        for (const Split& split : splits(threads, version.starts_with("GEOMP") ? cell.groups : 1)) {
          PaperTiming t;
          t.cell = cell;
          t.version = version;
          t.split = split;
          t.seconds = law(cell, version, split.p, split.q);
          if (t.timed()) out.push_back(t);
        }
      }
    }
  }
  return out;
}

// Cost by operations: dense n^3, sparse n with a large constant. p groups are solved at once.
double as_the_paper_thinks(const PaperCell& cell, const std::string& version, int p, int q) {
  const auto dense = [](double n) { return n * n * n; };
  const auto sparse = [](double n) { return 90 * 90 * n; };
  const double threads = 1 + 0.8 * (p - 1) + 0.4 * (q - 1);
  if (version == "GMKL") return dense(cell.total()) / 20 / threads;  // at 102 faster than sparse
  if (version == "GMA27") return q > 1 ? NAN : sparse(cell.total());
  if (version == "GEOMP+MKL") return cell.groups * dense(cell.n) / threads + cell.groups * 1000;
  if (version == "GEOMP+MA27") return q > 1 ? NAN : cell.groups * sparse(cell.n) / threads + cell.groups * 1000;
  return 1;
}

TEST(PaperConclusions, HoldForThePaperItself) {
  const std::vector<Conclusion> all = conclusions_of_the_paper();
  int held = 0;
  for (const Conclusion& c : all) {
    EXPECT_NE(c.verdict, Verdict::does_not_hold) << c.claim << ": " << c.theirs;
    held += c.verdict == Verdict::holds ? 1 : 0;
    EXPECT_FALSE(c.theirs.empty()) << c.claim;
  }
  // The printed numbers decide neither the conclusions about the Raspberry Pi and figure 3, nor the outlook.
  EXPECT_EQ(held, static_cast<int>(all.size()) - 3);
  EXPECT_NE(about(all, "close to four").theirs.find("3.83"), std::string::npos);
  EXPECT_NE(about(all, "between four and eight").theirs.find("3.83 to 7.98"), std::string::npos);
  EXPECT_EQ(
      about(all, "GPU is for large").theirs,
      "time of the GPU over that of 6x2 on the CPU: 55.2 at n = 18, 0.895 at n = 4000; the GPU is faster from n = "
      "3000 on");
  EXPECT_NE(about(all, "Raspberry").theirs.find("15.9 times the i5's time"), std::string::npos);
}

TEST(PaperConclusions, AreDecidedByMeasuredTimes) {
  const std::vector<Conclusion> all = conclusions(made_up(as_the_paper_thinks, 2), 2);
  EXPECT_EQ(about(all, "Multithreading MKL").verdict, Verdict::holds);
  EXPECT_EQ(about(all, "With larger matrices").verdict, Verdict::holds);
  EXPECT_EQ(about(all, "clearly outperform").verdict, Verdict::holds);
  EXPECT_EQ(about(all, "close to four").verdict, Verdict::does_not_hold);         // two threads give 1.8
  EXPECT_EQ(about(all, "between 60 and 120").verdict, Verdict::holds);            // equal at n = 90
  EXPECT_EQ(about(all, "OpenMP achieves more").verdict, Verdict::does_not_hold);  // MKL is not ahead at the largest
  EXPECT_EQ(about(all, "preferred method depends").verdict, Verdict::holds);
  EXPECT_EQ(about(all, "Outlook").verdict, Verdict::holds);
  for (const char* words : {"Three OpenMP", "figure 3", "Raspberry", "hybrid parallelism for medium", "GPU"}) {
    EXPECT_EQ(about(all, words).verdict, Verdict::cannot_be_tested) << words;
  }
}

TEST(PaperConclusions, AGpuIsComparedWithTheCpu) {
  std::vector<PaperTiming> times;
  const auto add = [&](const PaperCell& cell, std::string_view version, const Split& split, double seconds) {
    PaperTiming& t = times.emplace_back();
    t.cell = cell;
    t.version = version;
    t.split = split;
    t.seconds = seconds;
  };
  for (const PaperCell& cell : cells_of_table(5)) {
    if (cell.n == 3000) continue;  // no time left
    add(cell, kDense, {2, 1}, 1e-9 * cell.n * cell.n * cell.n);
    add(cell, kGpu, {}, 0.5 + 1e-12 * cell.n * cell.n * cell.n);
  }
  const Conclusion here = about(conclusions(times, 2), "GPU is for large");
  EXPECT_EQ(here.verdict, Verdict::holds);
  EXPECT_EQ(
      here.here,
      "time of the GPU over that of 2x1 on the CPU: 85734 at n = 18, 0.0088 at n = 4000; the GPU is faster from n "
      "= 800 on");
  std::erase_if(times, [](const PaperTiming& t) { return t.cell.n > 200; });
  EXPECT_EQ(about(conclusions(times, 2), "GPU is for large").here, "not run from n = 18 to 400");
  std::erase_if(times, [](const PaperTiming& t) { return t.version == kGpu; });
  EXPECT_EQ(about(conclusions(times, 2), "GPU is for large").here, "no GPU here");
}

TEST(PaperConclusions, ChangeWithTheTimes) {
  const auto sparse_is_always_faster = [](const PaperCell& cell, const std::string& version, int p, int q) {
    const bool dense = version.ends_with("MKL");
    if (!dense && q > 1) return std::nan("");
    return (dense ? 10.0 : version == "auto" ? 5.0 : 1.0) * cell.total() * p * q;  // threads only cost time
  };
  const std::vector<Conclusion> all = conclusions(made_up(sparse_is_always_faster, 2), 2);
  for (const char* words :
       {"Multithreading MKL", "With larger matrices", "clearly outperform", "close to four", "between 60 and 120",
        "Parallelism pays", "Sparse for large", "preferred method depends", "between four and eight", "Outlook"}) {
    EXPECT_EQ(about(all, words).verdict, Verdict::does_not_hold) << words << ": " << about(all, words).here;
  }
  EXPECT_NE(about(all, "Sparse for large").here.find("0.100 at total size 102"), std::string::npos);
}

TEST(PaperConclusions, AreUndecidedWithoutTimes) {
  for (const Conclusion& c : conclusions({}, 64)) {
    EXPECT_EQ(c.verdict, Verdict::cannot_be_tested) << c.claim;
    EXPECT_FALSE(c.here.empty()) << c.claim;
  }
}

TEST(PaperConclusions, ThreeThreadsAreCounted) {
  const auto best_with = [](int best) {
    return made_up([best](const PaperCell&, const std::string&, int p, int q) { return 1.0 + std::abs(p - best) + q; },
                   4);
  };
  EXPECT_EQ(about(conclusions(best_with(3), 4), "Three OpenMP").verdict, Verdict::holds);
  EXPECT_EQ(about(conclusions(best_with(4), 4), "Three OpenMP").verdict, Verdict::does_not_hold);
}

TEST(PaperConclusions, RatiosHaveTwoOrThreeDigits) {
  EXPECT_EQ(ratio_text(0.00631), "0.0063");
  EXPECT_EQ(ratio_text(0.0701), "0.070");
  EXPECT_EQ(ratio_text(0.1234), "0.123");
  EXPECT_EQ(ratio_text(3.827), "3.83");
  EXPECT_EQ(ratio_text(9.996), "10.0");
  EXPECT_EQ(ratio_text(162.97), "163");
}

}  // namespace
}  // namespace assur::report
