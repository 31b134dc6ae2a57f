// Helpers of the backends, and the declarations for their rows in the table.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <memory_resource>
#include <span>
#include <string>
#include <string_view>

#include "assur/backend.hpp"

namespace assur {

inline constexpr int kRightSides = 4;  // right-hand sides that backends solve at once

// Declares the functions of a backend. If its library was not found, absent.cpp.in defines them.
#define ASSUR_DECLARE_BACKEND(ID)                                               \
  namespace ID {                                                                \
  std::string why_not(const Shape& shape, ThreadBudget budget);                 \
  std::unique_ptr<LinearSolver> make(ThreadBudget budget, Precision precision); \
  std::string version();                                                        \
  }

// The row of a backend, with its properties.
#define ASSUR_BACKEND(ID, ...) \
  Backend { .id = #ID, .why_not = ID::why_not, .make = ID::make, .version = ID::version, __VA_ARGS__ }

ASSUR_DECLARE_BACKEND(eigen)
ASSUR_DECLARE_BACKEND(lanes)

// The backends of the core, which are in both tables.
inline constexpr Backend kEigen =
    ASSUR_BACKEND(eigen, .licence = "MPL-2.0", .dense = true, .single = true, .steady = true, .own_loops = true);
inline constexpr Backend kLanes = ASSUR_BACKEND(lanes, .licence = "Apache-2.0", .single = true, .steady = true,
                                                .keeps_pivots = true, .fills_lanes = true, .own_loops = true);

// The row of backends() with this id; a row without properties if there is none.
[[nodiscard]] const Backend& properties_of(std::string_view id);

// Throws Error (input) unless the pattern is as backend.hpp describes it and there is at least one lane.
void check_analysis(const Pattern& pattern, int lanes);

// Throws Error (input), which names `what`, unless the two sizes are equal.
void check_size(std::string_view what, std::size_t actual, std::size_t expected);

// +1 for an even permutation of 0 to n - 1, -1 for an odd one.
int parity(std::span<const std::int32_t> permutation,
           std::pmr::memory_resource* memory = std::pmr::get_default_resource());

// Status of the worst lane: not_finite before singular, then the lowest lane.
Status worst(std::span<const Code> lanes);

// True if every |value| is at most `limit`; false for NaN.
bool all_within(std::span<const double> values, double limit);

// Sets one lane of interleaved numbers to NaN.
void fill_with_nan(std::span<double> interleaved, int lanes, int lane);

// values[k] = interleaved[k * lanes + lane]. Returns max |values|, or NaN if one of them is not finite.
double take_lane(std::span<const double> interleaved, int lanes, int lane, std::span<double> values);

}  // namespace assur
