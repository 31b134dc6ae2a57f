// Matrices for the tests of all linear solvers: one pattern, random values for each lane.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numeric>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "assur/backend.hpp"
#include "numbers.hpp"

namespace assur::test {

using Random = std::mt19937_64;

inline double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}
// Magnitude in [0.5, 1], random sign, so that no value is tiny by accident.
inline double nonzero(Random& random) { return uniform(random, 0.5, 1) * (random() % 2 ? 1 : -1); }

struct Matrix {
  Pattern pattern;
  std::vector<double> values;
};

// Compresses a dense n x n matrix given by its values; `in` selects the entries of the pattern.
inline Matrix compress(int n, const std::function<bool(int, int)>& in, const std::function<double(int, int)>& value) {
  Matrix a;
  a.pattern.n = n;
  a.pattern.column_start.push_back(0);
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      if (!in(i, j)) continue;
      a.pattern.row.push_back(i);
      a.values.push_back(value(i, j));
    }
    a.pattern.column_start.push_back(a.pattern.nnz());
  }
  return a;
}

inline std::vector<int> shuffled(int n, Random& random) {
  std::vector<int> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), random);
  return order;
}

inline Matrix dense(int n, Random& random) {
  return compress(
      n, [](int, int) { return true; }, [&](int, int) { return nonzero(random); });
}

// A permuted diagonal with entries of size 2 to 4, and up to `more` others of size 0.5 to 1 in each column. The pattern
// depends on n and `more` only.
inline Matrix sparse(int n, int more, Random& random) {
  Random fixed(static_cast<std::uint64_t>(100 * n + more));
  const std::vector<int> diagonal = shuffled(n, fixed);
  std::vector<std::vector<bool>> in(static_cast<std::size_t>(n), std::vector<bool>(static_cast<std::size_t>(n)));
  for (std::size_t j = 0; j < in.size(); ++j) {
    in[j][static_cast<std::size_t>(diagonal[j])] = true;
    for (int k = 0; k < more; ++k) in[j][static_cast<std::size_t>(fixed() % in.size())] = true;
  }
  return compress(
      n, [&](int i, int j) { return in[static_cast<std::size_t>(j)][static_cast<std::size_t>(i)]; },
      [&](int i, int j) { return i == diagonal[static_cast<std::size_t>(j)] ? 4 * nonzero(random) : nonzero(random); });
}

// Rows and columns of an upper triangle (with block > 1 an upper block triangle) in random order.
inline Matrix permuted_triangle(int n, int block, Random& random) {
  Random fixed(static_cast<std::uint64_t>(n));
  const std::vector<int> p = shuffled(n, fixed), q = shuffled(n, fixed);
  const auto at = [](const std::vector<int>& order, int i) { return order[static_cast<std::size_t>(i)]; };
  return compress(
      n, [&](int i, int j) { return at(p, i) / block <= at(q, j) / block; },
      [&](int i, int j) { return at(p, i) == at(q, j) ? 4 * nonzero(random) : nonzero(random); });
}

// Jacobian of a plane ring of n / 2 points, each at a fixed distance from its neighbours and from its own anchor, with
// 3n nonzeros and a condition of 5 to 16: the larger groups of the paper.
inline Matrix ring(int n, Random& random) {
  const int m = n / 2;
  const double pi = std::acos(-1.0), turn = uniform(random, 0, 2 * pi);  // the whole ring is turned
  const auto angle = [&](int i) { return 2 * pi * i / m + turn; };
  const auto point = [&](int i, int axis) {
    const double radius = m * std::cos(pi / 6) / (2 * pi) + 0.5 + (i % 2 ? 0.25 : -0.25);
    return radius * (axis == 0 ? std::cos(angle(i)) : std::sin(angle(i)));
  };
  const auto entry = [&](int row, int column) {  // row 2i: distance to the anchor, 2i + 1: to the next point
    const int i = row / 2, next = (i + 1) % m, p = column / 2, axis = column % 2;
    const double anchor = angle(i) + (i % 2 ? -pi / 6 : pi / 6);
    if (row % 2 == 0) return -2 * (axis == 0 ? std::cos(anchor) : std::sin(anchor));
    return 2 * (point(i, axis) - point(next, axis)) * (p == i ? 1 : -1);
  };
  const auto in = [&](int row, int column) {
    const int i = row / 2, p = column / 2;
    return p == i || (row % 2 == 1 && p == (i + 1) % m);
  };
  return compress(n, in, entry);
}

inline void scale(Matrix& a, const std::function<double(int, int)>& factor) {
  for (int j = 0; j < a.pattern.n; ++j) {
    for (auto k = a.pattern.column_start[static_cast<std::size_t>(j)];
         k < a.pattern.column_start[static_cast<std::size_t>(j) + 1]; ++k) {
      a.values[static_cast<std::size_t>(k)] *= factor(a.pattern.row[static_cast<std::size_t>(k)], j);
    }
  }
}

// The last row repeats the first one. All entries come from products of two triangles of small integers with ones on
// the diagonal, so that elimination is exact in any order of its sums, fused or not, and ends at an exact zero.
inline Matrix repeated_row(int n, Random& random) {
  const auto below = [&](int i, int j) { return i < j ? 0.0 : i == j ? 1.0 : random() % 2 ? 1.0 : -1.0; };
  const Matrix l = compress(
      n, [](int, int) { return true; }, below);
  const Matrix u = compress(
      n, [](int, int) { return true; }, [&](int i, int j) { return below(j, i); });
  return compress(
      n, [](int, int) { return true; },
      [&](int i, int j) {
        double sum = 0;
        for (int k = 0; k < n; ++k) {
          const auto row = static_cast<std::size_t>(k * n + (i == n - 1 ? 0 : i)),
                     column = static_cast<std::size_t>(j * n + k);
          sum += l.values[row] * u.values[column];
        }
        return sum;
      });
}

// Returns values[k * lanes + lane] of several lanes.
inline std::vector<double> interleave(const std::vector<std::vector<double>>& lanes) {
  std::vector<double> all;
  for (std::size_t k = 0; k < lanes[0].size(); ++k) {
    for (const auto& lane : lanes) all.push_back(lane[k]);
  }
  return all;
}

inline std::vector<double> lane_of(std::span<const double> interleaved, int lanes, int lane) {
  std::vector<double> values;
  for (auto k = static_cast<std::size_t>(lane); k < interleaved.size(); k += static_cast<std::size_t>(lanes)) {
    values.push_back(interleaved[k]);
  }
  return values;
}

// Normwise backward error |b - A x| / (|A| |x| + |b|) in the maximum norm (Rigal & Gaches 1967); A' if transposed.
inline double backward_error(const Matrix& a, std::span<const double> x, std::span<const double> b,
                             Transpose transpose = Transpose::no) {
  const std::size_t n = b.size();
  std::vector<long double> residual(b.begin(), b.end()), row_sum(n);
  for (std::size_t j = 0; j < n; ++j) {
    for (auto k = a.pattern.column_start[j]; k < a.pattern.column_start[j + 1]; ++k) {
      auto to = static_cast<std::size_t>(a.pattern.row[static_cast<std::size_t>(k)]), from = j;
      if (transpose == Transpose::yes) std::swap(to, from);
      const long double value = a.values[static_cast<std::size_t>(k)];
      residual[to] -= value * x[from];
      row_sum[to] += std::abs(value);
    }
  }
  const auto norm = [](const auto& v) {
    long double largest = 0;
    for (auto element : v) {
      const auto size = std::abs(static_cast<long double>(element));
      if (!(size <= largest)) largest = size;  // NaN stays
    }
    return largest;
  };
  if (n == 0 || norm(b) == 0) return 0;
  return static_cast<double>(norm(residual) / (norm(row_sum) * norm(x) + norm(b)));
}

// Componentwise backward error max_i |b - A x|_i / (|A| |x| + |b|)_i (Oettli & Prager 1964); A' if transposed.
inline double componentwise_error(const Matrix& a, std::span<const double> x, std::span<const double> b,
                                  Transpose transpose = Transpose::no) {
  std::vector<long double> residual(b.begin(), b.end()), weight(b.size());
  for (std::size_t i = 0; i < b.size(); ++i) weight[i] = std::abs(residual[i]);
  for (std::size_t j = 0; j < b.size(); ++j) {
    for (auto k = a.pattern.column_start[j]; k < a.pattern.column_start[j + 1]; ++k) {
      auto to = static_cast<std::size_t>(a.pattern.row[static_cast<std::size_t>(k)]), from = j;
      if (transpose == Transpose::yes) std::swap(to, from);
      const long double product = static_cast<long double>(a.values[static_cast<std::size_t>(k)]) * x[from];
      residual[to] -= product;
      weight[to] += std::abs(product);
    }
  }
  long double largest = 0;
  for (std::size_t i = 0; i < b.size(); ++i) {
    const long double error = residual[i] == 0 ? 0 : std::abs(residual[i]) / weight[i];
    if (!(error <= largest)) largest = error;  // NaN stays
  }
  return static_cast<double>(largest);
}

// Wilkinson's matrix: elimination by partial pivoting doubles its last column at each step.
inline Matrix wilkinson(int n) {
  return compress(
      n, [](int, int) { return true; }, [n](int i, int j) { return j == n - 1 || i == j ? 1.0
                                                                   : i > j              ? -1.0
                                                                                        : 0.0; });
}

// Growth of 2^(n - 1) under partial pivoting, with a random part (Higham & Higham, SIAM J. Matrix Anal. Appl. 10, 1989,
// theorem 2.2): M [T d], M unit lower triangular with -1 below the diagonal, T upper triangular with n - 1 columns, d =
// (1, 2, 4, ...), the last column scaled to the largest entry. All entries are whole numbers, so that elimination is
// exact and equal pivots stay equal.
inline Matrix gfpp(int n, Random& random) {
  const auto size = static_cast<std::size_t>(n);
  std::vector<std::vector<double>> a(size, std::vector<double>(size));  // columns
  double largest = 0;
  for (std::size_t j = 0; j + 1 < size; ++j) {
    double above = 0;
    for (std::size_t i = 0; i < size; ++i) {
      const double t = i > j ? 0 : i == j ? n : static_cast<double>(random() % 3) - 1;  // well conditioned
      a[j][i] = t - above;
      above += t;
      largest = std::max(largest, std::abs(a[j][i]));
    }
  }
  a[size - 1].assign(size, largest);  // M d = (1, 1, 1, ...)
  return compress(
      n, [](int, int) { return true; },
      [&](int i, int j) { return a[static_cast<std::size_t>(j)][static_cast<std::size_t>(i)]; });
}

// Kahan's triangle (SIAM Review 8, 1966): its pivots do not show that it is nearly singular.
inline Matrix kahan(int n, double angle) {
  return compress(
      n, [](int i, int j) { return i <= j; },
      [angle](int i, int j) { return std::pow(std::sin(angle), i) * (i == j ? 1 : -std::cos(angle)); });
}

// Q1 D Q2 with singular values from 1 to 1 / condition in geometric steps, Q1 and Q2 random products of reflections.
inline Matrix with_condition(int n, double condition, Random& random) {
  const auto size = static_cast<std::size_t>(n);
  std::vector<std::vector<long double>> a(size, std::vector<long double>(size));
  for (std::size_t i = 0; i < size; ++i) {
    a[i][i] = std::pow(static_cast<long double>(condition), -static_cast<long double>(i) / (n - 1));
  }
  for (int side = 0; side < 2 * n; ++side) {  // reflects columns, then rows, in turn
    std::vector<long double> v(size);
    long double square = 0;
    for (long double& element : v) {
      element = uniform(random, -1, 1);
      square += element * element;
    }
    const auto at = [&](std::size_t i, std::size_t j) -> long double& { return side % 2 ? a[j][i] : a[i][j]; };
    for (std::size_t j = 0; j < size; ++j) {
      long double product = 0;
      for (std::size_t i = 0; i < size; ++i) product += v[i] * at(i, j);
      for (std::size_t i = 0; i < size; ++i) at(i, j) -= 2 * product / square * v[i];
    }
  }
  return compress(
      n, [](int, int) { return true; },
      [&](int i, int j) { return static_cast<double>(a[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)]); });
}

inline Matrix hilbert(int n) {
  return compress(
      n, [](int, int) { return true; }, [](int i, int j) { return 1.0 / (i + j + 1); });
}

}  // namespace assur::test
