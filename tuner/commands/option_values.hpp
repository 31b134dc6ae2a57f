// Values of options, and checks of them.
#pragma once

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "assur/scene.hpp"
#include "sweep/design_space.hpp"

namespace assur::options {

// "name=value" with a finite number.
void take_parameter(Parameters& set, const std::string& text);

// "joint=LAW"; the law is read with the model.
void take_drive(std::vector<std::pair<std::string, std::string>>& drive, const std::string& text);

// "N" or "GROUP=N" with a whole number from 0.
void take_mode(std::vector<std::pair<std::string, std::size_t>>& modes, const std::string& text);

// "C=1.2,0.3", two or three finite numbers.
void take_guess(std::vector<std::pair<std::string, std::vector<double>>>& guesses, const std::string& text);

// "1e-4,1e-6": numbers > 0. Returns them without repetitions, the largest first.
void take_accuracies(std::vector<double>& accuracies, const std::string& text);

// "a=0.2:0.8,b=1:2", parameters with finite numbers.
void take_ranges(std::vector<sweep::Range>& ranges, const std::string& text);

// "I:J", whole numbers.
[[nodiscard]] std::pair<std::int64_t, std::int64_t> sample_range(const std::string& text);

// "A,B", without an empty name.
void take_names(std::vector<std::string>& names, const std::string& text, const std::string& option);

// Checks. They have no names, so that the help remains simple.
// A finite number, more than `above` and at most `most`; `what` describes the limits: "", " > 0".
[[nodiscard]] CLI::Validator number(double above, const std::string& what, double most = HUGE_VAL);
[[nodiscard]] CLI::Validator accuracy();
[[nodiscard]] CLI::Validator whole_number(int least);  // from `least` to the largest int
[[nodiscard]] CLI::Validator one_of(const std::vector<std::string>& names);

}  // namespace assur::options
