// The common part of the benchmark programs: their default settings, and the function that times a step of the library.
#pragma once

#include <benchmark/benchmark.h>

#include <string>

#include "assur/scene.hpp"

namespace assur::bench {

// Describes the machine and runs the benchmarks that `register_all` registers. Defaults: repetitions of 0.05 s,
// interleaved at random, and aggregates only. --simd=AVX2 disables wider instructions. Returns the exit status.
int run_program(int argc, char** argv, void (*register_all)(), int repetitions = 5);

// False if the strategy cannot run here, or if no class has enough groups for its lanes: a strategy with fewer lanes is
// then the same.
[[nodiscard]] bool worth_timing(const Scene& scene, const std::string& strategy);

// Times the steps of `scene` one after the other; its counters are the work and the errors of the timed steps.
void time_steps(benchmark::State& state, const Scene& scene, const std::string& strategy);

}  // namespace assur::bench
