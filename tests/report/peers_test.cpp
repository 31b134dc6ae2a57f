// Other libraries, from a file with their times.
#include <gtest/gtest.h>

#include <sstream>

#include "assur/status.hpp"
#include "report/sections.hpp"

namespace assur::report {
namespace {

const std::string kHead =
    "peer,mechanism,levels,steps,seconds_per_step,spread,repetitions,position_error,velocity_error,acceleration_error,"
    "comment\n";

Section section_of(const std::string& rows) {
  std::istringstream in(kHead + rows);
  return peers_section(in, "peers.csv");
}

TEST(Peers, AreComparedWithTheFastestRowOfAssur) {
  const Section s = section_of(
      "assur 0.1,stewart,3,1000,2e-06,0.01,7,1e-15,2e-15,3e-15,auto\n"
      "assur 0.1,stewart,3,1000,4e-06,0.01,7,1e-15,2e-15,3e-15,groups/klu\n"
      "assur 0.1,stewart,1,1000,1e-06,0.01,7,1e-15,,,auto\n"
      "simbody 3.7,stewart,3,1000,0.001,0.02,7,1e-13,4e-12,3e-12,as its manual says\n"
      "slvs,four_bar:1,1,1000,5e-05,0.02,7,1e-9,,,\n");
  std::vector<std::pair<std::string, double>> ratios;
  for (const Measurement& m : s.measurements) {
    if (m.quantity == "time over that of assur") ratios.emplace_back(m.strategy, m.value);
    if (m.strategy == "simbody 3.7" && m.unit == "s") {
      EXPECT_EQ(m.value, 0.001);
      EXPECT_EQ(m.repetitions, 7);
      EXPECT_EQ(m.error, 4e-12);
      EXPECT_NE(m.origin.find("peers.csv"), std::string::npos);
    }
  }
  ASSERT_EQ(ratios.size(), 2u);
  EXPECT_EQ(ratios[0], std::pair(std::string("assur 0.1"), 2.0));
  EXPECT_EQ(ratios[1].first, "simbody 3.7");
  EXPECT_NEAR(ratios[1].second, 500, 1e-9);
  EXPECT_NE(s.body.find("and acceleration"), std::string::npos);
  EXPECT_NE(s.body.find("as its manual says"), std::string::npos);
}

TEST(Peers, RefusesOtherFilesAndNamesTheLine) {
  const auto what = [](const std::string& text) -> std::string {
    std::istringstream in(text);
    try {
      (void)peers_section(in, "f.csv");
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), Error::Kind::input);
      return error.what();
    }
    return "";
  };
  EXPECT_NE(what("t,x\n").find("f.csv, line 1"), std::string::npos);
  EXPECT_NE(what(kHead + "simbody,stewart,3\n").find("f.csv, line 2"), std::string::npos);
  EXPECT_NE(what(kHead + "simbody,stewart,4,10,1e-6,0,1,0,0,0,\n").find("levels"), std::string::npos);
  EXPECT_NE(what(kHead + "simbody,stewart,1,10,fast,0,1,0,,,\n").find("'fast'"), std::string::npos);
  EXPECT_NE(what(kHead + "simbody,stewart,1,10,-1,0,1,0,,,\n").find("> 0"), std::string::npos);
}

}  // namespace
}  // namespace assur::report
