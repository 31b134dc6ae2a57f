// A column-major block within a larger matrix.
#pragma once

#include <cstddef>

namespace assur {

using DenseIndex = std::ptrdiff_t;

template <class T>
struct Block {
  T* data;
  DenseIndex rows, columns, stride;

  T& operator()(DenseIndex i, DenseIndex j) const { return data[i + j * stride]; }
  T* column(DenseIndex j) const { return data + j * stride; }
  Block block(DenseIndex i, DenseIndex j, DenseIndex r, DenseIndex c) const {
    return {data + i + j * stride, r, c, stride};
  }
};

}  // namespace assur
