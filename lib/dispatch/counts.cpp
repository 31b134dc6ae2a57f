#include "dispatch/counts.hpp"

#include <algorithm>
#include <random>
#include <vector>

#include "backends/lanes_elimination.hpp"
#include "evaluation/coefficients.hpp"

namespace assur {
namespace {

constexpr std::int32_t kMostPerRow = 24;  // entries in a row, on average: factors of more are full

// FNV-1a over the numbers of a pattern.
std::uint64_t hash_of(const Pattern& pattern) {
  std::uint64_t hash = 0xcbf29ce484222325;
  const auto take = [&](std::int32_t number) {
    for (int byte = 0; byte < 4; ++byte) {
      hash = (hash ^ (static_cast<std::uint32_t>(number) >> (8 * byte) & 0xff)) * 0x100000001b3;
    }
  };
  for (const std::int32_t start : pattern.column_start) take(start);
  for (const std::int32_t row : pattern.row) take(row);
  return hash == 0 ? 1 : hash;
}

// Values whose sums do not cancel, so that structural nonzeros stay nonzero.
std::vector<double> generic_values(std::size_t count) {
  std::mt19937_64 random(1);
  std::vector<double> values(count);
  for (double& value : values) value = 1 + static_cast<double>(random() >> 11) * 0x1p-53;
  return values;
}

void count_as_full(Shape& shape) {
  const std::int64_t n = shape.n;
  shape.fill = n * n;
  shape.operations = n * (n - 1) * (2 * n - 1) / 6 + n * n;
  shape.depth = 2 * n;
}

// Length of the longest chain of rows in which each row needs the one before. Rows are "head, count, positions": `head`
// numbers come before the count. own(row, numbers) is the position that a row computes.
template <class Own>
std::int64_t depth_of(const std::vector<lanes::Elimination::Number>& rows, std::size_t n, std::size_t head,
                      const Own& own) {
  std::vector<std::int64_t> depth(n, 0);
  std::int64_t deepest = 0;
  std::size_t at = 0;
  for (std::size_t row = 0; row < n; ++row) {
    std::int64_t waits = 0;
    const std::size_t count = rows[at + head];
    for (std::size_t e = 0; e < count; ++e) waits = std::max(waits, depth[rows[at + head + 1 + e]]);
    depth[own(row, &rows[at])] = waits + 1;
    deepest = std::max(deepest, waits + 1);
    at += head + 1 + count;
  }
  return deepest;
}

void count_elimination(Shape& shape, const Pattern& pattern) {
  if (std::int64_t{shape.nnz} > std::int64_t{kMostPerRow} * shape.n) return count_as_full(shape);
  try {
    const lanes::Order order = lanes::markowitz_order(pattern, generic_values(pattern.row.size()), 1, 1,
                                                      {.threshold = 0, .shallow = false, .rook = false});
    if (!order.complete(pattern.n)) return count_as_full(shape);  // structurally singular: the count does not matter
    const lanes::Elimination program = lanes::write_program(pattern, order);
    shape.fill = std::int64_t{program.slots} - program.n;
    // The program has three numbers for each row, two for each entry, and two for each product.
    const std::int64_t products = (std::ssize(program.factor) - 3 * std::int64_t{shape.n} - 2 * shape.fill) / 2;
    shape.operations = products + shape.fill;
    const auto n = static_cast<std::size_t>(shape.n);
    shape.depth = depth_of(program.forward, n, 1, [](std::size_t row, const auto*) { return row; }) +
                  depth_of(program.backward, n, 2, [](std::size_t, const auto* numbers) { return numbers[0]; });
  } catch (const Error&) {  // too many products for a program
    count_as_full(shape);
  }
}

}  // namespace

Shape shape_of(const Pattern& pattern, std::int32_t count) {
  Shape shape{.n = pattern.n, .nnz = pattern.nnz(), .groups = count};
  count_elimination(shape, pattern);
  shape.pattern = hash_of(pattern);
  return shape;
}

Shape shape_of(const GroupClass& group_class, std::int32_t groups) {
  Shape shape = shape_of(group_class.pattern, groups);
  shape.rhs = 1 + group_class.derivatives;
  shape.terms = std::ssize(group_class.operands) + std::ssize(group_class.linear) + std::ssize(group_class.products) +
                std::ssize(group_class.entry_operands);
  return shape;
}

}  // namespace assur
