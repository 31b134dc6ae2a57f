// Sections about the paper: from artificial times, and from a run of a second or two.
#include "report/paper/tables.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "assur/backend.hpp"
#include "report/paper/conclusions.hpp"

namespace assur::report {
namespace {

const Section& section(const std::vector<Section>& all, const std::string& id) {
  return *std::find_if(all.begin(), all.end(), [&](const Section& s) { return s.id == id; });
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

PaperTiming made_up(const std::string& version, int p, int q, Reading reading, double seconds) {
  PaperTiming t;
  t.cell = cells_of_table(2)[0];
  t.version = version;
  t.strategy = version + " stands for it";
  t.split = {p, q};
  t.reading = reading;
  t.seconds = seconds;
  t.spread = seconds / 100;
  t.rounds = 9;
  t.deviation = 1e-15;
  return t;
}

PaperResults made_up() {
  PaperResults r;
  r.threads = 2;
  r.stand_ins = {"lapack", "", "klu", false};
  r.times = {made_up("GMA27", 1, 1, Reading::shared, 12e-6),      made_up("GMA27", 1, 1, Reading::separate, 14e-6),
             made_up("GMKL", 1, 1, Reading::shared, 96e-6),       made_up("GEOMP+MKL", 1, 1, Reading::shared, 30e-6),
             made_up("GEOMP+MKL", 2, 1, Reading::shared, 24e-6),  made_up("GEOMP+MKL", 2, 1, Reading::separate, 35e-6),
             made_up("GEOMP+MA27", 1, 1, Reading::shared, 16e-6), made_up("auto", 1, 1, Reading::shared, 3e-6)};
  return r;
}

TEST(PaperSections, AreOneForEachTableAndFigure) {
  const std::vector<Section> all = paper_sections(made_up(), PaperOptions());
  std::vector<std::string> ids;
  for (const Section& s : all) {
    ids.push_back(s.id);
    EXPECT_FALSE(s.title.empty());
    EXPECT_FALSE(s.body.empty());
    for (const Measurement& m : s.measurements) {
      EXPECT_FALSE(m.origin.empty());
      EXPECT_GT(m.value, 0);
    }
  }
  EXPECT_EQ(ids, (std::vector<std::string>{"paper-table-2", "paper-figure-2", "paper-table-3", "paper-figure-3",
                                           "paper-table-4", "paper-table-5", "paper-conclusions"}));
}

TEST(PaperSections, RatiosFollowFromTheTimes) {
  const Section s = section(paper_sections(made_up(), PaperOptions()), "paper-table-2");
  // Speed-ups over GMA27: GMKL has 4.19 / 2.52 in the paper and 12 / 96 here. GEOMP+MKL has 4.19 / 0.53 in the paper,
  // 12 / 24 here, and 14 / 35 with separate factorisations.
  EXPECT_TRUE(has(s.body,
                  ">102</td><td class=\"number\">15</td><td class=\"number\">1.66</td><td class=\"number\">"
                  "0.125</td><td class=\"number\">-</td><td class=\"number\">7.91</td><td class=\"number\">"
                  "0.500</td><td class=\"number\">0.400</td><td class=\"number\">5.66</td><td class=\"number\">"
                  "0.750</td><td class=\"number\">-</td><td class=\"number\">4.00</td><td>GEOMP+<wbr>MKL</td>"
                  "<td>GMA27</td>"))
      << s.body;
  EXPECT_TRUE(has(s.body, "0.480 (2x1)")) << "24 us times 20,000 steps";
  EXPECT_TRUE(has(s.body, "not part of --quick"));
}

TEST(PaperSections, MeasurementsCarryTheirOrigin) {
  const Section s = section(paper_sections(made_up(), PaperOptions()), "paper-table-2");
  const auto find = [&](const std::string& strategy) {
    return *std::find_if(s.measurements.begin(), s.measurements.end(),
                         [&](const Measurement& m) { return m.strategy == strategy; });
  };
  const Measurement theirs = find("GEOMP+MKL 3x1");
  EXPECT_DOUBLE_EQ(theirs.value * 20000, 0.53);
  EXPECT_EQ(theirs.repetitions, 0);
  EXPECT_TRUE(std::isnan(theirs.error));
  EXPECT_EQ(theirs.origin, "paper, table 2, Core i5-2400, 4 cores");
  const Measurement ours = find("GMA27 stands for it");
  EXPECT_EQ(ours.value, 12e-6);
  EXPECT_EQ(ours.repetitions, 9);
  EXPECT_DOUBLE_EQ(ours.spread, 0.01);
  EXPECT_EQ(ours.error, 1e-15);
  EXPECT_EQ(ours.origin, "measured, as GMA27 1x1, shared");
}

TEST(PaperSections, AGpuHasColumnsAndParts) {
  PaperResults r = made_up();
  EXPECT_TRUE(has(section(paper_sections(r, PaperOptions()), "paper-table-5").body, "no GPU here"));
  r.stand_ins.devices = {"cusolver"};
  r.device_parts = {{18, 9, {{1e-3, 2e-3, 4e-3, 9e-3}, {1e-4, 2e-4, 4e-4, 1e-3}, 3e-16}, 0.04, 0.01}};
  PaperTiming cpu = made_up("GEOMP+MKL", 2, 1, Reading::shared, 0.1),
              gpu = made_up("GEMAGMA", 1, 1, Reading::shared, 0.4);
  cpu.cell = gpu.cell = cells_of_table(5)[0];
  r.times = {cpu, gpu};
  const Section five = section(paper_sections(r, PaperOptions()), "paper-table-5");
  EXPECT_TRUE(has(five.body, "2x1/<wbr>GPU, here"));
  EXPECT_TRUE(has(five.body, "<td class=\"number\">0.250</td>"));
  EXPECT_TRUE(has(five.body, "GPU here: cusolver ("));
  EXPECT_FALSE(has(five.body, "no GPU here"));
  EXPECT_TRUE(has(five.body, "LU: launches and rest, ms"));
  EXPECT_TRUE(has(five.body,
                  "<tr><td class=\"number\">18</td><td class=\"number\">9.00</td><td class=\"number\">1.00</td>"
                  "<td class=\"number\">2.00</td><td class=\"number\">4.00</td><td class=\"number\">2.00</td>"))
      << five.body;
  EXPECT_TRUE(has(five.body, "LU by lapack 1x2, ms"));
  EXPECT_TRUE(has(five.body, "<td class=\"number\">40.0</td><td class=\"number\">5.00</td><td"));
  const auto part = std::find_if(five.measurements.begin(), five.measurements.end(),
                                 [](const Measurement& m) { return m.quantity == "solution, launches and rest"; });
  ASSERT_NE(part, five.measurements.end());
  EXPECT_DOUBLE_EQ(part->value, 3e-4);
  EXPECT_EQ(part->error, 3e-16);

  gpu.cell = cpu.cell = cells_of_table(4)[0];
  r.times = {cpu, gpu};
  const Section four = section(paper_sections(r, PaperOptions()), "paper-table-4");
  EXPECT_TRUE(has(four.body, "GEOMP+<wbr>MKL over GPU"));
  EXPECT_TRUE(has(four.body, "GPU, here, s"));
}

TEST(PaperSections, EnergyIsMeasuredOrMarkedAsEstimate) {
  PaperResults r = made_up();
  PaperTiming t = made_up("GEOMP+MKL", 2, 1, Reading::shared, 1e-3);
  t.cell = cells_of_table(4)[0];
  t.joules = 6;
  r.times = {t};
  const auto energy_of = [&](const PaperOptions& options) {
    const Section s = section(paper_sections(r, options), "paper-table-4");
    return *std::find_if(s.measurements.begin(), s.measurements.end(),
                         [](const Measurement& m) { return m.quantity.starts_with("energy") && m.repetitions > 0; });
  };
  PaperOptions options;
  options.meter = EnergyMeter("/nowhere");
  options.watts = 20;
  EXPECT_DOUBLE_EQ(energy_of(options).value, 300 * 1e-3 * 20);
  EXPECT_TRUE(energy_of(options).origin.starts_with("estimated from time x 20 W"));
  options.watts = 0;
  EXPECT_DOUBLE_EQ(energy_of(options).value, 300 * 1e-3 * 95 / 6 * 2);
  EXPECT_TRUE(has(energy_of(options).origin, "an assumption"));
}

// The time suffices for the smallest cells.
TEST(PaperRun, TimesVerifiedStrategiesAndExplainsOthers) {
  PaperOptions options;
  options.conditions = {.seconds = 2, .quick = true, .threads = 2};
  options.model = std::make_shared<const PerformanceModel>();
  const PaperResults r = run_the_paper(options);
  EXPECT_FALSE(r.interrupted);
  int timed = 0;
  for (const PaperTiming& t : r.times) {
    EXPECT_NE(t.timed(), !t.why_not.empty()) << t.strategy << " " << t.why_not;
    if (!t.timed()) continue;
    ++timed;
    EXPECT_LT(t.deviation, 1e-9) << t.strategy;  // residuals of 1e-14 at most, conditions of 23
    EXPECT_GT(t.rounds, 0);
    EXPECT_GT(t.steps_timed, 0);
    if (t.cell.iterations > 1) {
      EXPECT_LE(t.newton, t.cell.iterations);
      // One of seven groups, the terminal, takes fewer iterations.
      EXPECT_GT(t.newton, 0.8 * t.cell.iterations) << t.strategy;
    }
  }
  EXPECT_GT(timed, 0);

  // Every time of the page is in its measurements.
  const std::vector<Section> all = paper_sections(r, options);
  std::set<std::pair<std::string, double>> known;
  for (const Section& s : all) {
    for (const Measurement& m : s.measurements) known.insert({m.strategy, m.value});
  }
  for (const PaperTiming& t : r.times) {
    if (t.timed()) {
      EXPECT_TRUE(known.contains({t.strategy, t.seconds})) << t.strategy;
    }
  }
}

TEST(PaperRun, NamesMissingTimesIfInterrupted) {
  PaperOptions options;
  options.model = std::make_shared<const PerformanceModel>();
  int looks = 0;
  options.conditions = {.seconds = 60, .quick = true, .interrupted = [&] { return ++looks > 100; }};
  const std::vector<Section> all = reproduce_paper(options);
  ASSERT_EQ(all.size(), 7u);
  EXPECT_TRUE(has(all[0].body, "Interrupted"));
  EXPECT_TRUE(has(all[0].body, "Without times here (interrupted)"));
}

}  // namespace
}  // namespace assur::report
