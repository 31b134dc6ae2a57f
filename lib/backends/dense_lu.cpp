#include "backends/dense_lu.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace assur::eigen {
namespace {

constexpr DenseIndex kPanel = 24;  // columns eliminated by plain loops; measured on n = 3 to 720
constexpr DenseIndex kLeaf = 8;    // unknowns of a triangular system solved by plain loops; measured in the same way
constexpr DenseIndex kTile = 192;  // order of a tile of a matrix product: two tiles of doubles need 0.6 MB of stack

template <class T>
auto map(const Block<T>& b) {
  using Matrix = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic>;
  return Eigen::Map<Matrix, 0, Eigen::OuterStride<>>(b.data, b.rows, b.columns, Eigen::OuterStride<>(b.stride));
}

// c -= a b, or a' b
template <class T>
void subtract_product(const Block<T>& c, const Block<T>& a, const Block<T>& b, Transpose transpose = Transpose::no) {
  const DenseIndex depth = b.rows;
  for (DenseIndex j = 0; j < c.columns; j += kTile) {
    for (DenseIndex k = 0; k < depth; k += kTile) {
      for (DenseIndex i = 0; i < c.rows; i += kTile) {
        const DenseIndex m = std::min(kTile, c.rows - i), n = std::min(kTile, c.columns - j);
        const DenseIndex d = std::min(kTile, depth - k);
        const Block<T> part = c.block(i, j, m, n), right = b.block(k, j, d, n);
        if (transpose == Transpose::no) {
          map(part).noalias() -= map(a.block(i, k, m, d)) * map(right);
        } else {
          map(part).noalias() -= map(a.block(k, i, d, m)).transpose() * map(right);
        }
      }
    }
  }
}

template <class T>
void swap_rows(const Block<T>& a, const std::int32_t* pivot, DenseIndex count) {
  for (DenseIndex j = 0; j < a.columns; ++j) {
    T* column = a.column(j);
    for (DenseIndex k = 0; k < count; ++k) std::swap(column[k], column[pivot[k]]);
  }
}

// Plain right-looking elimination of a few columns. False at a pivot that is zero or not finite.
template <class T>
bool eliminate_panel(const Block<T>& a, std::int32_t* pivot) {
  for (DenseIndex k = 0; k < a.columns; ++k) {
    T* column = a.column(k);
    DenseIndex p = k;
    T largest = std::abs(column[k]);
    for (DenseIndex i = k + 1; i < a.rows; ++i) {  // no branch: it would often be predicted wrongly
      const T size = std::abs(column[i]);
      const bool larger = size > largest;
      largest = larger ? size : largest;
      p = larger ? i : p;
    }
    pivot[k] = static_cast<std::int32_t>(p);
    if (!(largest > 0 && largest <= std::numeric_limits<T>::max())) return false;
    if (p != k) {
      for (DenseIndex j = 0; j < a.columns; ++j) std::swap(a(k, j), a(p, j));
    }
    const T divisor = column[k];
    for (DenseIndex i = k + 1; i < a.rows; ++i) column[i] /= divisor;
    for (DenseIndex j = k + 1; j < a.columns; ++j) {
      T* other = a.column(j);
      const T factor = other[k];
      if (factor == 0) continue;  // frequent: equations of mechanisms have few nonzeros
      for (DenseIndex i = k + 1; i < a.rows; ++i) other[i] -= column[i] * factor;
    }
  }
  return true;
}

}  // namespace

// Each triangular solution splits its matrix in half; the off-diagonal half is a product.
template <class T>
void solve_lower(const Block<T>& l, const Block<T>& x) {
  const DenseIndex n = l.columns;
  if (n <= kLeaf) {
    for (DenseIndex r = 0; r < x.columns; ++r) {
      T* v = x.column(r);
      for (DenseIndex j = 0; j < n; ++j) {
        for (DenseIndex i = j + 1; i < n; ++i) v[i] -= l(i, j) * v[j];
      }
    }
    return;
  }
  const DenseIndex h = n / 2;
  const Block<T> top = x.block(0, 0, h, x.columns), bottom = x.block(h, 0, n - h, x.columns);
  solve_lower(l.block(0, 0, h, h), top);
  subtract_product(bottom, l.block(h, 0, n - h, h), top);
  solve_lower(l.block(h, h, n - h, n - h), bottom);
}

template <class T>
void solve_upper(const Block<T>& u, const Block<T>& x, DenseIndex first) {
  const DenseIndex n = u.columns;
  if (n <= kLeaf) {
    for (DenseIndex r = 0; r < x.columns; ++r) {
      T* v = x.column(r);
      for (DenseIndex j = n; j-- > first;) {
        v[j] /= u(j, j);
        for (DenseIndex i = first; i < j; ++i) v[i] -= u(i, j) * v[j];
      }
    }
    return;
  }
  const DenseIndex h = n / 2;
  const Block<T> bottom = x.block(h, 0, n - h, x.columns);
  solve_upper(u.block(h, h, n - h, n - h), bottom, std::max<DenseIndex>(first - h, 0));
  if (first >= h) return;
  subtract_product(x.block(first, 0, h - first, x.columns), u.block(first, h, h - first, n - h), bottom);
  solve_upper(u.block(0, 0, h, h), x.block(0, 0, h, x.columns), first);
}

template <class T>
void solve_upper_transposed(const Block<T>& u, const Block<T>& x) {
  const DenseIndex n = u.columns;
  if (n <= kLeaf) {
    for (DenseIndex r = 0; r < x.columns; ++r) {
      T* v = x.column(r);
      for (DenseIndex j = 0; j < n; ++j) {
        for (DenseIndex i = 0; i < j; ++i) v[j] -= u(i, j) * v[i];
        v[j] /= u(j, j);
      }
    }
    return;
  }
  const DenseIndex h = n / 2;
  const Block<T> top = x.block(0, 0, h, x.columns), bottom = x.block(h, 0, n - h, x.columns);
  solve_upper_transposed(u.block(0, 0, h, h), top);
  subtract_product(bottom, u.block(0, h, h, n - h), top, Transpose::yes);
  solve_upper_transposed(u.block(h, h, n - h, n - h), bottom);
}

template <class T>
void solve_lower_transposed(const Block<T>& l, const Block<T>& x) {
  const DenseIndex n = l.columns;
  if (n <= kLeaf) {
    for (DenseIndex r = 0; r < x.columns; ++r) {
      T* v = x.column(r);
      for (DenseIndex j = n; j-- > 0;) {
        for (DenseIndex i = j + 1; i < n; ++i) v[j] -= l(i, j) * v[i];
      }
    }
    return;
  }
  const DenseIndex h = n / 2;
  const Block<T> top = x.block(0, 0, h, x.columns), bottom = x.block(h, 0, n - h, x.columns);
  solve_lower_transposed(l.block(h, h, n - h, n - h), bottom);
  subtract_product(top, l.block(h, 0, n - h, h), bottom, Transpose::yes);
  solve_lower_transposed(l.block(0, 0, h, h), top);
}

template <class T>
bool eliminate(const Block<T>& a, std::int32_t* pivot) {
  const DenseIndex n = a.columns;
  if (n <= kPanel) return eliminate_panel(a, pivot);
  const DenseIndex h = n / 2;
  const Block<T> left = a.block(0, 0, a.rows, h), right = a.block(0, h, a.rows, n - h);
  if (!eliminate(left, pivot)) return false;
  swap_rows(right, pivot, h);
  const Block<T> top = right.block(0, 0, h, n - h), rest = right.block(h, 0, a.rows - h, n - h);
  solve_lower(left.block(0, 0, h, h), top);
  subtract_product(rest, left.block(h, 0, a.rows - h, h), top);
  if (!eliminate(rest, pivot + h)) return false;
  swap_rows(left.block(h, 0, a.rows - h, h), pivot + h, n - h);
  for (DenseIndex k = h; k < n; ++k) pivot[k] += static_cast<std::int32_t>(h);
  return true;
}

template <class T>
void solve_factored(const Block<T>& lu, const std::int32_t* pivot, const Block<T>& x, Transpose transpose,
                    DenseIndex first_wanted) {
  const auto swap = [&](T* column, DenseIndex k) { std::swap(column[k], column[pivot[k] - 1]); };
  if (transpose == Transpose::no) {  // P A = L U
    for (DenseIndex r = 0; r < x.columns; ++r) {
      for (DenseIndex k = 0; k < x.rows; ++k) swap(x.column(r), k);
    }
    solve_lower(lu, x);
    solve_upper(lu, x, first_wanted);
  } else {  // A' = U' L' P
    solve_upper_transposed(lu, x);
    solve_lower_transposed(lu, x);
    for (DenseIndex r = 0; r < x.columns; ++r) {
      for (DenseIndex k = x.rows; k-- > 0;) swap(x.column(r), k);
    }
  }
}

template void solve_lower(const Block<double>&, const Block<double>&);
template void solve_lower(const Block<float>&, const Block<float>&);
template void solve_upper(const Block<double>&, const Block<double>&, DenseIndex);
template void solve_upper(const Block<float>&, const Block<float>&, DenseIndex);
template void solve_upper_transposed(const Block<double>&, const Block<double>&);
template void solve_upper_transposed(const Block<float>&, const Block<float>&);
template void solve_lower_transposed(const Block<double>&, const Block<double>&);
template void solve_lower_transposed(const Block<float>&, const Block<float>&);
template void solve_factored(const Block<double>&, const std::int32_t*, const Block<double>&, Transpose, DenseIndex);
template void solve_factored(const Block<float>&, const std::int32_t*, const Block<float>&, Transpose, DenseIndex);
template bool eliminate(const Block<double>&, std::int32_t*);
template bool eliminate(const Block<float>&, std::int32_t*);

}  // namespace assur::eigen
