// What the benchmark programs share: honest defaults, and the one way to time a step of the library.
#pragma once

#include <benchmark/benchmark.h>

#include <string>

#include "assur/scene.hpp"

namespace assur::bench {

// Describes the machine and runs what `register_all` registers. Unless the command line says otherwise: interleaved at
// random, repetitions of 0.05 s, aggregates only. --simd=AVX2 or SSE4 leaves better instructions unused. Returns the
// exit status.
int run_program(int argc, char** argv, void (*register_all)(), int repetitions = 5);

// False if the strategy cannot run here, or if no class has groups for its lanes: fewer lanes are then the same.
[[nodiscard]] bool worth_timing(const Scene& scene, const std::string& strategy);

// Times one step of `scene` after another; work and errors of those very steps are its counters.
void time_steps(benchmark::State& state, const Scene& scene, const std::string& strategy);

}  // namespace assur::bench
