// The cells of a tuning run: each one is a problem that all candidates solve; it is measured and stored as a whole.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "assur/performance.hpp"
#include "assur/scene.hpp"
#include "assur/strategy.hpp"
#include "measure/matrices.hpp"

namespace assur::tuning {

struct Cell {
  enum class Kind : std::uint8_t {
    matrix,    // factor and solve; for a class also evaluate
    packs,     // pack
    together,  // pack, by +together
    crowd,     // pack, while several threads do the same work
    steps,     // step
    around,    // step and its packs by a few strategies, which give Kernel::around
    meeting,   // meeting
  };
  Kind kind = Kind::matrix;
  std::string family;       // cells of one family differ in size only: "rings", "random", "stewart global", ...
  std::int32_t n = 0;       // unknowns, if they follow from the size
  std::int32_t groups = 1;  // of the class, on one level; together: on all levels
  bool held_out = false;    // measured to judge the model, which does not use it
  bool policies = false;    // packs: also with +once
  double weight = 1;        // share of the time
  std::function<Scene()> scene = nullptr;  // null: random matrices
  Formulation formulation = Formulation::groups;
  std::int32_t group_class = -1;                     // -1: the class with the most groups, then the most unknowns
  std::function<Cell(std::int32_t n)> at = nullptr;  // the cell of the family with another size; null: there is none
  int per_row = 0;                                   // random matrices: entries of a column
  std::vector<Strategy> only = {};                   // steps: only these strategies; empty: all that make sense
};

// "rings, n = 120", "stewart groups, 60 groups"
[[nodiscard]] std::string to_string(const Cell& cell);

struct Extent {
  int sizes = 14;                     // number of sizes n from 3 to the largest
  std::int32_t largest = 4000;        // unknowns, sparse
  std::int32_t largest_full = 800;    // unknowns, dense
  std::int32_t largest_random = 300;  // unknowns, random with few entries in a column; they have much fill
  std::int32_t most_groups = 10'000;
  std::int32_t most_unknowns = 60'000;  // largest groups x n of a cell of packs
  bool held_out = true;
};

// The default cells for a machine. Sizes ascend within each family.
[[nodiscard]] std::vector<Cell> general_cells(const Extent& extent);

// The cells for one scene: its classes in each formulation, and its steps. Throws Error like prepare(), and (input) if
// nothing moves.
[[nodiscard]] std::vector<Cell> scene_cells(const std::string& text, const Scene& scene);

// True if general_cells() holds out the cell of such a sample.
[[nodiscard]] bool is_held_out(Kernel kernel, const Shape& shape);

// Log-spaced whole numbers, both ends included.
[[nodiscard]] std::vector<std::int32_t> spaced(std::int32_t from, std::int32_t to, int count);

}  // namespace assur::tuning
