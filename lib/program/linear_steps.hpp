// Linear systems of a group in its step program, with the pivots of the backend `lanes`.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "backends/lanes_elimination.hpp"
#include "backends/lanes_factors.hpp"
#include "index.hpp"
#include "program/group_slots.hpp"
#include "program/small_inverse-inl.hpp"
#include "program/step_graph.hpp"
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

// |b - A x| / (|A| |x| + |b|) in maximum norms, as PackKernels::residual.
[[nodiscard]] inline Value linear_residual(const Pattern& pattern, const std::vector<Value>& matrix,
                                           const std::vector<Value>& x, const std::vector<Value>& b) {
  std::vector<Value> rest = b, row_sums(b.size());
  for (std::int32_t c = 0; c < pattern.n; ++c) {
    for (std::int32_t k = pattern.column_start[idx(c)]; k < pattern.column_start[idx(c) + 1]; ++k) {
      const std::size_t r = idx(pattern.row[idx(k)]);
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

  // Calls each(number) for the numbers of the factors, which can be kept and put back.
  template <class Each>
  void each_number(const Each& each) {
    for (std::size_t k = 0; k < p_.square_slot; ++k) each(slots_[k]);
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

// The inverse of a Jacobian: of up to kWithoutPivots unknowns by cofactors.
class Inverse {
  using Values = std::vector<Value>;

 public:
  // elimination: for more than kWithoutPivots unknowns
  Inverse(const Pattern& pattern, const lanes::Elimination& elimination)
      : pattern_(pattern), n_(idx(pattern.n)), linear_(pattern, elimination) {}

  // Returns a positive number where it is not exact.
  [[nodiscard]] Value invert(const Values& nonzeros) {
    switch (n_) {
      case 1:
        one_ = kAll / nonzeros[0];
        return exceeds(one_ - one_, kNone);
      case 2:
        return invert(two_, nonzeros);
      case 3:
        return invert(three_, nonzeros);
      default:
        return linear_.factorize(nonzeros);
    }
  }
  [[nodiscard]] Values solve(const Values& b) const {
    switch (n_) {
      case 1:
        return {one_ * b[0]};
      case 2:
        return solve(two_, b);
      case 3:
        return solve(three_, b);
      default:
        return linear_.solve(b);
    }
  }
  [[nodiscard]] Values column(std::size_t e) const {
    Values unit(n_);
    unit[e] = kAll;
    return solve(unit);
  }

  // Its numbers in Memory::work, from a number on: at most most_numbers().
  void keep(GroupSlots& to, std::size_t first) {
    each_number([&](const Value& number) { to.store(Memory::work, first++, number); });
  }
  void recall(const GroupSlots& from, std::size_t first) {
    each_number([&](Value& number) { number = from.load(Memory::work, first++); });
  }
  [[nodiscard]] static std::size_t most_numbers(std::int32_t n) { return idx(n) * idx(n) + 1; }

 private:
  template <int N>
  using Small = HWY_NAMESPACE::SmallInverse<Value, N>;
  template <int N>
  Value invert(Small<N>& inverse, const Values& nonzeros) const {
    Value a[N][N];
    for (std::int32_t c = 0; c < N; ++c) {
      for (std::int32_t k = pattern_.column_start[idx(c)]; k < pattern_.column_start[idx(c) + 1]; ++k) {
        a[pattern_.row[idx(k)]][c] = nonzeros[idx(k)];
      }
    }
    return inverse.invert(a);
  }
  template <int N>
  static Values solve(const Small<N>& inverse, const Values& b) {
    Value right[N], x[N];
    std::copy_n(b.begin(), N, right);
    inverse.solve(right, x);
    return {x, x + N};
  }
  template <class Each>
  void each_number(const Each& each) {
    switch (n_) {
      case 1:
        return each(one_);
      case 2:
        return two_.each_number(each);
      case 3:
        return three_.each_number(each);
      default:
        return linear_.each_number(each);
    }
  }

  const Pattern& pattern_;
  std::size_t n_;
  Value one_;
  Small<2> two_;
  Small<3> three_;
  LinearSteps linear_;
};

}  // namespace assur
