// Group classes: equations in local numbers, shared by all groups that differ in values only.
#pragma once

#include <unordered_map>
#include <utility>
#include <vector>

#include "equations/system.hpp"
#include "structure/grouped_system.hpp"
#include "structure/write_class.hpp"

namespace assur {

// The data of a group that determine its class.
struct GroupContent {
  std::vector<Index> unknowns;  // in solving order; first those that are not needed in the highest derivative
  std::vector<Index> equations;
  Index blocks = 1;
  std::vector<Index> unknown_block, equation_block;
  Index derivatives = 2;
  Index first_wanted = 0;
};

// Finds equal classes.
class ClassTable {
 public:
  // `moves`: coordinates, 0 if the value never changes.
  ClassTable(const System& system, const std::vector<std::uint8_t>& moves);

  // Finds or adds the class of a group and fills group.group_class, unknowns, equations, inputs, constants.
  void classify(const GroupContent& content, SolvedGroup& group);

  [[nodiscard]] std::vector<GroupClass> take() { return std::move(classes_); }

 private:
  // The first callback that is a gear with the same numbers; else the callback itself.
  [[nodiscard]] Index first_like(Index callback);

  const System& system_;
  const std::vector<std::uint8_t>& moves_;
  std::vector<Index> local_coordinate_;  // scratch: coordinates, -2: not in this group
  std::vector<LocalEquations> written_;  // of the classes
  std::vector<GroupClass> classes_;
  std::unordered_multimap<std::size_t, Index> by_hash_;
  std::vector<std::pair<GroupClass::Gear, Index>> gears_;  // different ones, and their callbacks
};

}  // namespace assur
