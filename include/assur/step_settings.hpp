// Settings of the steps of a simulator: iterations, time, processors.
#pragma once

#include <functional>
#include <vector>

namespace assur {

// How steps are made, e.g. in a control loop.
struct StepSettings {
  // Exactly this many Newton iterations for each group that depends on other groups and each part of a divided step,
  // without a test of convergence: the estimated error shows whether they were enough. Groups that depend on no other
  // group iterate until they converge. 0: all groups do.
  int iterations = 0;
  int most_iterations = 12;  // a step is halved if a group needs more; at least 1; for groups whose number is not fixed
  // s, time limit of a call of step(), also within run(), which then uses no chunks: Code::deadline; 0: none. All work
  // of the call shares it: both tries, the choice of other redundant equations, the search for the time of a limit, and
  // the estimates of errors. Checked before each pack; where one call solves all groups (+together, and machine code
  // for the whole step of a small mechanism), before it.
  double seconds = 0;
  // Processors to pin threads to (Machine::cores), one for each of the P threads (RunSettings::threads); without effect
  // if P = 1. The calling thread is pinned during a call only. Pinned threads busy-wait within a step, so use dedicated
  // cores; between steps they sleep. Empty: the system places the threads. The constructor throws Error: input for
  // fewer processors than threads, environment for a processor that cannot be used.
  std::vector<int> pin_to = {};
  // Called between the parts of a divided step (millions for a very fast law), on the thread that does the step. In an
  // Ensemble, or with chunks, several threads may call copies of it at once, and each call ends its own member only. If
  // it returns true, the call ends with Code::interrupted. Empty: not called.
  std::function<bool()> stop = {};
};

}  // namespace assur
