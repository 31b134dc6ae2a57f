// The freedoms of drivers: in which ways their inputs can move, whatever their laws say.
#pragma once

#include <span>
#include <vector>

#include "scene/system.hpp"

namespace assur {

class Freedoms {
 public:
  // Those of the listed inputs (indices into System::inputs): one for a scalar or an angle, the translations and
  // rotations of a frame.
  Freedoms(const System& system, std::vector<Index> inputs);

  [[nodiscard]] std::size_t count() const { return ways_.size(); }

  // Rates of all coordinates at the posture q if one of them moves at the rate 1: those of the inputs and of what is
  // assigned from them.
  [[nodiscard]] std::vector<double> rates(std::size_t freedom, std::span<const double> q) const;

  // Moves the inputs by these amounts, rad or internal units, and all that is assigned from them.
  void move(std::span<const double> amounts, std::vector<double>& q) const;

 private:
  // Of one input: along an axis (scalar and frame) or about one.
  struct Way {
    Index input;
    int axis;
    bool turns;
  };
  const System& s_;
  std::vector<Way> ways_;
};

// Freedoms of one input.
[[nodiscard]] int freedoms_of(const System& system, const DriverInput& input);

}  // namespace assur
