// A column-major block within a larger matrix.
#pragma once

#include <cstddef>

namespace assur {

using Index = std::ptrdiff_t;

template <class T>
struct Block {
  T* data;
  Index rows, columns, stride;

  T& operator()(Index i, Index j) const { return data[i + j * stride]; }
  T* column(Index j) const { return data + j * stride; }
  Block block(Index i, Index j, Index r, Index c) const { return {data + i + j * stride, r, c, stride}; }
};

}  // namespace assur
