// Time of a step of mechanisms that are written with joints and by hand (tests/joints/by_hand.hpp).
#include <benchmark/benchmark.h>

#include <string>

#include "assur/assur.hpp"
#include "joints/by_hand.hpp"
#include "program.hpp"

namespace assur::bench {
namespace {

void register_all() {
  for (const auto& mechanisms : {test::plane_mechanisms_by_hand(), test::space_mechanisms_by_hand()}) {
    for (const test::WrittenTwice& m : mechanisms) {
      benchmark::RegisterBenchmark((m.name + " with joints").c_str(), time_steps, m.joints, "auto");
      benchmark::RegisterBenchmark((m.name + " by hand").c_str(), time_steps, m.by_hand, "auto");
    }
  }
}

}  // namespace
}  // namespace assur::bench

int main(int argc, char** argv) { return assur::bench::run_program(argc, argv, assur::bench::register_all); }
