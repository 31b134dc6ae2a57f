// Freedoms of drivers: the motions that their inputs can make, independent of the laws.
#pragma once

#include <span>
#include <vector>

#include "equations/system.hpp"

namespace assur {

// The freedoms of several inputs.
class Freedoms {
 public:
  // inputs: indices into System::inputs. A scalar or an angle has one freedom, a frame its translations and rotations.
  Freedoms(const System& system, std::vector<Index> inputs);

  [[nodiscard]] std::size_t count() const { return ways_.size(); }

  // Rates of all coordinates at the posture q if one freedom moves at the rate 1: rates of inputs and of assigned
  // coordinates.
  [[nodiscard]] std::vector<double> rates(std::size_t freedom, std::span<const double> q) const;

  // Moves the inputs by these amounts, rad or internal units, and updates assigned coordinates.
  void move(std::span<const double> amounts, std::vector<double>& q) const;

 private:
  // A freedom of one input: a translation along an axis (scalar, frame) or a rotation about an axis.
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
