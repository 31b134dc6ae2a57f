#include "dispatch/counts.hpp"

#include <algorithm>
#include <random>
#include <vector>

#include "backends/lanes_elimination.hpp"
#include "equations/outputs.hpp"
#include "evaluation/coefficients.hpp"
#include "executors/step_code.hpp"
#include "index.hpp"
#include "program/class_step.hpp"

namespace assur {
namespace {

constexpr std::int32_t kMostPerRow = 24;  // entries in a row, on average: factors of more are full

constexpr std::int64_t kCurved = 60;  // pieces of work for a distance or an angle among the outputs
// Instructions of class_step() for a term: 19 to 25 for classes of 1 to 240 unknowns
constexpr std::int64_t kInstructionsOfTerm = 20;
constexpr std::int64_t kWatched = 2;  // pieces of work for a term of a watched equation: its value and its scale

// FNV-1a over the bytes of numbers; never 0.
class Hash {
 public:
  template <class Number>
  void take(Number number) {
    for (std::size_t byte = 0; byte < sizeof number; ++byte) {
      hash_ = (hash_ ^ (static_cast<std::uint64_t>(number) >> (8 * byte) & 0xff)) * 0x100000001b3;
    }
  }
  [[nodiscard]] std::uint64_t value() const { return hash_ == 0 ? 1 : hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325;
};

std::uint64_t hash_of(const Pattern& pattern) {
  Hash hash;
  for (const std::int32_t start : pattern.column_start) hash.take(start);
  for (const std::int32_t row : pattern.row) hash.take(row);
  return hash.value();
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

std::int64_t terms_of(const GroupClass& c) {
  return std::ssize(c.operands) + std::ssize(c.linear) + std::ssize(c.products) + std::ssize(c.entry_operands);
}

// As step_code.cpp decides, without writing the program.
bool is_short(const Shape& s) { return kInstructionsOfTerm * s.terms <= static_cast<std::int64_t>(kMostInstructions); }

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
  shape.terms = terms_of(group_class);
  shape.one_program = has_group_step(group_class) || (has_class_step(group_class) && is_short(shape));
  return shape;
}

std::vector<Shape> class_shapes(const GroupedSystem& s) {
  const std::vector<ClassSize> sizes = class_sizes(s);
  std::vector<Shape> shapes;
  for (std::size_t c = 0; c < s.classes.size(); ++c) shapes.push_back(shape_of(s.classes[c], sizes[c].groups));
  return shapes;
}

AroundCounts around_counts(const GroupedSystem& s) {
  AroundCounts counts;
  for (const SolvedGroup& g : s.groups) counts.unknowns += s.classes[idx(g.group_class)].n;
  for (const Output& o : wanted_outputs(*s.system)) {
    const std::int64_t wanted = o.wanted[0] + o.wanted[1] + o.wanted[2];
    counts.columns += static_cast<std::int64_t>(o.part_count) * wanted;
    for (const OutputPart& part : o.parts()) {
      const bool linear = part.kind == MeasureForms::Kind::form;
      counts.pieces += linear ? wanted * static_cast<std::int64_t>(s.system->form(part.forms[0]).size()) : kCurved;
    }
  }
  counts.pieces += kWatched * terms_of(s.watch_class);
  return counts;
}

Shape shape_of_step(const GroupedSystem& s, const std::vector<Shape>& shapes) {
  const AroundCounts around = around_counts(s);
  Shape step{.groups = static_cast<std::int32_t>(s.groups.size())};
  Hash hash;
  for (const std::int64_t count : {around.unknowns, around.columns, around.pieces}) hash.take(count);
  for (const Shape& c : shapes) {
    hash.take(c.pattern);
    hash.take(c.terms);
  }
  for (const SolvedGroup& g : s.groups) {
    const Shape& c = shapes[idx(g.group_class)];
    hash.take(g.group_class);
    hash.take(g.level);
    step.n += c.n;
    step.nnz += c.nnz;
    step.rhs = std::max(step.rhs, c.rhs);
    step.fill += c.fill;
    step.operations += c.operations;
    step.depth += c.depth;
    step.terms += c.terms;
  }
  step.pattern = hash.value();
  return step;
}

}  // namespace assur
