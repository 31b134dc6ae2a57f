#include "output/page.hpp"

#include <gtest/gtest.h>

#include <sstream>

namespace assur::output {
namespace {

TEST(Page, AlignsAndWrapsFacts) {
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

TEST(Page, TableColumnsFitTheirWidestCell) {
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

TEST(Page, KeepsToTheColumnsOfItsTerminal) {
  using enum Table::Align;
  Table table({left, right, left, left});
  table.row({"group", "n", "strategy", "note"}).row({"SG_T", "1,200", "groups/klu", "slow"}).row({"é", "3", "x", ""});
  const auto printed = [&](std::size_t columns) {
    std::ostringstream out;
    Page page(out, columns);
    page.table(table);
    page.fact("status", "it ends as soon as it may");
    return out.str();
  };
  const std::string whole =
      "  group      n  strategy    note\n"
      "  SG_T   1,200  groups/klu  slow\n"
      "  é          3  x\n"
      "  status          it ends as soon as it may\n";
  for (const std::size_t columns : {0, 43, 500}) EXPECT_EQ(printed(columns), whole) << columns;
  EXPECT_EQ(printed(31),
            "  group      n  strategy\n"
            "    note\n"
            "  SG_T   1,200  groups/klu\n"
            "    slow\n"
            "  é          3  x\n"
            "  status          it ends as soon as\n"
            "                  it may\n");
  EXPECT_TRUE(
      printed(20).starts_with("  group      n\n"
                              "    strategy    note\n"
                              "  SG_T   1,200\n"
                              "    groups/klu  slow\n"))
      << printed(20);
}

TEST(Page, WrapsASentenceInTheLastCell) {
  using enum Table::Align;
  std::ostringstream out;
  Page(out, 24).table(Table({left, left}).row({"coordinates", "of points, vectors and auxiliaries"}));
  EXPECT_EQ(out.str(),
            "  coordinates\n"
            "    of points, vectors\n"
            "    and auxiliaries\n");
}

TEST(Page, OnlyStandardStreamsAreTerminals) { EXPECT_EQ(terminal_columns(std::ostringstream()), 0u); }

}  // namespace
}  // namespace assur::output
