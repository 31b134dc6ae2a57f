// Quality of the independent set chosen among redundant equations. This set is solved, and the other equations are
// watched. As the mechanism moves, the set may come close to being dependent although all equations together are
// regular. The gradient of a watched equation is a combination sum c_i grad Phi_i of gradients of solved equations. If
// all gradients have length 1, the smallest singular value of the solved set is at least that of all equations over
// sqrt(1 + |C|^2). Another set is therefore better only if some |c_i| is large (Gu and Eisenstat, SIAM J. Sci. Comput.
// 17, 1996).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "equations/system.hpp"
#include "structure/grouped_system.hpp"

namespace assur {

// A set with larger coefficients is worth replacing. A newly chosen set has coefficients of at most 1.5
// (independent_rows.hpp).
inline constexpr double kPoorSet = 4;

// Coefficients of the watched equations.
class Independence {
 public:
  // `address`: coordinates -> index into the state arrays. All must outlive it.
  Independence(const System& system, const GroupedSystem& structure, std::span<const std::int32_t> address);
  ~Independence();

  // True if no equation is redundant, or if a block is too large to examine (more than 200 unknowns).
  [[nodiscard]] bool empty() const { return dropped_.empty(); }

  // Largest |c_i| of all watched equations at a posture; infinite if the solved equations are dependent there.
  [[nodiscard]] double largest_coefficient(const double* q);
  // The equations that a new choice among all of these, as in rank.cpp, watches at a posture, all coordinates. Empty if
  // there are not as many independent ones, or if they have more than 200 unknowns.
  [[nodiscard]] std::vector<Index> chosen_anew(std::span<const double> coordinates);

 private:
  struct Coefficient {
    Index coordinate;
    double value;
  };
  struct Gradient {
    Index equation;
    std::vector<Coefficient> entries = {};  // nonzeros
    double length = 0;                      // over the unknowns of the units; at least kLeastScale
    // Quadratic equations: an entry is the sum of value * coordinate over its slopes; the slopes of an entry are
    // consecutive.
    std::vector<Coefficient> slopes = {};
    std::vector<std::uint32_t> ends = {};  // entries: end of their range in slopes
  };
  struct Unit;  // equations and unknowns that are solved together: an irreducible block of a group
  void collect(const GroupedSystem& structure);
  void keep_those_behind();
  void reserve();
  void prepare(Gradient& row) const;
  void find_slopes(Gradient& row) const;
  [[nodiscard]] bool in_solving_order();
  void differentiate(Gradient& row);
  void differentiate_callback(Gradient& row);
  [[nodiscard]] bool factorize(Unit& unit);
  [[nodiscard]] double largest_of(Gradient& row);

  const System& system_;
  std::span<const std::int32_t> address_;
  std::vector<Unit> units_;  // in solving order
  std::vector<Gradient> dropped_;
  std::vector<Index> unit_of_, place_;      // coordinates: unit (-1: none), and column in the unit
  std::vector<double> q_, gradient_;        // coordinates
  std::vector<std::uint8_t> seen_;          // coordinates
  std::vector<double> arguments_, slopes_;  // of a callback
};

}  // namespace assur
