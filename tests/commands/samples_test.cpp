#include <gtest/gtest.h>

#include "commands/command.hpp"

namespace assur {
namespace {

TEST(Samples, ListsSamplesAndFiles) {
  const Outcome page = run_command({"samples"});
  ASSERT_EQ(page.status, 0) << page.err;
  EXPECT_NE(page.out.find("four_bar[:loops]"), std::string::npos) << page.out;
  EXPECT_NE(page.out.find("bennett           Bennett's linkage\n"), std::string::npos);

  const auto json = run_command({"samples", "--json"}).json();
  for (const auto& list : {json["samples"], json["files"]}) {
    EXPECT_GE(list.size(), 12U);
    for (const auto& row : list) {
      EXPECT_EQ(run_command({"inspect", row["name"], "--json"}).json()["scene"], row["name"]);
      EXPECT_FALSE(row["summary"].get<std::string>().empty());
    }
  }
  EXPECT_EQ(json["samples"][0]["options"][0]["name"], "delta");
  EXPECT_EQ(json["samples"][0]["options"][0]["default"], 1e-6);
}

}  // namespace
}  // namespace assur
