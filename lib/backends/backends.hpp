// What the backends share, and the three functions that each brings to its row of the table.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "assur/backend.hpp"

namespace assur {

inline constexpr int kRightSides = 4;  // solved at once: room is made for so many

namespace eigen {
std::string why_not(const Shape& shape, ThreadBudget budget);
std::unique_ptr<LinearSolver> make(ThreadBudget budget, Precision precision);
std::string version();
}  // namespace eigen

namespace lapack {
std::string why_not(const Shape& shape, ThreadBudget budget);
std::unique_ptr<LinearSolver> make(ThreadBudget budget, Precision precision);
std::string version();
}  // namespace lapack

namespace team {
std::string why_not(const Shape& shape, ThreadBudget budget);
std::unique_ptr<LinearSolver> make(ThreadBudget budget, Precision precision);
std::string version();
}  // namespace team

namespace klu {
std::string why_not(const Shape& shape, ThreadBudget budget);
std::unique_ptr<LinearSolver> make(ThreadBudget budget, Precision precision);
std::string version();
}  // namespace klu

namespace umfpack {
std::string why_not(const Shape& shape, ThreadBudget budget);
std::unique_ptr<LinearSolver> make(ThreadBudget budget, Precision precision);
std::string version();
}  // namespace umfpack

namespace mumps {
std::string why_not(const Shape& shape, ThreadBudget budget);
std::unique_ptr<LinearSolver> make(ThreadBudget budget, Precision precision);
std::string version();
}  // namespace mumps

namespace ma27 {
std::string why_not(const Shape& shape, ThreadBudget budget);
std::unique_ptr<LinearSolver> make(ThreadBudget budget, Precision precision);
std::string version();
}  // namespace ma27

namespace lanes {
std::string why_not(const Shape& shape, ThreadBudget budget);
std::unique_ptr<LinearSolver> make(ThreadBudget budget, Precision precision);
std::string version();
}  // namespace lanes

// Whether one thread at a time is inside the backend's library: others wait for their turn and gain nothing.
[[nodiscard]] bool takes_turns(std::string_view id);

// Throws Error (input) unless the pattern is as backend.hpp describes it and there is at least one lane.
void check_analysis(const Pattern& pattern, int lanes);

// Throws Error (input) unless a span called `what` has the size that the analysed pattern asks for.
void check_size(std::string_view what, std::size_t actual, std::size_t expected);

// Status of the worst lane: not_finite before singular, then the lowest lane.
Status worst(std::span<const Code> lanes);

// Whether every |value| is at most `limit`; false for NaN.
bool all_within(std::span<const double> values, double limit);

// NaN in one lane of interleaved numbers.
void fill_with_nan(std::span<double> interleaved, int lanes, int lane);

// values[k] = interleaved[k * lanes + lane]. Returns max |values|, or NaN if one of them is not finite.
double take_lane(std::span<const double> interleaved, int lanes, int lane, std::span<double> values);

}  // namespace assur
