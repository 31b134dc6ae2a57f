// The locale of the program does not change how numbers are read and written.
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <sstream>

#include "assur/derivatives.hpp"
#include "assur/saved_plan.hpp"
#include "assur/simulator.hpp"
#include "decimal.hpp"
#include "foreign_locale.hpp"
#include "parallel/cgroup.hpp"
#include "parallel/file_tree.hpp"
#include "parallel/longest_first.hpp"
#include "parallel/machine.hpp"
#include "parallel/topology.hpp"

namespace assur::test {
namespace {

constexpr const char* kScene = R"({
  "assur": 1,
  "name": "crank",
  "dimension": 2,
  "parameters": {"crank_length": 0.25, "rod_length": "=4*crank_length+1.5e-1"},
  "points": {
    "O": {"at": [0, 0], "fixed": true},
    "B": {"at": ["=crank_length", 0]},
    "C": {"at": ["=crank_length+rod_length", 0]}
  },
  "vectors": {"rail": {"at": [1, 0], "fixed": true}},
  "constraints": {
    "crank": {"distance": ["O", "B"], "value": "=crank_length"},
    "rod": {"distance": ["B", "C"], "value": "=rod_length"},
    "slide": {"on_line": ["C", "O", "rail"]}
  },
  "drivers": {"motor": {"angle": ["O", "B"], "law": {"table": "law.csv"}}},
  "time": {"start": 0, "end": 0.5, "step": 0.125}
})";

std::string saved(const Prepared& prepared) {
  std::ostringstream out;
  save_plan(out, prepared);
  return out.str();
}

template <class Work>
std::string refusal(Work&& work) {
  try {
    work();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "no refusal";
}

// All results that depend on number formats: texts, plans, and motions as bits.
std::vector<std::string> all_of_it(const FileTree& tree) {
  std::vector<std::string> found;
  PrepareOptions options;
  options.budget = ThreadBudget{3};
  options.model = std::make_shared<const PerformanceModel>();
  for (const std::string& text :
       {std::string("four_bar:loops=8,steps=20"), std::string("rings:legs=6,n=48,terminal=12,steps=20"),
        (tree.root() / "crank.json").string()}) {
    const Prepared prepared = prepare(open_scene(text), options);
    const std::string plan = saved(prepared);
    found.push_back(plan);
    found.push_back(prepared.plan().reason);
    for (const Plan::Choice& choice : prepared.plan().choices) found.push_back(choice.reason);
    std::istringstream in(plan);
    Simulator simulator(load_plan(in, {backends(), ThreadBudget{3}}));
    const Trajectory motion = simulator.run();
    for (const double x : motion.values()) found.push_back(std::to_string(std::bit_cast<std::uint64_t>(x)));
  }
  Machine machine = read_machine(tree.root(), {0, 1, 2, 3}, "4,2");
  found.push_back(to_string(machine));
  found.push_back(std::to_string(machine.openmp_limit));
  found.push_back(std::to_string(cpu_quota(tree.root()) == 1.5));
  for (const int p : parse_processors("0-3,1024-1026")) found.push_back(std::to_string(p));
  found.push_back(refusal([] { (void)longest_first(std::array{-1.5}, 2); }));
  const Law wrong = Law::function([](double t) { return Motion{1234.5 * t, 1.25, 0}; });
  found.push_back(check_derivatives(wrong, 0, 2).at(0).what);
  return found;
}

class Locales : public testing::Test {
 protected:
  Locales() {
    tree_.file("crank.json", kScene).file("law.csv", "t, value\n0, 0.25\n0.25, 0.5\n0.5, 1.5e-1\n");
    tree_.file("proc/self/mountinfo", "1 0 0:1 / /cg rw - cgroup2 cgroup2 rw\n");
    tree_.file("proc/self/cgroup", "0::/\n").file("cg/cpu.max", "150000 100000\n");
    const std::string cache = "sys/devices/system/cpu/cpu0/cache/index0/";
    tree_.file(cache + "level", "1\n").file(cache + "type", "Data\n").file(cache + "size", "1048576K\n");
    expected_ = all_of_it(tree_);
  }

  FileTree tree_;
  std::vector<std::string> expected_;
};

TEST_F(Locales, ExpectedTextsContainNumbers) {
  EXPECT_EQ(expected_.back(),
            "the rate at t = 0.763932 s is 1.25, but differences of the value give 1234.5 (within 1e-12)");
  EXPECT_NE(expected_[0].find("times as fast"), std::string::npos) << expected_[0];
}

TEST_F(Locales, CppLocalesDoNotChangeNumbers) {
  for (const char point : {',', '.'}) {
    const ForeignLocale locale(point);
    std::ostringstream text;
    text << 1234.5;
    ASSERT_EQ(text.str(), point == ',' ? "1.234,5" : "1,234.5");
    EXPECT_EQ(all_of_it(tree_), expected_);
  }
}

TEST_F(Locales, CLocalesDoNotChangeNumbers) {
  const ForeignLocaleOfC locale;
  if (!locale.is_set()) GTEST_SKIP() << "no locale with a decimal comma, and none can be made";
  EXPECT_EQ(all_of_it(tree_), expected_);
}

TEST(Decimal, WritesAsPrintfDoes) {
  for (const double x : {0.0, -0.0, 1.0, 0.1, 123456.789, 1e-9, 9.96, 0.95, 1e300, -2.5, 1.7976931348623157e308}) {
    for (const int digits : {1, 3, 6, 10, 17}) {
      const auto by_printf = [&](const char* format) {
        char text[400];
        std::snprintf(text, sizeof text, format, digits, x);
        return std::string(text);
      };
      EXPECT_EQ(general(x, digits), by_printf("%.*g"));
      EXPECT_EQ(fixed(x, digits), by_printf("%.*f"));
      EXPECT_EQ(scientific(x, digits), by_printf("%.*e"));
    }
  }
}

}  // namespace
}  // namespace assur::test
