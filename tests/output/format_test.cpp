#include "output/format.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace assur::output {
namespace {

TEST(Format, GroupsDigitsByThree) {
  EXPECT_EQ(grouped(0), "0");
  EXPECT_EQ(grouped(999), "999");
  EXPECT_EQ(grouped(1000), "1,000");
  EXPECT_EQ(grouped(1234567), "1,234,567");
  EXPECT_EQ(grouped(-123), "-123");
  EXPECT_EQ(grouped(-1234), "-1,234");
}

TEST(Format, UsesSingularAndPlural) {
  EXPECT_EQ(counted(0, "step"), "0 steps");
  EXPECT_EQ(counted(1, "step"), "1 step");
  EXPECT_EQ(counted(1, "class"), "1 class");
  EXPECT_EQ(counted(2000, "class"), "2,000 classes");
}

TEST(Format, DurationsHaveThreeDigitsAndAUnit) {
  EXPECT_EQ(duration(0), "0.00 ns");
  EXPECT_EQ(duration(1.2345e-8), "12.3 ns");
  EXPECT_EQ(duration(9.996e-6), "10.0 µs");
  EXPECT_EQ(duration(9.9996e-4), "1.00 ms");
  EXPECT_EQ(duration(0.0123), "12.3 ms");
  EXPECT_EQ(duration(1.04), "1.04 s");
  EXPECT_EQ(duration(754), "754 s");
}

TEST(Format, ErrorsHaveTwoDigits) {
  EXPECT_EQ(error_figure(2.22e-16), "2.2e-16");
  EXPECT_EQ(error_figure(0), "0");
  EXPECT_EQ(error_figure(std::numeric_limits<double>::quiet_NaN()), "-");
  EXPECT_EQ(error_figure(std::numeric_limits<double>::infinity()), "not finite");
}

TEST(Format, ListsNameTheFirstAndCountTheRest) {
  EXPECT_EQ(listed({}), "");
  EXPECT_EQ(listed({"a", "b"}), "a, b");
  EXPECT_EQ(listed({"a", "b", "c"}, 2), "a, b and 1 more");
}

TEST(Format, ShortensByColumnsNotBytes) {
  EXPECT_EQ(display_width("µs"), 2u);
  EXPECT_EQ(shortened("four_bar", 8), "four_bar");
  EXPECT_EQ(shortened("four_bars", 8), "four_...");
  EXPECT_EQ(shortened("µµµµµµ", 5), "µµ...");
}

TEST(Format, WrapsAtSpaces) {
  EXPECT_EQ(wrapped("", 10), std::vector<std::string>{""});
  EXPECT_EQ(wrapped("one two three", 7), (std::vector<std::string>{"one two", "three"}));
  EXPECT_EQ(wrapped("a much_too_long_word b", 6), (std::vector<std::string>{"a", "much_too_long_word", "b"}));
}

}  // namespace
}  // namespace assur::output
