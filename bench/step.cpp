// Time of one step with velocity and acceleration: scene x formulation x solver x predictor, with and without +once;
// the errors of the very steps that were timed beside it. Candidates are interleaved at random.
#include <benchmark/benchmark.h>

#include <string>
#include <vector>

#include "assur/assur.hpp"
#include "program.hpp"

namespace assur::bench {
namespace {

void register_all() {
  for (const std::string text :
       {"stewart", "four_bar:1", "four_bar:10", "four_bar:100", "andrews", "rings:legs=6,n=120"}) {
    const Scene scene = sample(text);
    for (const std::string formulation : {"global", "groups", "irreducible"}) {
      for (const std::string solver : {"eigen", "klu"}) {
        for (const std::string once : {"", "+once"}) {
          for (const std::string predictor : {"hermite:5", "past:5", "taylor:2"}) {
            const std::string strategy = formulation + "/" + solver + once + "+predict=" + predictor;
            if (!why_not(strategy).empty()) continue;
            benchmark::RegisterBenchmark((text + " " + strategy).c_str(), time_steps, scene, strategy);
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace assur::bench

int main(int argc, char** argv) { return assur::bench::run_program(argc, argv, assur::bench::register_all); }
