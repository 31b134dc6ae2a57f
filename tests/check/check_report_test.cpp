// The output of `assur check` for artificial results.
#include "check/check_report.hpp"

#include <gtest/gtest.h>

#include <sstream>

namespace assur::output {
namespace {

check::Result result_of(const std::string& family, const std::string& name, const check::Verdict& verdict) {
  check::Result r;
  r.what.family = family;
  r.what.name = name;
  r.what.about = "made up";
  r.what.text = "four_bar:3";
  r.what.expected = {{"pass", "inaccurate"}, ""};
  r.add({"groups/eigen", verdict, "", 1e-9, 1e-15});
  r.add({"groups/klu", verdict, "", 1e-12, 1e-16});
  r.condition = 1e3;
  return r;
}

CheckSummary two_cases() {
  CheckSummary s;
  s.results = {result_of("time", "good", "pass"), result_of("time", "bad", "wrong")};
  s.results[1].what.set = {{"omega", 0.1}};
  s.results[1].what.time = TimeGrid{0, 1, 0.25};
  s.results[1].what.outputs = {"B", "C"};
  s.results[1].what.accuracy = 1e-9;
  return s;
}

TEST(CheckReport, CountsCasesByFamily) {
  std::ostringstream out;
  Page page(out);
  print(page, two_cases());
  EXPECT_EQ(out.str().substr(0, out.str().find("\n\n")),
            "  family  cases  unexpected  runs  worst error\n"
            "  time        2           1     4      1.0e-09");
  EXPECT_NE(out.str().find("unexpected      1 case\n"), std::string::npos) << out.str();
}

TEST(CheckReport, PrintsTheCommandThatRepeatsAFailure) {
  std::ostringstream out;
  Page page(out);
  print_failures(page, two_cases());
  EXPECT_EQ(out.str().find("good"), std::string::npos);
  EXPECT_NE(out.str().find("time: bad\n"), std::string::npos) << out.str();
  EXPECT_NE(out.str().find("groups/klu"), std::string::npos);
  EXPECT_EQ(how_to_repeat(two_cases().results[1].what, "groups/eigen"),
            "assur run 'four_bar:3' --set omega=0.1 --start 0 --dt 0.25 --steps 4 --outputs B,C --strategy "
            "'groups/eigen' --accuracy 1e-09 --reference");
  check::Case own;
  own.name = "law_to_nan";
  own.maker = "law_to_nan";
  EXPECT_EQ(how_to_repeat(own, "groups/eigen"), "assur check --case 'law_to_nan'");
  own.scene = "{}";
  own.name = "a step=1";
  EXPECT_EQ(how_to_repeat(own, "reading"), "assur run 'a_step_1.json' --reference");
}

TEST(CheckReport, JsonHasOneRowForEachCase) {
  const Json json = to_json(two_cases());
  ASSERT_EQ(json["cases"].size(), 2u);
  EXPECT_EQ(json["cases"][0]["expected"], "pass or inaccurate");
  EXPECT_EQ(json["cases"][0]["forward_error"], 1e-9);
  EXPECT_EQ(json["cases"][1]["verdict"], "wrong");
  EXPECT_TRUE(json["cases"][0]["bound"].is_null());
  EXPECT_EQ(json["passed"], 1);
  EXPECT_EQ(json["failed"], 1);
}

}  // namespace
}  // namespace assur::output
