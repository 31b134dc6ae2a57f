// The model on an artificial machine with known times.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "assur/performance.hpp"
#include "assur/plan.hpp"
#include "assur/status.hpp"
#include "made_up_machine.hpp"

namespace assur {
namespace {

using namespace made_up;

// Sizes between the sampled ones; sparse with three nonzeros in each row, and full.
std::vector<Shape> unseen() {
  std::vector<Shape> shapes;
  for (const std::int32_t n : {5, 9, 15, 22, 45, 78, 130, 334, 700, 1200}) shapes.push_back(sparse_shape(n));
  for (const std::int32_t n : {5, 9, 22, 78}) shapes.push_back(full_shape(n));
  return shapes;
}

double off_by(const Prediction& predicted, double truth) { return std::abs(predicted.seconds / truth - 1); }

TEST(PerformanceModel, PredictsKernelsBetweenSampledSizes) {
  const PerformanceModel model(samples());
  for (const Shape& shape : unseen()) {
    for (const Strategy& s : {solver("lanes"), solver("lanes", 8), solver("klu"), solver("eigen")}) {
      for (const Kernel kernel : {Kernel::factor, Kernel::solve}) {
        const Prediction predicted = model.kernel(kernel, shape, s);
        // The samples have noise of 1 % and a bend that no term follows.
        EXPECT_LT(off_by(predicted, truth(kernel, shape, s)), 0.08)
            << name(kernel) << " " << s.solver.backend << ":" << s.solver.lanes << " n = " << shape.n
            << " nnz = " << shape.nnz;
        if (shape.n < 500) {
          EXPECT_EQ(predicted.origin, Origin::interpolated);
        }
      }
    }
  }
}

TEST(PerformanceModel, PredictsUnsampledPacksFromKernels) {
  const PerformanceModel model(samples());
  for (const Shape& shape : unseen()) {
    for (Strategy s : {solver("klu"), solver("eigen"), solver("lanes", 4)}) {
      if (shape.n > 500 && s.solver.backend == "eigen") continue;
      for (const bool once : {false, true}) {
        s.solver.once = once;
        EXPECT_LT(off_by(model.pack(shape, s), truth(Kernel::pack, shape, s)), 0.1)
            << s.solver.backend << " n = " << shape.n << " nnz = " << shape.nnz << " once " << once;
      }
    }
  }
}

// If all samples are of one backend, each other backend has its own prior, whether strategies are predicted together or
// one by one.
TEST(PerformanceModel, PredictsUnsampledBackendsApart) {
  std::vector<Sample> of_one = samples();
  std::erase_if(of_one, [](const Sample& s) { return s.strategy.solver.backend != "lanes"; });
  const PerformanceModel model(of_one);
  const Shape shape = sparse_shape(45);
  const std::array others = {solver("lapack"), solver("klu"), solver("mumps")};
  const std::vector<Prediction> together = model.packs(shape, others);
  for (std::size_t i = 0; i < others.size(); ++i) {
    EXPECT_EQ(together[i].seconds, model.pack(shape, others[i]).seconds) << others[i].solver.backend;
  }
  EXPECT_NE(together[0].seconds, together[1].seconds);
  EXPECT_NE(together[1].seconds, together[2].seconds);
}

// A fit to few samples must not predict impossible times far from them.
TEST(PerformanceModel, PredictsReasonableTimesFromFewSamples) {
  std::mt19937_64 random(3);
  const std::vector<Sample> all = samples(0.05, 7);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<Sample> few;
    const double kept = std::exp(std::uniform_real_distribution<double>(std::log(0.005), std::log(0.2))(random));
    for (const Sample& s : all) {
      if (std::uniform_real_distribution<double>(0, 1)(random) < kept) few.push_back(s);
    }
    const PerformanceModel model(few);
    for (const Shape& shape : {sparse_shape(3), sparse_shape(15), full_shape(30), sparse_shape(334)}) {
      for (const Strategy& s : {solver("lanes", 8), solver("klu"), solver("eigen"), solver("lapack", 2)}) {
        for (const Kernel kernel : {Kernel::factor, Kernel::solve, Kernel::pack}) {
          EXPECT_GT(model.kernel(kernel, shape, s).seconds, truth(kernel, shape, s) / 30)
              << name(kernel) << " " << to_string(s) << " n = " << shape.n << ", " << few.size() << " samples";
        }
      }
    }
  }
}

// The cost of a policy beyond its kernels depends more on the policy than on the number of lanes.
TEST(PerformanceModel, PredictsUnsampledLaneWidths) {
  std::mt19937_64 random(5);
  std::vector<Sample> known = samples();
  for (const std::int32_t n : {6, 12, 25, 50, 100}) {
    for (const std::int32_t lanes : {1, 2, 8, 16}) {
      Strategy s = solver("klu", lanes);
      known.push_back(sample_of(Kernel::pack, sparse_shape(n), s, 0.01, random));
      if (lanes == 1 || lanes == 16) continue;
      s.solver.once = true;
      known.push_back(sample_of(Kernel::pack, sparse_shape(n), s, 0.01, random));
      known.back().seconds *= lanes == 2 ? 1.8 : 1.4;
    }
  }
  const PerformanceModel model(known);
  Strategy s = solver("klu", 16);
  s.solver.once = true;
  EXPECT_LT(off_by(model.pack(sparse_shape(22), s), 1.4 * truth(Kernel::pack, sparse_shape(22), s)), 0.1);
  s.solver.lanes = 1;
  EXPECT_LT(off_by(model.pack(sparse_shape(22), s), 1.8 * truth(Kernel::pack, sparse_shape(22), s)), 0.1);
}

// Packs of +together and of one level have samples of their own. Unknown ones follow the nearest W.
TEST(PerformanceModel, TellsStepsOfAllLevelsFromStepsOfOne) {
  const Shape shape = sparse_shape(2, 100);
  const auto together = [](std::int32_t lanes) {
    Strategy s = solver("lanes", lanes);
    s.run.together = true;
    return s;
  };
  const PerformanceModel unknown;
  EXPECT_GT(unknown.pack(shape, together(8)).seconds, unknown.pack(shape, solver("lanes", 8)).seconds);
  EXPECT_EQ(unknown.pack(shape, together(8)).origin, Origin::prior);
  std::mt19937_64 random(3);
  std::vector<Sample> known;
  for (const Strategy& s : {solver("lanes", 8), together(8), together(16)}) {
    known.push_back(sample_of(Kernel::pack, shape, s, 0, random));
    known.back().seconds = prior_seconds(Kernel::pack, shape, s) * (s.run.together ? 3 : 1);
  }
  const PerformanceModel model(known);
  for (const Sample& s : known) EXPECT_EQ(model.pack(shape, s.strategy).seconds, s.seconds) << to_string(s.strategy);
  EXPECT_LT(off_by(model.pack(shape, together(4)), 3 * prior_seconds(Kernel::pack, shape, together(4))), 0.1);
  const PerformanceModel older({known[0]});  // samples of a tuner that did not measure +together
  EXPECT_LT(off_by(older.pack(shape, together(8)), prior_seconds(Kernel::pack, shape, together(8))), 0.5);
}

TEST(PerformanceModel, ReturnsMeasuredTimesUnchanged) {
  std::vector<Sample> known = samples();
  const auto pack = std::find_if(known.begin(), known.end(), [](const Sample& s) { return s.kernel == Kernel::pack; });
  pack->seconds *= 2;  // although no other sample is like it
  const Sample odd = *pack;
  const Prediction predicted = PerformanceModel(known).pack(odd.shape, odd.strategy);
  EXPECT_EQ(predicted.seconds, odd.seconds);
  EXPECT_EQ(predicted.origin, Origin::measured);
}

TEST(PerformanceModel, UsesTheMedianOfRepeatedSamples) {
  std::mt19937_64 random(3);
  std::vector<Sample> known;
  for (const double factor : {1.0, 1.1, 9.0}) {
    known.push_back(sample_of(Kernel::factor, sparse_shape(20), solver("klu"), 0, random));
    known.back().seconds *= factor;
  }
  EXPECT_DOUBLE_EQ(PerformanceModel(known).kernel(Kernel::factor, sparse_shape(20), solver("klu")).seconds,
                   1.1 * truth(Kernel::factor, sparse_shape(20), solver("klu")));
}

// A tuning beside another program does not spoil one on a quiet machine.
TEST(PerformanceModel, QuietSamplesCountMoreThanNoisyOnes) {
  std::mt19937_64 random(3);
  std::vector<Sample> known;
  for (const auto& [factor, noise] : {std::pair{1.0, 0.01}, {1.02, 0.03}, {1.7, 0.3}, {1.8, 0.4}, {1.9, 0.3}}) {
    known.push_back(sample_of(Kernel::factor, sparse_shape(20), solver("klu"), 0, random));
    known.back().seconds *= factor;
    known.back().spread = noise * known.back().seconds;
  }
  const Prediction p = PerformanceModel(known).kernel(Kernel::factor, sparse_shape(20), solver("klu"));
  EXPECT_DOUBLE_EQ(p.seconds, 1.01 * truth(Kernel::factor, sparse_shape(20), solver("klu")));
  EXPECT_LT(p.factor, 1.05);
}

TEST(PerformanceModel, AnOutlierDoesNotSpoilItsNeighbours) {
  std::vector<Sample> known = samples();
  std::mt19937_64 random(2);
  known.push_back(sample_of(Kernel::factor, sparse_shape(60), solver("klu"), 0, random));
  known.back().seconds *= 20;
  known.back().spread = known.back().seconds;  // disturbed samples scatter
  const PerformanceModel model(known);
  for (const std::int32_t n : {22, 78, 334}) {
    EXPECT_LT(off_by(model.kernel(Kernel::factor, sparse_shape(n), solver("klu")),
                     truth(Kernel::factor, sparse_shape(n), solver("klu"))),
              0.12)
        << n;
  }
}

// A time that contradicts its neighbours is of something else; it is not taken as measured, but its error counts.
TEST(PerformanceModel, DoesNotBelieveASampleThatContradictsItsNeighbours) {
  for (const double times : {0.1, 20.0}) {
    for (const Kernel kernel : {Kernel::pack, Kernel::solve, Kernel::evaluate}) {
      std::vector<Sample> known = samples();
      const auto odd = std::find_if(known.begin(), known.end(), [&](const Sample& s) {
        return s.kernel == kernel && s.shape.n > 50 && s.strategy.solver.lanes == 8;
      });
      ASSERT_NE(odd, known.end());
      odd->seconds *= times;
      odd->backward_error = 1e-9;
      const PerformanceModel model(known);
      const Prediction predicted = model.kernel(kernel, odd->shape, odd->strategy);
      EXPECT_LT(off_by(predicted, truth(kernel, odd->shape, odd->strategy)), 0.15) << name(kernel) << " " << times;
      EXPECT_EQ(predicted.origin, Origin::interpolated) << name(kernel) << " " << times;
      if (kernel == Kernel::solve) {
        EXPECT_GT(model.backward_error(odd->shape, odd->strategy), 1e-10);
      }
    }
  }
}

TEST(PerformanceModel, TheOrderOfTheSamplesDoesNotMatter) {
  std::vector<Sample> known = samples();
  const PerformanceModel first(known);
  std::mt19937_64 random(5);
  for (int round = 0; round < 3; ++round) {
    std::shuffle(known.begin(), known.end(), random);
    const PerformanceModel other(known);
    for (const Shape& shape : unseen()) {
      for (const Strategy& s : {solver("lanes", 8), solver("klu"), solver("umfpack")}) {
        EXPECT_EQ(first.pack(shape, s).seconds, other.pack(shape, s).seconds);
        EXPECT_EQ(first.pack(shape, s).factor, other.pack(shape, s).factor);
      }
    }
  }
}

TEST(PerformanceModel, ReportsItsUncertainty) {
  const PerformanceModel model(samples());
  const Prediction near = model.kernel(Kernel::factor, sparse_shape(22), solver("klu"));
  const Prediction far = model.kernel(Kernel::factor, sparse_shape(20'000), solver("klu"));
  EXPECT_EQ(near.origin, Origin::interpolated);
  EXPECT_EQ(far.origin, Origin::extrapolated);
  EXPECT_LT(near.factor, 1.1);
  EXPECT_GT(far.factor, near.factor);
  // There are no samples of mumps: its prior is scaled to the speed of this machine.
  EXPECT_EQ(model.kernel(Kernel::factor, sparse_shape(22), solver("mumps")).origin, Origin::prior);
}

TEST(PerformanceModel, HasAPriorForEverythingWithoutSamples) {
  const PerformanceModel nothing;
  EXPECT_EQ(nothing.samples(), 0U);
  for (const Shape& shape : unseen()) {
    for (const Backend& backend : backends()) {
      const Prediction predicted = nothing.pack(shape, solver(std::string(backend.id)));
      EXPECT_GT(predicted.seconds, 0);
      EXPECT_EQ(predicted.origin, Origin::prior);
    }
  }
  EXPECT_GT(nothing.meeting(2).seconds, 0);
  EXPECT_EQ(nothing.meeting(1).seconds, 0);
  EXPECT_EQ(nothing.contention(2, 15), 1);
}

TEST(PerformanceModel, IgnoresImpossibleSamples) {
  std::vector<Sample> known = samples();
  const std::size_t good = known.size();
  const auto add = [&](const auto& change) {
    for (const Sample& of : {known[0], known[good - 1]}) {
      known.push_back(of);
      change(known.back());
    }
  };
  for (const double seconds : {0.0, -1.0, std::nan(""), HUGE_VAL, 5e-324, 9e-316, 9e-16, 1.1e9, 1e301, 1.7e308}) {
    add([&](Sample& s) { s.seconds = seconds; });
  }
  for (const double spread : {-1e-9, std::nan(""), HUGE_VAL, -HUGE_VAL, 1.7e308}) {
    add([&](Sample& s) { s.spread = spread; });
  }
  for (const double error : {-1e-16, -HUGE_VAL}) {
    add([&](Sample& s) { s.backward_error = error; });
    add([&](Sample& s) { s.forward_error = error; });
  }
  add([](Sample& s) { s.repetitions = -1; });
  for (std::int32_t Shape::*size : {&Shape::n, &Shape::nnz, &Shape::groups, &Shape::rhs}) {
    add([&](Sample& s) { s.shape.*size = -1; });
    add([&](Sample& s) { s.shape.*size = std::numeric_limits<std::int32_t>::min(); });
  }
  for (std::int64_t Shape::*size : {&Shape::fill, &Shape::operations, &Shape::depth, &Shape::terms}) {
    add([&](Sample& s) { s.shape.*size = -1; });
    add([&](Sample& s) { s.shape.*size = std::numeric_limits<std::int64_t>::max(); });
  }
  const PerformanceModel with(known), without({known.begin(), known.begin() + static_cast<std::ptrdiff_t>(good)});
  for (const Shape& shape : unseen()) {
    for (const Strategy& s : {known[0].strategy, known[good - 1].strategy, solver("klu")}) {
      for (const Kernel kernel : {Kernel::evaluate, Kernel::factor, Kernel::solve, Kernel::pack}) {
        const Prediction one = with.kernel(kernel, shape, s), other = without.kernel(kernel, shape, s);
        EXPECT_EQ(one.seconds, other.seconds) << name(kernel) << " " << to_string(s);
        EXPECT_EQ(one.factor, other.factor) << name(kernel) << " " << to_string(s);
      }
    }
  }
}

// The extremes of what is possible, in few samples.
TEST(PerformanceModel, PredictsFiniteTimesFromAnySamples) {
  std::mt19937_64 random(11);
  const auto any_of = [&](const auto& choices) {
    return choices[static_cast<std::size_t>(random() % std::size(choices))];
  };
  constexpr std::array kTimes = {1e-15, 1e-12, 1e-6, 1.0, 1e9};
  constexpr std::array kSpreads = {0.0, 1e-15, 1e-6, 1e9};
  constexpr std::array kErrors = {0.0, 1e-16, 1e300, HUGE_VAL, std::numeric_limits<double>::quiet_NaN()};
  constexpr std::array<std::int32_t, 6> kSizes = {0, 1, 3, 6, 1000, std::numeric_limits<std::int32_t>::max()};
  constexpr std::array<std::int64_t, 5> kCounts = {0, 1, 30, 100'000, 1'000'000'000'000'000};
  const std::array strategies = {solver("lanes", 8), solver("eigen"), solver("klu"), solver("lapack", 2)};
  const auto expect_time = [](const Prediction& p, const std::string& what) {
    EXPECT_TRUE(p.seconds >= 0 && std::isfinite(p.seconds)) << what << ": " << p.seconds;
    EXPECT_TRUE(p.factor >= 1 && std::isfinite(p.factor)) << what << ", factor: " << p.factor;
  };
  for (int trial = 0; trial < 2000 && !testing::Test::HasFailure(); ++trial) {
    std::vector<Sample> known;
    for (std::size_t i = 0; i < 1 + static_cast<std::size_t>(trial) % 12; ++i) {
      Sample s;
      s.kernel = static_cast<Kernel>(random() % 7);
      s.shape = {any_of(kSizes),  any_of(kSizes),  any_of(kSizes),  any_of(kSizes), any_of(kCounts),
                 any_of(kCounts), any_of(kCounts), any_of(kCounts), random() % 3};
      s.strategy = any_of(strategies);
      s.strategy.run.threads = 1 + static_cast<std::int32_t>(random() % 2);
      s.seconds = any_of(kTimes);
      s.spread = any_of(kSpreads);
      s.backward_error = any_of(kErrors);
      known.push_back(std::move(s));
    }
    const PerformanceModel model(known);
    for (const Shape& shape : {sparse_shape(1), sparse_shape(3), sparse_shape(200), known[0].shape}) {
      for (const Strategy& strategy : strategies) {
        for (const Kernel kernel : {Kernel::evaluate, Kernel::factor, Kernel::solve, Kernel::pack, Kernel::step}) {
          expect_time(model.kernel(kernel, shape, strategy), std::string(name(kernel)));
        }
        EXPECT_GE(model.backward_error(shape, strategy), 0);
      }
      expect_time(model.around(shape.n, shape.terms), "around");
    }
    expect_time(model.meeting(2, 100), "meeting");
    EXPECT_GE(model.contention(2, 6), 1);
  }
}

// Steps as one program are several times as fast. They say nothing about groups of the same size whose steps are
// composed.
TEST(PerformanceModel, KeepsPathsApart) {
  std::vector<Sample> known = samples(0);
  const Strategy lanes = parse_strategy("groups/lanes");
  Shape shape = sparse_shape(20);
  shape.pattern = 0;
  const double composed = PerformanceModel(known).pack(shape, lanes).seconds;
  std::mt19937_64 random(9);
  for (const std::int32_t n : {8, 12, 16, 24, 30}) {
    Sample s = sample_of(Kernel::pack, sparse_shape(n), lanes, 0, random);
    s.shape.one_program = true;
    s.shape.pattern += 1'000'000;
    s.seconds /= 4;
    known.push_back(std::move(s));
  }
  const PerformanceModel model(known);
  EXPECT_NEAR(model.pack(shape, lanes).seconds, composed, 0.01 * composed);
  shape.one_program = true;
  EXPECT_NEAR(model.pack(shape, lanes).seconds, composed / 4, 0.1 * composed);
  // Other policies of the backend have no such program.
  const Strategy once = parse_strategy("groups/lanes+once");
  EXPECT_EQ(path_of(shape, once), StepPath::composed);
}

TEST(PerformanceModel, MeetingsAndContentionComeFromThreads) {
  std::vector<Sample> known = samples(0);
  std::mt19937_64 random(4);
  for (const auto& [n, slower] : {std::pair{100, 1.2}, {400, 1.6}}) {
    for (const std::int32_t groups : {200, 400, 600}) {
      for (const std::int32_t p : {1, 2}) {
        Strategy s = solver("klu");
        s.run.threads = p;
        known.push_back(sample_of(Kernel::pack, sparse_shape(n, groups), s, 0, random));
        // During the measurement of 200 groups another program occupied a core. `slower` is the effect of a shared
        // cache.
        if (p == 2) known.back().seconds *= groups == 200 ? 1.9 : slower;
      }
    }
  }
  const PerformanceModel model(known);
  EXPECT_NEAR(model.meeting(2).seconds, 0.8e-6, 1e-12);
  EXPECT_NEAR(model.meeting(4).seconds, 1.6e-6, 1e-12);
  EXPECT_NEAR(model.meeting(8).seconds, 3.2e-6, 1e-12);
  EXPECT_NEAR(model.contention(2, 50), 1.2, 1e-12);
  EXPECT_NEAR(model.contention(2, 100), 1.2, 1e-12);
  EXPECT_NEAR(model.contention(2, 200), 1.4, 1e-12);
  EXPECT_NEAR(model.contention(2, 1000), 1.6, 1e-12);
  EXPECT_NEAR(model.contention(4, 100), 1.2, 1e-12);
}

// The measured times of whole steps, beyond their packs, count more than the speed of other kernels.
TEST(PerformanceModel, LearnsTheTimeAroundPacksFromSteps) {
  std::vector<Sample> known = samples();
  const double before = PerformanceModel(known).around(500, 3000).seconds;
  EXPECT_EQ(PerformanceModel(known).around(500, 3000).origin, Origin::prior);
  std::mt19937_64 random(6);
  for (const auto& [unknowns, pieces] : {std::pair{4, 40}, {102, 1500}, {700, 9000}}) {
    for (const char* strategy : {"groups/lanes", "groups/eigen"}) {
      Sample s = sample_of(Kernel::factor, sparse_shape(20), parse_strategy(strategy), 0, random);
      s.kernel = Kernel::around;
      s.shape = {.n = unknowns, .terms = pieces};
      s.seconds = 3 * prior_around_seconds(unknowns, pieces);
      known.push_back(s);
    }
  }
  const PerformanceModel model(known);
  EXPECT_NEAR(model.around(102, 1500).seconds / prior_around_seconds(102, 1500), 3, 1e-6);
  EXPECT_NEAR(model.around(500, 3000).seconds / prior_around_seconds(500, 3000), 3, 1e-6);
  EXPECT_NE(model.around(500, 3000).seconds, before);
  EXPECT_EQ(model.around(102, 1500).origin, Origin::interpolated);
  EXPECT_EQ(model.around(100'000, 1'000'000).origin, Origin::extrapolated);
  EXPECT_EQ(model.kernel(Kernel::around, {.n = 102, .terms = 1500}, {}).seconds, model.around(102, 1500).seconds);
}

TEST(Kernels, NamesRoundTrip) {
  for (const Kernel kernel :
       {Kernel::evaluate, Kernel::factor, Kernel::solve, Kernel::pack, Kernel::meeting, Kernel::step, Kernel::around}) {
    EXPECT_EQ(parse_kernel(name(kernel)), kernel);
  }
  EXPECT_THROW((void)parse_kernel("Factor"), Error);
}

}  // namespace
}  // namespace assur
