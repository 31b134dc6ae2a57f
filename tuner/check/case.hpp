// The cases of the stability suite: the runs, and their expected verdicts, which a file states before any run.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "assur/plan.hpp"
#include "assur/scene.hpp"
#include "assur/strategy.hpp"

namespace assur::check {

// The end of a run. "pass": a clean status, no event, and a forward error within the required accuracy; "refused": an
// Error of kind input or numerical; else the name of a Code. No case may expect "wrong" (a clean status, or rows before
// an event, with errors above the required accuracy), "other_bits", "no_yardstick" or "differs".
using Verdict = std::string;

struct Expected {
  std::vector<Verdict> verdicts;  // several if theory allows them; empty: the same verdict from all strategies
  std::string message;            // part of the message of a refusal
};

// "pass", "inaccurate or fold", "refused"
[[nodiscard]] std::string to_string(const Expected& expected);

struct Case {
  std::string family, name, about;
  // Exactly one is set: text of a sample or name of a file, a scene in the scene format, name of a maker (makers.hpp),
  // name of a matrix (matrices.hpp).
  std::string text, scene, maker, matrix;
  Parameters set;                             // parameters of the scene, the maker or the matrix
  std::vector<std::filesystem::path> tables;  // further folders for tables
  std::optional<TimeGrid> time;
  std::vector<std::string> outputs;
  double accuracy = 0;                    // required accuracy; 0: none, with the limit kDoubtfulError
  int iterations = 0;                     // StepSettings::iterations
  std::vector<Formulation> formulations;  // empty: all
  std::vector<std::string> strategies;    // empty: all that can run it
  std::string closed_form;                // closed_forms.hpp; empty: that of the maker, else the reference in quad
  bool plain = false;                     // compared with plain equations, including laws and turns of angles
  Parameters twin;                        // parameters with the same bits up to powers of two; empty: no twin
  std::string singularity = "regular";    // or "fold", "change_point", "redundant", ...: nearest singularity
  Expected expected;
  std::string because;  // reason if several verdicts are right
  bool quick = false;   // part of --quick

  // Results with a larger forward error are wrong.
  [[nodiscard]] double limit() const { return accuracy > 0 ? accuracy : kDoubtfulError; }
};

// Reads the cases of one file; each value of a sweep becomes a case ("NAME PARAMETER=VALUE"). Throws Error (input),
// which names file and case, for missing, unknown or contradictory entries.
[[nodiscard]] std::vector<Case> parse_cases(std::string_view text, const std::string& file);

// All cases of tuner/check/cases, family after family.
[[nodiscard]] std::vector<Case> all_cases();

}  // namespace assur::check
