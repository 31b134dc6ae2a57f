// Deviation of the outputs of a run from a closed form in quad.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <unordered_map>

#include "references/quad.hpp"
#include "simulation/run.hpp"

namespace assur::test {

// Deviation of a trajectory from a reference, for value, rate and acceleration: for every name the largest difference
// of the run, divided by the largest reference value of the run (lengths: at least `length`), in maximum norms.
class Deviation {
 public:
  explicit Deviation(const Trajectory& trajectory, double length = 0) : trajectory_(trajectory), length_(length) {
    for (std::size_t i = 0; i < trajectory.columns().size(); ++i) column_.emplace(trajectory.columns()[i], i);
  }

  void add(std::size_t row, const std::string& point, const references::Vec<references::QuadJet>& reference) {
    Item& item = items_[point];
    for (std::size_t i = 0; i < 3 && column_.contains(point + "." + "xyz"[i]); ++i) {
      const std::string axis(1, "xyz"[i]);
      compare(row, item, 0, point + "." + axis, reference[i].value);
      compare(row, item, 1, point + ".v" + axis, reference[i].rate);
      compare(row, item, 2, point + ".a" + axis, reference[i].acceleration);
    }
    item.floor = length_;
  }
  void add(std::size_t row, const std::string& scalar, const references::QuadJet& reference) {
    Item& item = items_[scalar];
    compare(row, item, 0, scalar, reference.value);
    compare(row, item, 1, scalar + ".rate", reference.rate);
    compare(row, item, 2, scalar + ".acceleration", reference.acceleration);
  }

  // The largest deviation of all names; infinite if nothing was compared.
  [[nodiscard]] Motion worst() const {
    double worst[3] = {};
    std::size_t compared = 0;
    for (const auto& [name, item] : items_) {
      compared += item.compared;
      for (std::size_t d = 0; d < 3; ++d) {
        const double largest = std::max(item.largest[d], d == 0 ? item.floor : 0.0);
        const double relative = largest > 0 ? item.difference[d] / largest : item.difference[d];
        if (!(relative <= worst[d])) worst[d] = relative;
      }
    }
    if (compared == 0) worst[0] = std::numeric_limits<double>::infinity();
    return {worst[0], worst[1], worst[2]};
  }

 private:
  struct Item {
    double difference[3] = {}, largest[3] = {}, floor = 0;
    std::size_t compared = 0;
  };

  void compare(std::size_t row, Item& item, std::size_t derivative, const std::string& name,
               const references::Quad& reference) {
    const auto found = column_.find(name);
    if (found == column_.end()) return;
    const double off = std::abs(static_cast<double>(trajectory_(row, found->second) - reference));
    if (!(off <= item.difference[derivative])) item.difference[derivative] = off;
    item.largest[derivative] = std::max(item.largest[derivative], std::abs(static_cast<double>(reference)));
    ++item.compared;
  }

  const Trajectory& trajectory_;
  double length_;
  std::unordered_map<std::string, std::size_t> column_;
  std::unordered_map<std::string, Item> items_;
};

}  // namespace assur::test
