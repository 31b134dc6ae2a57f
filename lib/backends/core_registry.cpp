#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "assur/backend.hpp"
#include "backends/backends.hpp"
#include "numbers.hpp"

namespace assur {
namespace {

constexpr std::array kCore = {kEigen, kLanes};

[[noreturn]] void refuse(std::string what) { throw Error(Error::Kind::input, std::move(what)); }

}  // namespace

std::span<const Backend> core_backends() { return kCore; }

const Backend& find_backend(std::span<const Backend> table, std::string_view id) {
  std::string known;
  for (const Backend& backend : table) {
    if (backend.id == id) return backend;
    known += (known.empty() ? "" : ", ") + std::string(backend.id);
    const std::string why_not = backend.why_not(Shape{}, ThreadBudget{});
    if (!why_not.empty()) known += " (cannot run: " + why_not + ")";
  }
  refuse("there is no backend \"" + std::string(id) + "\"; the backends are " + known);
}

void check_analysis(const Pattern& pattern, int lanes) {
  const auto size = [](const auto& array) { return std::to_string(array.size()); };
  if (lanes < 1) refuse("a solver needs at least one lane, not " + std::to_string(lanes));
  if (pattern.n < 0 || pattern.column_start.size() != static_cast<std::size_t>(pattern.n) + 1) {
    refuse("a pattern needs n + 1 column starts, not " + size(pattern.column_start) +
           " for n = " + std::to_string(pattern.n));
  }
  if (pattern.column_start.front() != 0 || pattern.column_start.back() != pattern.nnz() ||
      !std::is_sorted(pattern.column_start.begin(), pattern.column_start.end())) {
    refuse("the column starts of a pattern must ascend from 0 to its " + size(pattern.row) + " nonzeros");
  }
  for (std::int32_t column = 0; column < pattern.n; ++column) {
    std::int32_t last = -1;
    for (auto k = pattern.column_start[static_cast<std::size_t>(column)];
         k < pattern.column_start[static_cast<std::size_t>(column) + 1]; ++k) {
      const std::int32_t row = pattern.row[static_cast<std::size_t>(k)];
      if (row <= last || row >= pattern.n) {
        refuse("the rows of column " + std::to_string(column) + " of a pattern must ascend within 0 to n - 1");
      }
      last = row;
    }
  }
}

void check_size(std::string_view what, std::size_t actual, std::size_t expected) {
  if (actual == expected) return;
  refuse("a solver expects " + std::to_string(expected) + " " + std::string(what) + ", not " + std::to_string(actual));
}

int parity(std::span<const std::int32_t> permutation, std::pmr::memory_resource* memory) {
  int sign = 1;
  std::pmr::vector<bool> seen(permutation.size(), false, memory);
  for (std::size_t start = 0; start < seen.size(); ++start) {
    for (std::size_t i = start; !seen[i]; i = static_cast<std::size_t>(permutation[i])) {
      seen[i] = true;
      if (static_cast<std::size_t>(permutation[i]) != start) sign = -sign;  // a cycle of k elements is k - 1 swaps
    }
  }
  return sign;
}

Status worst(std::span<const Code> lanes) {
  for (Code code : {Code::not_finite, Code::singular}) {
    const auto found = std::find(lanes.begin(), lanes.end(), code);
    if (found != lanes.end()) return {code, Place::lane(static_cast<std::int32_t>(found - lanes.begin()))};
  }
  return {};
}

// Compares bits as integers, which vectorises: infinity and NaN are larger than any finite number.
bool all_within(std::span<const double> values, double limit) {
  constexpr auto kMagnitude = ~std::uint64_t{0} >> 1;
  const auto largest = std::bit_cast<std::uint64_t>(limit);
  std::uint64_t negative = 0;  // its highest bit is set if some difference was negative
  for (const double value : values) negative |= largest - (std::bit_cast<std::uint64_t>(value) & kMagnitude);
  return negative <= kMagnitude;
}

void fill_with_nan(std::span<double> interleaved, int lanes, int lane) {
  for (auto i = static_cast<std::size_t>(lane); i < interleaved.size(); i += static_cast<std::size_t>(lanes)) {
    interleaved[i] = kNan;
  }
}

double take_lane(std::span<const double> interleaved, int lanes, int lane, std::span<double> values) {
  const auto stride = static_cast<std::size_t>(lanes);
  double largest = 0, poison = 0;  // poison: 0 as long as every value is finite, else NaN
  for (std::size_t k = 0, from = static_cast<std::size_t>(lane); k < values.size(); ++k, from += stride) {
    const double value = interleaved[from];
    values[k] = value;
    largest = std::max(largest, std::abs(value));
    poison += value * 0;
  }
  return largest + poison;
}

}  // namespace assur
