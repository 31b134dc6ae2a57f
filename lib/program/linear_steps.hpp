// Linear systems of a group in its step program, with the pivots of the backend `lanes`.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "backends/lanes_elimination.hpp"
#include "backends/lanes_factors.hpp"
#include "index.hpp"
#include "program/graph.hpp"
#include "program/group_slots.hpp"
#include "program/step_rules.hpp"

namespace assur {

inline const Value kNone = Value::set(0), kAll = Value::set(1);

// 1 where a <= b, else 0, also for NaN.
[[nodiscard]] inline Value at_most(const Value& a, const Value& b) { return if_at_most(a, b, kAll, kNone); }
[[nodiscard]] inline Value exceeds(const Value& a, const Value& b) { return if_at_most(a, b, kNone, kAll); }

// The largest size of the numbers; NaN if one of them, or their sum, is not finite.
[[nodiscard]] inline Value largest_of(const std::vector<Value>& numbers) {
  Value largest = kNone, sum = kNone;
  for (const Value& x : numbers) {
    largest = max(abs(x), largest);
    sum = sum + x;
  }
  return largest + (sum - sum);
}

// The loops of the backend `lanes` (backends/lanes_kernels.cpp), written out.
class LinearSteps {
  using Values = std::vector<Value>;

 public:
  LinearSteps(const Pattern& pattern, const lanes::Elimination& elimination)
      : pattern_(pattern), p_(elimination), slots_(elimination.slots) {}

  // Returns a positive number where growth or a pivot exceeds its limit.
  [[nodiscard]] Value factorize(const Values& matrix) {
    const lanes::Limits limits = lanes::limits(pattern_.n, Precision::binary64);
    const auto square = [](double x) { return Value::set(x * x); };
    const Value shrink = square(1 / limits.growth), pivot = square(limits.pivot), smallest = square(limits.smallest);
    Value failed = kNone, largest_u = kAll;
    const Number* op = p_.factor.data();
    std::size_t l = 0;
    for (Number row = 0; row < p_.n; ++row) {
      const Number left = op[0], right = op[1];
      std::size_t u = op[2];
      op += 3;
      Value of_a = kNone, of_l = kNone, of_u = kNone;  // squares
      for (Number k = 0; k < left; ++k) {
        slots_[l] = entry(op, matrix, of_a);
        of_l.add_product(slots_[l], slots_[l]);
        ++l;
      }
      const Value diagonal = entry(op, matrix, of_a), r = kAll / diagonal;
      slots_[l++] = r;
      for (Number k = 0; k < right; ++k) {
        const Value e = entry(op, matrix, of_a);
        slots_[u++] = e * r;
        of_u.add_product(e, e);
      }
      const Value of_d = diagonal * diagonal, of_row = (of_l + of_d) + of_u;
      Value least = smallest;
      least.add_product(of_a, pivot);
      failed = failed + exceeds((of_row * shrink) * largest_u, of_a) + exceeds(least, of_d);
      largest_u = max(largest_u, (of_u * r) * r);
    }
    return failed;
  }

  // The factors in Memory::work, from a number on.
  void keep(GroupSlots& to, std::size_t first) const {
    for (std::size_t k = 0; k < p_.square_slot; ++k) to.store(Memory::work, first + k, slots_[k]);
  }
  void recall(const GroupSlots& from, std::size_t first) {
    for (std::size_t k = 0; k < p_.square_slot; ++k) slots_[k] = from.load(Memory::work, first + k);
  }

  // Unknowns before first_wanted are unspecified.
  [[nodiscard]] Values solve(const Values& b, int first_wanted = 0) const {
    Values y(p_.n), x(p_.n);
    std::size_t factor = 0;
    const Number* op = p_.forward.data();
    for (Number row = 0; row < p_.n; ++row) {
      Value sum = b[op[0]];
      const Number left = op[1];
      op += 2;
      for (Number k = 0; k < left; ++k) sum.subtract_product(slots_[factor++], y[*op++]);
      y[row] = sum * slots_[factor++];
    }
    op = p_.backward.data();
    for (Number rows = p_.wanted_rows[idx(first_wanted)]; rows != 0; --rows) {
      const Number at = op[0], unknown = op[1], right = op[2];
      op += 3;
      for (Number k = 0; k < right; ++k) y[at].subtract_product(slots_[factor++], y[*op++]);
      x[unknown] = y[at];
    }
    return x;
  }

  // |b - A x| / (|A| |x| + |b|) in maximum norms, as PackKernels::residual.
  [[nodiscard]] Value residual(const Values& matrix, const Values& x, const Values& b) const {
    Values rest = b, row_sums(b.size());
    for (std::int32_t c = 0; c < pattern_.n; ++c) {
      for (std::int32_t k = pattern_.column_start[idx(c)]; k < pattern_.column_start[idx(c) + 1]; ++k) {
        const std::size_t r = idx(pattern_.row[idx(k)]);
        rest[r].subtract_product(matrix[idx(k)], x[idx(c)]);
        row_sums[r] = row_sums[r] + abs(matrix[idx(k)]);
      }
    }
    Value norm = kNone, norm_x = kNone, size = kNone;
    for (std::size_t i = 0; i < b.size(); ++i) {
      norm = max(row_sums[i], norm);
      norm_x = max(abs(x[i]), norm_x);
      size = max(abs(b[i]), size);
    }
    size.add_product(norm, norm_x);
    return largest_of(rest) / if_at_most(size, kNone, kAll, size);
  }

 private:
  using Number = lanes::Elimination::Number;

  [[nodiscard]] Value entry(const Number*& op, const Values& matrix, Value& square_of_a) const {
    Value a = kNone;
    if (*op != lanes::Elimination::kZero) {
      a = matrix[*op];
      square_of_a.add_product(a, a);
    }
    Number products = op[1];
    op += 2;
    for (; products != 0; --products, op += 2) a.subtract_product(slots_[op[0]], slots_[op[1]]);
    return a;
  }

  const Pattern& pattern_;
  const lanes::Elimination& p_;
  Values slots_;
};

}  // namespace assur
