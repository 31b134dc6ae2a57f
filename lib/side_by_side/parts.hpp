// Independent parts of a mechanism: no group of one part reads an unknown of another part, and no output reads unknowns
// of two. A part can be prepared and run alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "assur/plan.hpp"
#include "scene/outputs.hpp"
#include "scene/system.hpp"

namespace assur {

// One part as a mechanism of its own, which runs on one thread.
struct Part {
  Prepared prepared;
  std::vector<Index> coordinates;  // its coordinates in the system of the whole mechanism
  struct Columns {
    std::size_t from, to, count;  // columns [from, from + count) are columns [to, to + count) of the whole
  };
  std::vector<Columns> columns;
};

// The parts of a mechanism. Connected components share a part up to a number of unknowns; the number of components is a
// multiple of the lanes, so that the packs stay full.
class Parts {
 public:
  // `whole` must outlive the parts. unknowns: wanted number for each part. There are no parts if `whole` is connected,
  // or if it has functions, limits, redundant equations, controlled drivers or unknowns that are solved once.
  Parts(const Prepared& whole, std::size_t unknowns);

  [[nodiscard]] std::size_t count() const { return contents_.size(); }
  [[nodiscard]] Part cut(std::size_t part);

 private:
  struct Contents {
    std::vector<std::int32_t> groups;
    std::vector<Index> items, measures;  // wanted ones
    std::vector<std::size_t> outputs;    // of System::outputs
    std::vector<Part::Columns> columns;
  };
  [[nodiscard]] Index component(Index coordinate);
  void join(Index a, Index b);
  template <class Use>
  void each_unknown(std::span<const Index> forms, const Use& use) const;
  [[nodiscard]] std::vector<Index> join_readings(std::span<const Output> outputs);
  void divide(std::size_t unknowns_of_part);
  [[nodiscard]] std::vector<std::int32_t> readers() const;
  [[nodiscard]] bool place(std::span<const Output> outputs, std::span<const Index> unknown_of);
  [[nodiscard]] std::vector<Index> needed_coordinates(const Contents& contents, std::vector<Index>& inputs,
                                                      std::vector<Index>& assignments) const;

  const Prepared& whole_;
  const Structure& structure_;
  const System& system_;
  std::vector<Index> joined_to_;    // coordinates: union-find
  std::vector<Index> maker_;        // coordinates: input i as i, assignment a as -2 - a; -1: neither
  std::vector<std::int32_t> part_;  // coordinates that stand for a component: its part
  std::vector<Contents> contents_;
  std::vector<Index> new_coordinate_, new_constant_, new_form_;  // of the part that is cut; -1: not in it
};

}  // namespace assur
