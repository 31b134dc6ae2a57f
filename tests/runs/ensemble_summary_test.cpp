// Summaries of ensembles equal those of the stored rows bit by bit, and their memory does not grow with the times.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <stdexcept>

#include "backends/allocations.hpp"
#include "runs/ensembles.hpp"

namespace assur::test {
namespace {

// NaN equals NaN.
void expect_bits(double a, double b, const std::string& what) {
  EXPECT_TRUE(a == b || (std::isnan(a) && std::isnan(b))) << what << ": " << a << " and " << b;
}

// Compares all columns of all members.
void expect_summaries_of(const EnsembleTrajectory& all, const EnsembleSummary& summary) {
  ASSERT_EQ(summary.members(), all.members());
  ASSERT_EQ(summary.columns(), all.columns());
  for (std::size_t i = 0; i < all.members(); ++i) {
    ASSERT_EQ(summary.rows(i), all.rows(i)) << i;
    for (std::size_t c = 0; c < all.columns().size(); ++c) {
      const std::string what = "member " + std::to_string(i) + ", " + all.columns()[c];
      const ColumnSummary& s = summary(i, c);
      if (all.rows(i) == 0) {
        for (const double figure : {s.minimum, s.maximum, s.minimum_time, s.maximum_time, s.mean, s.last, s.range()}) {
          EXPECT_TRUE(std::isnan(figure)) << what;
        }
        continue;
      }
      std::size_t low = 0, high = 0;
      double sum = 0;
      for (std::size_t k = 0; k < all.rows(i); ++k) {
        const double x = all(i, k, c);
        if (x < all(i, low, c) || (std::isnan(x) && !std::isnan(all(i, low, c)))) low = k;
        if (x > all(i, high, c) || (std::isnan(x) && !std::isnan(all(i, high, c)))) high = k;
        sum += x;
      }
      expect_bits(s.minimum, all(i, low, c), what);
      expect_bits(s.maximum, all(i, high, c), what);
      EXPECT_EQ(s.minimum_time, all.times()[low]) << what;
      EXPECT_EQ(s.maximum_time, all.times()[high]) << what;
      expect_bits(s.mean, sum / static_cast<double>(all.rows(i)), what);
      expect_bits(s.last, all(i, all.rows(i) - 1, c), what);
      expect_bits(s.range(), all(i, high, c) - all(i, low, c), what);
    }
  }
}

// Two columns that were kept alone, in another order.
void expect_columns_of(const EnsembleTrajectory& all, const EnsembleTrajectory& some, std::size_t first,
                       std::size_t second) {
  ASSERT_EQ(some.members(), all.members());
  ASSERT_EQ(some.columns(), (std::vector{all.columns()[first], all.columns()[second]}));
  ASSERT_EQ(some.times(), all.times());
  for (std::size_t i = 0; i < all.members(); ++i) {
    EXPECT_EQ(some.rows(i), all.rows(i)) << i;
    for (std::size_t k = 0; k < all.times().size(); ++k) {
      const std::string what = "member " + std::to_string(i) + ", row " + std::to_string(k);
      expect_bits(some(i, k, 0), all(i, k, first), what);
      expect_bits(some(i, k, 1), all(i, k, second), what);
    }
  }
}

// The same outcomes as well.
void expect_as_stored(std::size_t members, const SceneOf& scene, const std::string& strategy) {
  SCOPED_TRACE(scene(0).name() + ", " + strategy);
  Ensemble e = ensemble(members, scene, strategy);
  const EnsembleTrajectory all = e.run();
  const std::vector<Ensemble::Outcome> outcomes = e.outcomes();
  const Report report = e.report();
  const EnsembleSummary summary = e.summarize(all.columns());
  expect_summaries_of(all, summary);
  for (std::size_t i = 0; i < members; ++i) {
    EXPECT_EQ(e.outcomes()[i].status.code, outcomes[i].status.code) << i;
    EXPECT_EQ(e.outcomes()[i].reached, outcomes[i].reached) << i;
    EXPECT_EQ(e.outcomes()[i].alone, outcomes[i].alone) << i;
    EXPECT_EQ(e.outcomes()[i].events.size(), outcomes[i].events.size()) << i;
  }
  EXPECT_EQ(e.report().counters.steps, report.counters.steps);
  EXPECT_EQ(e.report().counters.stored_values, 0);
  EXPECT_EQ(e.report().fallbacks, report.fallbacks);

  const std::size_t last = all.columns().size() - 1;
  expect_columns_of(all, e.run({all.columns()[last], all.columns()[0]}), last, 0);
  EXPECT_EQ(e.report().fallbacks, report.fallbacks);
  EXPECT_EQ(e.report().counters.stored_values,
            2 * report.counters.stored_values / static_cast<std::int64_t>(all.columns().size()));
}

TEST(EnsembleSummary, EqualsTheStoredRows) {
  for (const std::string strategy : {"groups/eigen:4", "irreducible/lanes:8", "groups/lanes:2 2x1"}) {
    for (const SceneOf& scene : {SceneOf(four_bar), SceneOf(slider_crank), SceneOf(partly_limited)}) {
      expect_as_stored(11, scene, strategy);
    }
  }
}

// A member that ends lets the others start again, which goes on counting their turns.
TEST(EnsembleSummary, GoesOnWhenAMemberEnds) {
  std::vector<double> t, a;
  for (int k = 0; k <= 20; ++k) {
    t.push_back(0.123 * k);
    a.push_back(0.123 * k * 7);
  }
  const SceneOf scene = [&](std::size_t i) {
    return with_law(i == 1 ? Law::table(t, a) : Law::polynomial({0, 6.5 + 0.5 * static_cast<double>(i)}), 8);
  };
  expect_as_stored(3, scene, "groups/eigen:4");
}

// Members that leave the others at the first step let these begin again. Each row counts once nevertheless.
TEST(EnsembleSummary, MembersThatEndOrDivideTheFirstSteps) {
  const SceneOf scene = [](std::size_t i) {
    const double rate = i % 3 == 0 ? 0.4 : 3 * static_cast<double>(i * i);
    return limited_four_bar(Law::polynomial({0.5, rate})).time(0, 1.5, 0.01).build();
  };
  for (const std::string strategy : {"groups/eigen:4", "irreducible/lanes:8", "groups/lanes:2 2x1"}) {
    expect_as_stored(13, scene, strategy);
  }
}

// The same in a table: the third coupler is too short, and that of the fifth reaches the rocker hardly.
TEST(EnsembleSummary, MembersOfATableThatEndAtTheStart) {
  Ensemble e(sample("four_bar:1").with_time({0, 0.1, 0.01}), {"coupler1", "rocker1"},
             {1.8, 1.3, 1.9, 1.2, 0.1, 1.3, 1.7, 1.3, 2.4999, 1.3});
  const EnsembleTrajectory all = e.run();
  EXPECT_LT(all.rows(2), 2U);
  expect_summaries_of(all, e.summarize(all.columns()));
}

// The others begin again at the first row, which counts once.
TEST(EnsembleSummary, GoesOnWhenAMemberCannotTakeTheFirstStep) {
  const SceneOf scene = [](std::size_t i) { return with_law(Law::polynomial({0, i == 1 ? 2000. : 6.5}), 8); };
  expect_as_stored(3, scene, "groups/eigen:4");
  Ensemble e = ensemble(3, scene, "groups/eigen:4");
  (void)e.run();
  EXPECT_TRUE(e.outcomes()[1].alone);
  EXPECT_EQ(e.outcomes()[1].alone_from, 0);
  EXPECT_FALSE(e.outcomes()[0].alone);
}

TEST(EnsembleSummary, HasMembersOfAnotherStructure) {
  const SceneOf scene = [](std::size_t i) {
    return i == 1 || i == 3 ? on_a_rail() : with_law(Law::polynomial({0, 3})).with_outputs({"B", "C"});
  };
  expect_as_stored(5, scene, "groups/eigen:4");
}

TEST(EnsembleSummary, TakesSomeColumnsOverGivenTimes) {
  Ensemble e = ensemble(11, four_bar, "groups/lanes:8");
  const std::vector<double> times = {0, 0.02, 0.05, 0.3};
  const EnsembleTrajectory all = e.run(times);
  const std::vector<std::string> some = {all.columns()[5], all.columns()[2]};
  const EnsembleSummary summary = e.summarize(some, times);
  EXPECT_EQ(summary.columns(), some);
  for (std::size_t i = 0; i < 11; ++i) {
    EXPECT_EQ(summary.rows(i), 4u);
    EXPECT_EQ(summary(i, 0).last, all(i, 3, 5));
    EXPECT_EQ(summary(i, 1).last, all(i, 3, 2));
  }
  EXPECT_THROW((void)e.summarize({"no_such_column"}), Error);
  EXPECT_THROW((void)e.summarize(some, std::vector<double>{1.0}), Error);
  expect_columns_of(all, e.run(some, times), 5, 2);
  EXPECT_THROW((void)e.run({"no_such_column"}), Error);
}

TEST(EnsembleSummary, AnObserverStops) {
  Ensemble e = ensemble(4, four_bar, "groups/lanes:4");
  const EnsembleSummary summary = e.summarize({"B1.x"}, [](std::int64_t done, std::int64_t of) {
    EXPECT_EQ(of, 4 * 61);
    return done >= 40;
  });
  EXPECT_EQ(e.report().status.code, Code::interrupted);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(summary.rows(i), 10u);
}

TEST(EnsembleSummary, MemoryDoesNotGrowWithTheTimes) {
  Ensemble e = ensemble(16, chain, "irreducible/lanes:8");
  const std::vector<double> grid = test::grid_of(chain(0));
  const std::vector<std::string> columns = {e.run(std::span(grid).first(2)).columns()[0]};
  const auto taken = [&](std::size_t rows) {
    const std::int64_t before = test::allocations();
    (void)e.summarize(columns, std::span(grid).first(rows));
    return test::allocations() - before;
  };
  (void)taken(61);
  EXPECT_EQ(taken(61), taken(31));
}

// ---- streams

// Rows of all members, put together from the blocks of a stream.
struct Streamed {
  std::vector<std::vector<double>> times, values;  // members
  std::size_t largest = 0;                         // block

  Streamed(Ensemble& e, const RowSelection& selection) : times(e.members()), values(e.members()) {
    std::mutex one_at_a_time;
    e.stream(selection, [&](const MemberRows& rows) {
      const std::scoped_lock lock(one_at_a_time);
      largest = std::max(largest, rows.times.size());
      times[rows.member].insert(times[rows.member].end(), rows.times.begin(), rows.times.end());
      values[rows.member].insert(values[rows.member].end(), rows.values.begin(), rows.values.end());
    });
  }
};

TEST(EnsembleStream, GivesTheStoredRows) {
  for (const std::string strategy : {"groups/eigen:4", "groups/eigen:4 2x1"}) {
    Ensemble e = ensemble(11, partly_limited, strategy);
    const EnsembleTrajectory all = e.run();
    const std::vector<std::string> two = {all.columns()[2], all.columns()[0]};
    for (const RowSelection& selection :
         {RowSelection{}, RowSelection{two, 1, 7}, RowSelection{two, 10}, RowSelection{{}, 3, 1}}) {
      const Streamed streamed(e, selection);
      EXPECT_LE(streamed.largest, selection.block);
      const std::vector<std::string>& columns = selection.columns.empty() ? all.columns() : selection.columns;
      for (std::size_t i = 0; i < all.members(); ++i) {
        const std::size_t rows = (all.rows(i) + selection.every - 1) / selection.every;
        ASSERT_EQ(streamed.times[i].size(), rows) << i;
        ASSERT_EQ(streamed.values[i].size(), rows * columns.size()) << i;
        for (std::size_t k = 0; k < rows; ++k) {
          EXPECT_EQ(streamed.times[i][k], all.times()[k * selection.every]);
          for (std::size_t c = 0; c < columns.size(); ++c) {
            const auto at = std::find(all.columns().begin(), all.columns().end(), columns[c]) - all.columns().begin();
            ASSERT_EQ(streamed.values[i][k * columns.size() + c],
                      all(i, k * selection.every, static_cast<std::size_t>(at)));
          }
        }
      }
      EXPECT_EQ(e.outcomes()[3].cannot.empty(), false);
    }
  }
}

TEST(EnsembleStream, MembersThatRunAlone) {
  Ensemble e = ensemble(3, [](std::size_t i) { return with_law(turning(1 + static_cast<double>(i))); });
  const EnsembleTrajectory all = e.run();
  const Streamed streamed(e, {});
  for (std::size_t i = 0; i < 3; ++i) {
    const auto row = all.row(i, 0);
    EXPECT_TRUE(std::equal(streamed.values[i].begin(), streamed.values[i].end(), row.begin()));
    EXPECT_EQ(streamed.times[i].size(), all.times().size());
  }
}

TEST(EnsembleStream, RefusalsAndExceptions) {
  Ensemble e = ensemble(5, four_bar);
  const auto sink = [](const MemberRows&) {};
  EXPECT_THROW(e.stream({{"nothing"}}, sink), Error);
  EXPECT_THROW(e.stream({{}, 0}, sink), Error);
  EXPECT_THROW(e.stream({{}, 1, 0}, sink), Error);
  EXPECT_THROW(e.stream({}, {}), Error);
  EXPECT_THROW(e.stream({}, [](const MemberRows&) { throw std::runtime_error("full"); }), std::runtime_error);
  EXPECT_EQ(Streamed(e, {}).times[0].size(), 61u);  // it can run again
}

}  // namespace
}  // namespace assur::test
