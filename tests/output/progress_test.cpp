#include "output/progress.hpp"

#include <gtest/gtest.h>

#include <sstream>

namespace assur::output {
namespace {

TEST(Progress, IsSilentWithinTheFirstSecond) {
  for (const auto style : {Progress::Style::bar, Progress::Style::lines}) {
    std::ostringstream out;
    {
      Progress progress(out, style);
      for (int k = 0; k < 10; ++k) progress.show(0.0999 * k, k, 10);
    }
    EXPECT_EQ(out.str(), "");
  }
}

TEST(Progress, StyleNoneIsSilent) {
  std::ostringstream out;
  Progress(out, Progress::Style::none).show(100, 1, 2);
  EXPECT_EQ(out.str(), "");
}

TEST(Progress, PlainLinesComeEveryFiveSeconds) {
  std::ostringstream out;
  Progress progress(out, Progress::Style::lines);
  for (int k = 0; k <= 120; ++k) progress.show(0.1 * k, k, 2000);
  progress.clear();
  EXPECT_EQ(out.str(),
            "0 %, 10 of 2,000 steps, about 3 min left\n"
            "3 %, 60 of 2,000 steps, about 3 min left\n"
            "5 %, 110 of 2,000 steps, about 3 min left\n");
}

TEST(Progress, UsesTheNounInSingularAndPlural) {
  std::ostringstream out;
  Progress(out, Progress::Style::lines, "member").show(2, 64, 64);
  EXPECT_EQ(out.str(), "100 %, 64 of 64 members\n");
}

// A line that wraps could not be erased.
TEST(Progress, IsNoWiderThanTheTerminal) {
  const auto drawn = [](std::size_t columns) {
    std::ostringstream out;
    Progress progress(out, Progress::Style::bar, "step", columns);
    progress.show(2, 500, 1000);
    return out.str();
  };
  EXPECT_EQ(drawn(80), drawn(0));
  EXPECT_EQ(drawn(75), drawn(0));
  EXPECT_EQ(drawn(74), "\r\x1b[K50 %  500 of 1,000 steps, about 2 s left");
  EXPECT_EQ(drawn(20), "\r\x1b[K50 %  500 of 1,000 ");
}

TEST(Progress, BarRedrawsAndDisappears) {
  std::ostringstream out;
  {
    Progress progress(out, Progress::Style::bar, "step", 0);
    progress.show(2, 500, 1000);
    progress.show(2.05, 510, 1000);  // not shown, because it is too soon
    progress.show(4, 1000, 1000);
  }
  std::string half, full;
  for (int i = 0; i < 30; ++i) {
    half += i < 15 ? "━" : "╌";
    full += "━";
  }
  EXPECT_EQ(out.str(), "\r\x1b[K  " + half + "  50 %  500 of 1,000 steps, about 2 s left" + "\r\x1b[K  " + full +
                           "  100 %  1,000 of 1,000 steps" + "\r\x1b[K");
}

}  // namespace
}  // namespace assur::output
