// What the programs of the comparison have in common: they follow the times of a reference, and say how long a step
// took and how far the results are off.
#pragma once

#include <memory>
#include <string>
#include <vector>

namespace peers {

// Of the points B1, B2, ... of a mechanism at one time: x, y(, z) of each.
struct Row {
  double t = 0;
  std::vector<double> position, velocity, acceleration;
};

class Peer {
 public:
  virtual ~Peer() = default;
  // Goes on to time t and puts what it computes into `row`, whose vectors have their sizes. Timed.
  virtual void step(double t, Row& row) = 0;
};

struct Peers {
  const char* name;     // "simbody 3.7"
  int levels;           // 1: position; 2: and velocity; 3: and acceleration
  const char* comment;  // how it was asked
  // `start`: the first row, from which the motion begins.
  std::unique_ptr<Peer> (*make)(const std::string& mechanism, int loops, const Row& start);
};

// PROGRAM MECHANISM REFERENCE [header]: one run over the reference, one line of CSV:
//   peer,mechanism,levels,steps,seconds_per_step,position_error,velocity_error,acceleration_error,comment
// Times are those of the processor, all threads together. Errors are max over the steps |x - x_ref| / max over the run
// |x_ref|; empty for what is not computed.
int run(int argc, char** argv, const Peers& peers);

}  // namespace peers
