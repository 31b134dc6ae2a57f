// Growth of time and memory of one group from 100 groups to 100,000, stage by stage: reading, building, analysing and
// stepping a scene. The time of analysing one group may grow by a factor of 3; the exit status is 1 if it grows by
// more. Times are processor time of one thread, so that a busy machine disturbs them little.
//
//   structure_scaling_bench [ROUNDS [LARGEST]]    5 rounds up to 100000 groups unless told otherwise
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "assur/assur.hpp"
#include "heap.hpp"
#include "machine.hpp"
#include "median.hpp"

namespace assur::bench {
namespace {

constexpr double kMostGrowth = 3;
constexpr int kSteps = 5;            // timed, after the same number of untimed steps
constexpr int kSamplesOfSmall = 20;  // repetitions of small sizes in a round

// The chain of crank-rockers as a scene file; the sample `four_bar` builds the same scene.
std::string four_bar_file(int loops) {
  const Scene scene = sample("four_bar:" + std::to_string(loops));
  std::ostringstream out;
  out.precision(17);
  out << R"({"assur": 1, "name": "four_bar", "dimension": 2, "points": {)";
  const char* separator = "";
  for (const Point& p : scene.points()) {
    out << separator << '"' << p.name << R"(": {"at": [)" << p.at[0] << ", " << p.at[1] << ']'
        << (p.fixed ? R"(, "fixed": true})" : "}");
    separator = ",\n";
  }
  out << R"(}, "constraints": {)";
  separator = "";
  for (const Constraint& c : scene.constraints()) {
    const auto& d = *c.as<Distance>();
    out << separator << '"' << c.name << R"(": {"distance": [")" << d.p << R"(", ")" << d.q << R"("], "value": )"
        << d.value.value() << '}';
    separator = ",\n";
  }
  out << R"(}, "drivers": {"motor": {"angle": ["A0", "B0"], "law": {"polynomial": [0, "=2*pi"]}}},)"
      << R"("measures": {"rocker_angle": {"angle": ["A)" << loops << R"(", "B)" << loops << R"("]}},)"
      << R"("time": {"start": 0, "end": 1, "step": 0.001}})";
  return out.str();
}

struct Figures {
  std::vector<double> seconds;
  double peak = 0, retained = 0;  // bytes
};

// Measures the time of `make` and the memory of its result, whose destruction is not timed.
template <class Make>
void measure(Figures& figures, const Make& make) {
  forget_peak();
  const Heap before = heap();
  const double start = processor_seconds();
  const auto made = make();
  figures.seconds.push_back(processor_seconds() - start);
  const Heap after = heap();
  benchmark::DoNotOptimize(&made);
  figures.peak = static_cast<double>(after.peak - before.live);
  figures.retained = static_cast<double>(after.live - before.live);
}

StructureOptions options_for(Formulation formulation) {
  StructureOptions options;
  options.formulation = formulation;
  options.predictor_derivatives = 2;
  return options;
}

// One size of a family of scenes, with its measurements.
struct Size {
  std::string text;  // the sample
  std::string file;  // the same as a file; "": no file is read
  std::string strategy = "groups/eigen";
  double groups = 0;  // as declared
  Figures read, build, as_groups, irreducible, step;

  explicit Size(std::string sample_text, std::string scene_file = "")
      : text(std::move(sample_text)), file(std::move(scene_file)) {}

  void measure_once() {
    if (!file.empty()) measure(read, [&] { return parse_scene(file); });
    measure(build, [&] { return sample(text); });
    const Scene scene = sample(text);
    measure(as_groups, [&] {
      Structure s = analyze(scene, options_for(Formulation::groups));
      groups = static_cast<double>(s.groups().size());
      return s;
    });
    measure(irreducible, [&] { return analyze(scene, options_for(Formulation::irreducible)); });
  }

  void measure_steps() {
    const Scene scene = sample(text);
    forget_peak();
    const Heap before = heap();
    Simulator simulator(prepare(scene, {strategy + "+predict=hermite:5", {}}));
    step.retained = static_cast<double>(heap().live - before.live);
    step.peak = static_cast<double>(heap().peak - before.live);
    for (int k = 1; k <= 2 * kSteps; ++k) {
      const double start = processor_seconds();
      const Status status = simulator.step(scene.time().time(k));
      const double seconds = processor_seconds() - start;
      if (!status.arrived()) throw Error(Error::Kind::numerical, text + ": " + std::string(name(status.code)));
      if (k > kSteps) step.seconds.push_back(seconds);
    }
  }
};

// Prints a line for each size; returns the largest growth of time or memory per group.
double print(const char* stage, const std::vector<Size>& sizes, Figures Size::*figures) {
  double worst = 1;
  std::printf("%s\n  %-24s %8s %13s %6s %13s %6s %13s %6s\n", stage, "scene", "groups", "us/group", "x", "peak B/group",
              "x", "kept B/group", "x");
  const auto per_group = [&](const Size& size, double value) { return value / size.groups; };
  const Size& first = sizes.front();
  for (const Size& size : sizes) {
    std::printf("  %-24s %8.0f", size.text.c_str(), size.groups);
    const auto column = [&](const char* format, auto value) {
      const double figure = per_group(size, value(size.*figures)), least = per_group(first, value(first.*figures));
      worst = std::max(worst, figure / least);
      std::printf(format, figure);
      std::printf(" %6.2f", figure / least);
    };
    column(" %13.3f", [](const Figures& f) { return 1e6 * median(f.seconds); });
    column(" %13.0f", [](const Figures& f) { return f.peak; });
    column(" %13.0f", [](const Figures& f) { return f.retained; });
    std::printf("\n");
  }
  return worst;
}

// Sizes are interleaved: each round measures all of them.
void measure_all(std::vector<Size>& sizes, int rounds) {
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t i = 0; i < sizes.size(); ++i) {
      const bool small = i < 2 && sizes.size() > 2;
      for (int k = 0; k < (small ? kSamplesOfSmall : 1); ++k) sizes[i].measure_once();
      sizes[i].measure_steps();
    }
  }
}

int run(int rounds, int largest) {
  describe_machine(std::cout);
  std::vector<Size> chains, platforms, legs;
  for (const int loops : {100, 1000, 10000, 100000}) {
    if (loops <= largest) chains.emplace_back("four_bar:" + std::to_string(loops), four_bar_file(loops));
  }
  for (const int count : {15, 150, 1500, 10000}) {  // of 7 groups each
    if (7 * count <= 1.1 * largest) platforms.emplace_back("stewart:platforms=" + std::to_string(count));
  }
  for (const int count : {8, 64, 512, 4096}) {
    if (6 * count > largest) continue;
    Size& size = legs.emplace_back("stewart:platforms=" + std::to_string(count));
    size.strategy = "groups/lanes:8";
    size.groups = 6.0 * count;
  }
  measure_all(chains, rounds);
  measure_all(platforms, rounds);

  std::printf("medians of %d rounds; x: times the smallest\n", rounds);
  print("\nread a file and validate it", chains, &Size::read);
  double worst = 1;
  for (auto* sizes : {&chains, &platforms}) {
    print("\nbuild the scene and validate it", *sizes, &Size::build);
    worst = std::max(worst, print("\nanalyze as groups", *sizes, &Size::as_groups));
    worst = std::max(worst, print("\nanalyze as irreducible", *sizes, &Size::irreducible));
    print("\nstep, groups/eigen+predict=hermite:5 (memory: the prepared simulator)", *sizes, &Size::step);
  }
  for (int round = 0; round < rounds; ++round) {
    for (Size& size : legs) size.measure_steps();
  }
  print("\nstep of a leg, groups/lanes:8+predict=hermite:5 (memory: the prepared simulator)", legs, &Size::step);
  const bool kept = worst <= kMostGrowth;
  std::printf("\nlargest growth of analysing: %.2f (%s %g)\n", worst, kept ? "at most" : "MORE than", kMostGrowth);
  return kept ? 0 : 1;
}

}  // namespace
}  // namespace assur::bench

int main(int argc, char** argv) {
  try {
    return assur::bench::run(argc > 1 ? std::stoi(argv[1]) : 5, argc > 2 ? std::stoi(argv[2]) : 100000);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
