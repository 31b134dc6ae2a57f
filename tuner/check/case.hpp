// The cases of the stability suite: what is run, and the verdict that theory gives, fixed in a file before any run.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "assur/plan.hpp"
#include "assur/scene.hpp"
#include "assur/strategy.hpp"

namespace assur::check {

// "pass": a clean status, no event, and a forward error within the accuracy asked for; "refused": an Error of kind
// input or numerical; else the name of a Code. What no case may expect: "wrong" (a clean status or an event, and rows
// before it that are further off than asked), "other_bits", "no_yardstick", "differs".
using Verdict = std::string;

struct Expected {
  std::vector<Verdict> verdicts;  // more than one where theory leaves them open; empty: the same from all strategies
  std::string message;            // part of that of a refusal
};

// "pass", "inaccurate or limit_reached", "refused"
[[nodiscard]] std::string to_string(const Expected& expected);

struct Case {
  std::string family, name, about;
  // One of these: a sample's text or a file, a scene in the scene format, a maker's name (makers.hpp), a matrix's
  // (matrices.hpp).
  std::string text, scene, maker, matrix;
  Parameters set;                             // of the scene, the maker or the matrix
  std::vector<std::filesystem::path> tables;  // folders beside the scene's own
  std::optional<TimeGrid> time;
  std::vector<std::string> outputs;
  double accuracy = 0;                    // asked for; 0: none, and kDoubtfulError is the limit
  int iterations = 0;                     // StepLimits::iterations
  std::vector<Formulation> formulations;  // empty: all
  std::vector<std::string> strategies;    // empty: every one that can run it
  std::string closed_form;                // closed_forms.hpp; empty: the maker's, else the reference in quad
  bool plain = false;                     // measured against plain equations of its own, laws and turns of angles too
  Parameters twin;                        // set instead, it has the same bits up to powers of two; empty: no twin
  std::string singularity = "regular";    // or "fold", "change_point", "redundant", ...: what the posture comes near
  Expected expected;
  std::string because;  // why more than one verdict is right
  bool quick = false;   // part of --quick

  // Forward error from which on a result is wrong.
  [[nodiscard]] double limit() const { return accuracy > 0 ? accuracy : kDoubtfulError; }
};

// The cases of one file, each value of a sweep a case of its own ("NAME PARAMETER=VALUE"). Throws Error (input) that
// names file and case for what is missing, unknown or contradictory.
[[nodiscard]] std::vector<Case> parse_cases(std::string_view text, const std::string& file);

// Those of tuner/check/cases, family after family.
[[nodiscard]] std::vector<Case> all_cases();

}  // namespace assur::check
