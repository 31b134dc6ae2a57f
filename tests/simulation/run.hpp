// Helpers of the tests of the simulation: a run, and the difference of two runs.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "assur/simulator.hpp"
#include "numbers.hpp"

namespace assur {

// For messages of failed tests.
inline void PrintTo(Code code, std::ostream* out) { *out << name(code); }

}  // namespace assur

namespace assur::test {

inline Simulator simulator(const Scene& scene, const std::string& strategy = "auto", StepSettings settings = {},
                           std::vector<std::string> controlled = {}) {
  return Simulator(prepare(scene, {strategy, std::move(controlled)}), settings);
}

// The solvers of this build: dense, and sparse if available.
inline std::vector<std::string> solvers() {
  if (find_backend(backends(), "klu").why_not({}, {}).empty()) return {"eigen", "klu"};
  return {"eigen"};
}
inline std::string sparse() { return solvers().back(); }

struct Result {
  Simulator simulator;
  Trajectory trajectory;

  [[nodiscard]] const Report& report() const { return simulator.report(); }
  [[nodiscard]] const Counters& counters() const { return report().counters; }
};

// The plan for scene i of a search: one group at a time, all equations at once, or, if its groups allow it, all levels
// together.
inline Prepared prepare_in_turn(const Scene& scene, int i) {
  if (i % 3 == 1) return prepare(scene, {.strategy = "global/eigen+once"});
  if (i % 3 == 2) {
    try {
      return prepare(scene, {.strategy = "irreducible/lanes:4+together"});
    } catch (const Error& e) {
      if (e.kind() != Error::Kind::environment) throw;
    }
  }
  return prepare(scene, {.strategy = "irreducible/eigen"});
}

// The events of the motion, without those about its accuracy and about postures that it passes closely.
[[nodiscard]] inline std::vector<Event> events(const Report& report) {
  std::vector<Event> all = report.events;
  std::erase_if(all, [](const Event& e) { return e.kind == Code::inaccurate || e.kind == Code::near_singular; });
  return all;
}

inline Result run(const Scene& scene, const std::string& strategy = "auto", StepSettings settings = {}) {
  Simulator s = simulator(scene, strategy, settings);
  Trajectory t = s.run();
  return {std::move(s), std::move(t)};
}

// "x", "v" or "a" for components of points and vectors; every other column is its own kind.
inline std::string kind_of(const std::string& column) {
  const std::string last = column.substr(column.rfind('.') + 1);
  return last == "x" || last == "y" || last == "z" ? "x" : last.size() == 2 ? last.substr(0, 1) : column;
}

// The largest difference of two runs in the columns of the first one. Each difference is divided by the largest value
// of all columns of its kind, because a coordinate near zero is as uncertain as its neighbours.
inline double difference(const Trajectory& a, const Trajectory& b) {
  if (a.rows() != b.rows() || a.rows() == 0) return std::numeric_limits<double>::infinity();
  struct Kind {
    double off = 0, largest = 0;
  };
  std::map<std::string, Kind> kinds;
  for (std::size_t c = 0; c < a.columns().size(); ++c) {
    const std::size_t other = b.index(a.columns()[c]);
    Kind& kind = kinds[kind_of(a.columns()[c])];
    for (std::size_t k = 0; k < a.rows(); ++k) {
      const double d = std::abs(a(k, c) - b(k, other));
      if (!(d <= kind.off)) kind.off = d;
      kind.largest = std::max(kind.largest, std::abs(a(k, c)));
    }
  }
  double worst = 0;
  for (const auto& [name, kind] : kinds) {
    const double relative = kind.largest > 0 ? kind.off / kind.largest : kind.off;
    if (!(relative <= worst)) worst = relative;
  }
  return worst;
}

}  // namespace assur::test
