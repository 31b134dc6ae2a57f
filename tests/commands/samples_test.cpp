#include <gtest/gtest.h>

#include "commands/command.hpp"
#include "source_dir.hpp"

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

// docs/mechanisms.md shows every sample and every file of scenes/, each in a picture of the program.
TEST(Samples, HaveTheirPictures) {
  const std::string docs = std::string(ASSUR_SOURCE_DIR) + "/docs/", page = content(docs + "mechanisms.md");
  const auto json = run_command({"samples", "--json"}).json();
  for (const auto& list : {json["samples"], json["files"]}) {
    for (const auto& row : list) {
      const std::string name = row["name"], picture = "pictures/" + name + ".svg";
      EXPECT_NE(page.find("](" + picture + ")"), std::string::npos) << name;
      EXPECT_NE(page.find("`assur run " + name), std::string::npos) << name;
      const std::string svg = content(docs + picture);
      EXPECT_EQ(svg.find("<svg xmlns=\"http://www.w3.org/2000/svg\""), 0u) << name;
      EXPECT_NE(svg.find("<title>" + name + "</title>"), std::string::npos) << name;
      EXPECT_LE(svg.size(), 60000u) << name;
    }
  }
}

}  // namespace
}  // namespace assur
