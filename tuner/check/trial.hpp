// A mechanism is run and held against its plain motion: the verdict.
#pragma once

#include <optional>
#include <string>

#include "check/random_mechanism.hpp"

namespace assur::check {

struct Trial {
  enum class Verdict {
    agrees,           // every row that came with a clean status is right
    doubted,          // rows are right, or the status said that they may not be
    stopped_rightly,  // where the motion ends or is singular, by the plain equations as well
    undecided,        // the plain motion cannot tell: at a singularity, or lost before the run was
    not_assembled,    // a rough guess, and no posture was found
    refused,          // stopped, or not started, where the motion goes on
    wrong_start,      // the first row does not meet the scene's equations or laws
    wrong,            // a row with a clean status is off
  };
  Verdict verdict = Verdict::undecided;
  std::string what;                // in words
  std::optional<double> error[3];  // true ones, as docs/accuracy.md has them
  std::optional<double> estimated[3];
  double condition = 0;  // of the plain equations, the worst of the rows
  double time = 0;       // where it went wrong
  int rows = 0;          // compared

  [[nodiscard]] bool is_fault() const { return verdict >= Verdict::refused; }
};

[[nodiscard]] const char* name(Trial::Verdict verdict);

// care: how many times as short the steps of the plain motion are; what looks wrong is looked at again with more of it.
[[nodiscard]] Trial try_out(const RandomMechanism& mechanism, int care = 1);

}  // namespace assur::check
