// The postures of a step at which failures were examined. Those of one block approach a singular posture.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "groups/singularity.hpp"

namespace assur {

// The latest postures, in memory that is reserved.
class Approach {
 public:
  // reads: the most inputs of a block
  void reserve(std::size_t reads) {
    postures_.resize(kMost);
    for (Singularity& s : postures_) s.reads.reserve(reads);
  }
  void clear() { count_ = 0; }

  // Drops the postures of the block that are no farther from the singular one than this posture.
  void drop_behind(const Singularity& here) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      if (is_same_block(postures_[i], here) && postures_[i].smallest <= here.smallest) continue;
      std::swap(postures_[kept++], postures_[i]);  // keeps the memory of both
    }
    count_ = kept;
  }
  // Drops the oldest posture if the memory is full.
  void add(const Singularity& here) {
    if (count_ == kMost) {
      std::rotate(postures_.begin(), postures_.begin() + 1, postures_.end());
      --count_;
    }
    postures_[count_++] = here;
  }

  // The last N postures of the block of `of`, the latest one last; null: there are fewer.
  template <std::size_t N>
  [[nodiscard]] std::array<const Singularity*, N> last(const Singularity& of) const {
    std::array<const Singularity*, N> found{};
    for (std::size_t i = count_, left = N; i-- > 0 && left > 0;) {
      if (is_same_block(postures_[i], of)) found[--left] = &postures_[i];
    }
    return found;
  }

 private:
  // A step that approaches one posture examines 13 failures; other blocks may fail in between.
  static constexpr std::size_t kMost = 64;

  [[nodiscard]] static bool is_same_block(const Singularity& a, const Singularity& b) {
    return a.status.where == b.status.where && a.block == b.block;
  }

  std::vector<Singularity> postures_;
  std::size_t count_ = 0;
};

}  // namespace assur
