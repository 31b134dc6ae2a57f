// A clock that only the test advances, and work with given times.
#pragma once

#include <vector>

#include "measure/race.hpp"

namespace assur::measure {

struct Laboratory {
  double now = 1000;
  std::int64_t switches = 0;
  bool stopped = false;
  double slow = 1;        // all work takes this many times as long as usual
  double unevenness = 1;  // ratio of times on two cores

  [[nodiscard]] Instruments instruments() {
    Instruments out;
    out.clock = [this] { return now; };
    out.switches = [this](int) { return switches; };
    out.stop = [this] { return stopped; };
    out.slowness = [this] { return slow; };
    out.unevenness = [this] { return unevenness; };
    return out;
  }
};

// A call takes `seconds` of the laboratory's clock at the usual pace. Records every block.
class Timed : public Workload {
 public:
  Timed(Laboratory& laboratory, double seconds) : laboratory_(laboratory), seconds_(seconds) {}

  bool run(int calls) override {
    laboratory_.now += seconds_ * calls * laboratory_.slow;
    blocks.push_back(calls);
    ends.push_back(laboratory_.now);
    return true;
  }

  std::vector<int> blocks;   // calls of each block
  std::vector<double> ends;  // s, the end of each block

 private:
  Laboratory& laboratory_;
  double seconds_;
};

}  // namespace assur::measure
