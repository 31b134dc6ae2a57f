// A strategy is a value with a text form that round-trips:
//   formulation/backend[:W][+float][+refine][+reuse=step|run][+once|+separate][+predict=PREDICTOR][+chunks=C] [PxQ]
// with W = 1, 2, 4, 8 or 16 and PREDICTOR = taylor:0..2 | hermite:5 | past:0..5,
// e.g. "irreducible/klu+once+predict=hermite:5".
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace assur {

enum class Formulation : std::uint8_t { global, groups, irreducible };

enum class Reuse : std::uint8_t { fresh, step, run };

struct Predictor {
  enum class Kind : std::uint8_t {
    automatic,  // chosen from the derivatives that are computed anyway
    taylor,     // q + dt q' + dt^2/2 q'', up to `order`
    hermite,    // two-step quintic Hermite on q, q', q'' (order is always 5)
    past,       // polynomial of degree `order` through the last order + 1 postures; needs no derivatives
  };
  Kind kind = Kind::automatic;
  std::int32_t order = 0;

  friend bool operator==(const Predictor&, const Predictor&) = default;
};

// How the systems of a group, or of W groups of one class side by side, are solved.
struct SolverSettings {
  std::string backend = "eigen";
  std::int32_t lanes = 1;  // W, instances of a class solved side by side (up to)
  bool single = false;     // +float
  bool refine = false;     // +refine
  Reuse reuse = Reuse::fresh;
  bool once = false;         // one factorisation per step, taken at the prediction
  bool separate = false;     // one more for the acceleration, which nothing needs: to repeat published experiments
  std::int32_t threads = 1;  // Q, inside the linear algebra of each pack; changes the last bits of the motion

  friend bool operator==(const SolverSettings&, const SolverSettings&) = default;
};

// What all groups of a run have in common.
struct RunSettings {
  Formulation formulation = Formulation::groups;
  Predictor predictor;
  std::int32_t chunks = 1;   // of the time grid, run side by side; they change the last bits of the motion
  std::int32_t threads = 1;  // P, packs at once; changes no bit of the motion

  friend bool operator==(const RunSettings&, const RunSettings&) = default;
};

struct Strategy {
  RunSettings run;
  SolverSettings solver;

  friend bool operator==(const Strategy&, const Strategy&) = default;
};

// Throws Error (input) that shows the grammar and the part that does not fit.
[[nodiscard]] Strategy parse_strategy(std::string_view text);

// The shortest text that parses to `strategy`.
[[nodiscard]] std::string to_string(const Strategy& strategy);

[[nodiscard]] std::string_view name(Formulation formulation) noexcept;

}  // namespace assur
