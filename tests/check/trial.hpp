// Runs a random mechanism and compares it with its plain motion.
#pragma once

#include <optional>
#include <string>

#include "mechanisms/random_mechanism.hpp"

namespace assur::check {

struct Trial {
  enum class Verdict {
    agrees,           // every row with a clean status is right
    doubted,          // every row is right, or its status warns of errors
    stopped_rightly,  // stopped where the plain motion ends or is singular, too
    undecided,        // the plain motion does not decide: at a singularity, or lost before the run ended
    not_assembled,    // no posture was found from a rough guess
    refused,          // stopped, or not started, although the motion goes on
    wrong_start,      // the first row violates the equations or laws of the scene
    wrong,            // a row with a clean status is wrong
  };
  Verdict verdict = Verdict::undecided;
  std::string what;                // in words
  std::optional<double> error[3];  // true errors, as defined in docs/accuracy.md
  std::optional<double> estimated[3];
  double condition = 0;  // largest condition of the plain equations in a row
  double time = 0;       // time of the fault, s
  int rows = 0;          // compared

  [[nodiscard]] bool is_fault() const { return verdict >= Verdict::refused; }
};

[[nodiscard]] const char* name(Trial::Verdict verdict);

// Runs the comparison. care: steps of the plain motion are this many times as short; apparent faults are tested again
// with more care.
[[nodiscard]] Trial try_out(const mechanisms::RandomMechanism& mechanism, int care = 1);

}  // namespace assur::check
