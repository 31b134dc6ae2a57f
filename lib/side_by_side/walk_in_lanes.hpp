// Follows several mechanisms that differ in numbers only to their start, one in each SIMD lane. structure/walk.hpp
// follows one mechanism, wherever that is possible; here all of them move in steps of one length, without change
// points.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "path/stride.hpp"
#include "side_by_side/tile.hpp"
#include "structure/walk.hpp"

namespace assur {

class WalkInLanes {
 public:
  // system: any of the mechanisms. parts: in solving order; each has as many equations as unknowns.
  WalkInLanes(const System& system, const std::vector<WalkedPart>& parts, int lanes);

  // Begins anew, without mechanisms.
  void clear() { members_ = 0; }
  // Adds a mechanism: its numbers, its way, and its posture at s = 0 (all coordinates). At most one for each lane.
  void add(const System& numbers, const Way& way, std::span<const double> q);
  // Follows the ways of all mechanisms as far as possible.
  void run();

  // Of the i-th mechanism: true if it is at s = 1; its last posture, with the input that closes drawings at the end.
  [[nodiscard]] bool arrived(std::size_t i) const { return lanes_[i].arrived; }
  [[nodiscard]] const std::vector<double>& posture(std::size_t i) const { return lanes_[i].variant.posture; }

 private:
  struct Lane {
    std::shared_ptr<System> system;
    Variant variant;
    bool arrived = false;
  };
  [[nodiscard]] Status follow(std::vector<std::size_t>& in_tile);

  std::shared_ptr<System> system_;  // the equations, less (1 - s) times what is open
  std::size_t numbers_ = 0;         // constants of the mechanism; behind them: of what is open, by equation
  std::shared_ptr<const Structure> structure_;
  std::vector<Lane> lanes_;
  std::optional<Tile> tile_;
  std::size_t members_ = 0;
  double at_ = 0;  // s
  Stride stride_;
};

}  // namespace assur
