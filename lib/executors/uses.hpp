// Where the values of a phase are used: what decides which of them are in registers, and when stores are written.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "program/step_program.hpp"

namespace assur {

// The points where the values of a phase are used, and where its stores are written.
class Uses {
 public:
  // A place in a phase: 2 i is instruction i, and 2 i + 1 the stores behind it.
  using Point = std::uint32_t;
  static constexpr Point kNever = UINT32_MAX;

  explicit Uses(const Phase& phase)
      : of_(phase.code.size()),
        next_(phase.code.size()),
        stores_(phase.code.size()),
        is_replaced_(phase.stores.size(), false) {
    for (std::uint32_t i = 0; i < phase.code.size(); ++i) {
      const Instruction& n = phase.code[i];
      for (int k = 0; k < operands_of(n.op); ++k) of_[n.operand[static_cast<std::size_t>(k)]].push_back(2 * i);
    }
    // A store is written as early as possible, but behind the loads of its slot with their uses, and in order.
    std::map<Slot, std::uint32_t> read, written;
    std::map<Slot, std::size_t> last;
    for (std::uint32_t i = 0; i < phase.code.size(); ++i) {
      if (phase.code[i].op == Op::load) read[phase.code[i].slot] = of_[i].empty() ? i : std::max(i, of_[i].back() / 2);
    }
    std::vector<std::uint32_t> behind;
    for (const Phase::Store& s : phase.stores) {
      std::uint32_t at = s.value;
      for (const auto* const others : {&read, &written}) {
        if (const auto found = others->find(s.to); found != others->end()) at = std::max(at, found->second);
      }
      behind.push_back(written[s.to] = at);
      const std::size_t number = behind.size() - 1;
      if (const auto [before, is_first] = last.emplace(s.to, number); !is_first) {
        is_replaced_[std::exchange(before->second, number)] = true;
      }
    }
    for (std::size_t s = 0; s < behind.size(); ++s) {
      stores_[behind[s]].push_back(s);
      std::vector<Point>& points = of_[phase.stores[s].value];
      const Point at = 2 * behind[s] + 1;
      points.insert(std::upper_bound(points.begin(), points.end(), at), at);
    }
  }

  // The first use of a value at `from` or later.
  [[nodiscard]] Point next(std::uint32_t value, Point from) {
    const std::vector<Point>& points = of_[value];
    std::size_t& k = next_[value];
    while (k > 0 && points[k - 1] >= from) --k;
    while (k < points.size() && points[k] < from) ++k;
    return k < points.size() ? points[k] : kNever;
  }
  // True if another store follows to the same slot.
  [[nodiscard]] bool is_replaced(std::size_t store) const { return is_replaced_[store]; }
  // Indices of the stores behind instruction i.
  [[nodiscard]] const std::vector<std::size_t>& stores_behind(std::uint32_t i) const { return stores_[i]; }

 private:
  std::vector<std::vector<Point>> of_;  // ascending
  std::vector<std::size_t> next_;
  std::vector<std::vector<std::size_t>> stores_;
  std::vector<bool> is_replaced_;
};

}  // namespace assur
