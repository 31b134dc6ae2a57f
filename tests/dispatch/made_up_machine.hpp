// An artificial machine with known times. Its cost functions differ from those of the model; samples of them have
// noise.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "assur/performance.hpp"
#include "dispatch/prior.hpp"

namespace assur::made_up {

// A matrix like those of mechanisms: three nonzeros in each row, little fill.
inline Shape sparse_shape(std::int32_t n, std::int32_t groups = 1) {
  Shape s{.n = n, .nnz = 3 * n, .groups = groups, .rhs = 3};
  s.fill = 4 * std::int64_t{n};
  s.operations = 9 * std::int64_t{n};
  s.terms = 8 * std::int64_t{n};
  s.pattern = static_cast<std::uint64_t>(n) * 2 + 1;
  s.one_program = n <= 3;
  return s;
}

inline Shape full_shape(std::int32_t n, std::int32_t groups = 1) {
  Shape s = sparse_shape(n, groups);
  s.nnz = n * n;
  s.fill = std::int64_t{n} * n;
  s.operations = std::int64_t{n} * n * n / 3;
  ++s.pattern;
  return s;
}

// Seconds of one call. The times bend at the size of the cache, so that no sum of terms is exact.
inline double truth(Kernel kernel, const Shape& shape, const Strategy& s) {
  const double n = shape.n, fill = static_cast<double>(shape.fill), operations = static_cast<double>(shape.operations);
  const double lanes = s.solver.lanes, held = is_dense(s) ? n * n : fill;
  const double bend = 1 + 0.4 / (1 + std::exp(-(std::log(held) - std::log(3000.0))));
  switch (kernel) {
    case Kernel::evaluate:
      return 20e-9 + 0.9e-9 * static_cast<double>(shape.terms) * std::max(1.0, lanes / 8);
    case Kernel::factor:
      if (s.solver.backend == "lanes") return (25e-9 + 0.9e-9 * operations * bend) * std::max(1.0, lanes / 8);
      if (is_dense(s))
        return lanes * (120e-9 + 20e-9 * n + 0.4e-9 * n * n + 0.03e-9 * n * n * n * bend) / s.solver.threads;
      return lanes * (250e-9 + 30e-9 * n + 6e-9 * fill * bend + 2e-9 * operations);
    case Kernel::solve:
      if (s.solver.backend == "lanes") return (15e-9 + 0.7e-9 * fill * bend) * std::max(1.0, lanes / 8);
      if (is_dense(s)) return lanes * (60e-9 + 5e-9 * n + 0.5e-9 * n * n);
      return lanes * (90e-9 + 10e-9 * n + 2e-9 * fill * bend);
    case Kernel::pack: {
      const StepCounts counts = step_counts(s, shape.rhs - 1);
      return 130e-9 + 4e-9 * n * std::max(1.0, lanes / 8) + counts.evaluations * truth(Kernel::evaluate, shape, s) +
             counts.factorizations * truth(Kernel::factor, shape, s) +
             counts.solutions * truth(Kernel::solve, shape, s);
    }
    case Kernel::meeting:
      return s.run.threads < 2 ? 0 : kAloneBeforeMeeting + 0.4e-6 * s.run.threads;
    case Kernel::step:
      return 300e-9 + std::ceil(std::ceil(shape.groups / lanes) / s.run.threads) * truth(Kernel::pack, shape, s) +
             std::max(0.0, truth(Kernel::meeting, shape, s) - kAloneBeforeMeeting);
    case Kernel::around:
      return 300e-9;
  }
  return 0;
}

inline Strategy solver(const std::string& backend, std::int32_t lanes = 1, std::int32_t q = 1) {
  Strategy s;
  s.solver.backend = backend;
  s.solver.lanes = lanes;
  s.solver.threads = q;
  return s;
}

// `noise` is relative and uniformly distributed.
inline Sample sample_of(Kernel kernel, const Shape& shape, const Strategy& strategy, double noise,
                        std::mt19937_64& random) {
  Sample sample;
  sample.kernel = kernel;
  sample.shape = shape;
  sample.strategy = strategy;
  const double off = std::uniform_real_distribution<double>(-noise, noise)(random);
  sample.seconds = truth(kernel, shape, strategy) * (1 + off);
  sample.spread = sample.seconds * noise / 2;
  sample.repetitions = 100;
  sample.backward_error = 1e-16;
  sample.forward_error = 1e-15;
  const std::string number = std::to_string(random());
  sample.uid = std::string(32 - number.size(), '0') + number;
  return sample;
}

// Samples like those of a tuning run, with sizes in ratios of 1.7.
inline std::vector<Sample> samples(double noise = 0.01, std::uint64_t seed = 1) {
  std::mt19937_64 random(seed);
  std::vector<Sample> all;
  for (double size = 4; size < 1500; size *= 1.7) {
    const auto n = static_cast<std::int32_t>(size);
    for (const bool full : {false, true}) {
      if (full && n > 300) continue;
      const Shape shape = full ? full_shape(n) : sparse_shape(n);
      Shape matrix = shape;
      matrix.terms = 0;
      const auto both = [&](const Strategy& s) {
        all.push_back(sample_of(Kernel::factor, matrix, s, noise, random));
        all.push_back(sample_of(Kernel::solve, matrix, s, noise, random));
      };
      for (const std::int32_t lanes : {1, 2, 4, 8, 16}) {
        both(solver("lanes", lanes));
        all.push_back(sample_of(Kernel::evaluate, shape, solver("lanes", lanes), noise, random));
        if (!full) all.push_back(sample_of(Kernel::pack, shape, solver("lanes", lanes), noise, random));
      }
      both(solver("klu"));
      if (n <= 500) both(solver("eigen"));
    }
  }
  for (const std::int32_t p : {2, 4}) {
    Strategy threads = solver("lanes");
    threads.run.threads = p;
    all.push_back(sample_of(Kernel::meeting, {}, threads, noise, random));
  }
  return all;
}

}  // namespace assur::made_up
