// Time of one step with velocity and acceleration: scene x formulation x solver x predictor, with and without +once,
// and the errors of the timed steps. Combinations that cannot run here are left out.
#include <benchmark/benchmark.h>

#include <string>
#include <vector>

#include "assur/assur.hpp"
#include "program.hpp"

namespace assur::bench {
namespace {

using Texts = std::vector<std::string>;

// All combinations of these are run.
struct Family {
  Texts scenes, formulations, solvers, policies, predictors;
};

const Texts kScenes = {"stewart", "four_bar:1", "four_bar:10", "four_bar:100", "andrews", "rings:legs=6,n=120"};
const Texts kRings = {"rings:legs=8,n=30", "rings:legs=64,n=30", "rings:legs=16,n=120", "rings:legs=8,n=360",
                      "rings:legs=8,n=720"};

// Fewer steps of large groups, because they take long: about seven minutes in all.
const Family kFamilies[] = {
    {kScenes,
     {"global", "groups", "irreducible"},
     {"eigen", "klu"},
     {"", "+once"},
     {"hermite:5", "past:5", "taylor:2"}},
    {kScenes,
     {"groups", "irreducible"},
     {"lapack", "lanes", "lanes:8", "lanes:8+float", "lanes:16+float", "eigen+float", "lapack+float"},
     {"", "+once"},
     {"hermite:5"}},
    {{"stewart"},
     {"groups", "irreducible"},
     {"klu", "lanes:8"},
     {"+refine", "+reuse=step", "+reuse=run"},
     {"hermite:5"}},
    {{"stewart", "four_bar:10"}, {"groups"}, {"umfpack", "mumps", "team"}, {""}, {"hermite:5"}},
    {kRings, {"groups"}, {"klu", "lanes:8", "lanes:16", "lanes:8+float"}, {"", "+once"}, {"hermite:5"}},
};

void register_family(const Family& family) {
  for (const std::string& text : family.scenes) {
    const Scene scene = sample(text);
    for (const std::string& formulation : family.formulations) {
      for (const std::string& solver : family.solvers) {
        for (const std::string& policy : family.policies) {
          for (const std::string& predictor : family.predictors) {
            const std::string strategy = formulation + "/" + solver + policy + "+predict=" + predictor;
            if (!worth_timing(scene, strategy)) continue;
            benchmark::RegisterBenchmark((text + " " + strategy).c_str(), time_steps, scene, strategy);
          }
        }
      }
    }
  }
}

void register_all() {
  for (const Family& family : kFamilies) register_family(family);
}

}  // namespace
}  // namespace assur::bench

int main(int argc, char** argv) { return assur::bench::run_program(argc, argv, assur::bench::register_all); }
