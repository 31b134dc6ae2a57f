#include "output/page.hpp"

#include <gtest/gtest.h>

#include <sstream>

namespace assur::output {
namespace {

TEST(Page, FactsAreAlignedAndWrappedUnderThemselves) {
  std::ostringstream out;
  Page page(out);
  page.fact("status", "done");
  page.fact("", std::string(62, 'x') + " next");
  page.fact("a label that is too long", "text");
  EXPECT_EQ(out.str(),
            "  status          done\n"
            "                  " +
                std::string(62, 'x') +
                "\n"
                "                  next\n"
                "  a label that is too long text\n");
}

TEST(Page, ListsNameTheFirstAndCountTheRest) {
  std::ostringstream out;
  Page(out).list("notes", std::vector<std::string>(14, "text"));
  std::string expected = "  notes           text\n";
  for (int i = 1; i < 12; ++i) expected += "                  text\n";
  EXPECT_EQ(out.str(), expected + "                  and 2 more\n");
}

TEST(Page, TableColumnsAreAsWideAsTheirWidestCell) {
  using enum Table::Align;
  std::ostringstream out;
  Table table({left, right, left});
  table.row({"group", "n", "note"}).row({"SG_T", "1,200", ""}).row({"é", "3", "x"});
  Page(out).table(table);
  EXPECT_EQ(out.str(),
            "  group      n  note\n"
            "  SG_T   1,200\n"
            "  é          3  x\n");
}

}  // namespace
}  // namespace assur::output
