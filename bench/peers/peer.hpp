// The common part of the programs of the comparison: they follow the times of a reference, and report the time of a
// step and the errors of the results.
#pragma once

#include <memory>
#include <string>
#include <vector>

namespace peers {

// Results at one time: x, y(, z) of each of the points B1, B2, ... of a mechanism.
struct Row {
  double t = 0;
  std::vector<double> position, velocity, acceleration;
};

class Peer {
 public:
  virtual ~Peer() = default;
  // Moves to time t and writes the results into `row`, whose vectors have the right sizes. This call is timed.
  virtual void step(double t, Row& row) = 0;
};

struct PeerInfo {
  const char* name;     // "simbody 3.7"
  int levels;           // 1: position; 2: and velocity; 3: and acceleration
  const char* comment;  // settings of the peer
  // `start`: the first row, from which the motion begins.
  std::unique_ptr<Peer> (*make)(const std::string& mechanism, int loops, const Row& start);
};

// PROGRAM MECHANISM REFERENCE [header]: one run over the reference, one line of CSV:
//   peer,mechanism,levels,steps,seconds_per_step,position_error,velocity_error,acceleration_error,comment
// Times are processor times of all threads together. Errors are the maximum of |x - x_ref| over the steps, divided by
// the maximum of |x_ref|; empty for quantities that are not computed.
int run(int argc, char** argv, const PeerInfo& info);

}  // namespace peers
