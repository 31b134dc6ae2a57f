// Strategies: ways to solve a scene. Each one has a text form, which parse_strategy() and to_string() convert:
//   formulation/backend[:W][+float][+refine][+reuse=step|run][+once|+separate][+together][+predict=PREDICTOR]
//   [+chunks=C] [PxQ]
// with W = 1, 2, 4, 8 or 16 and PREDICTOR = taylor:0..2 | hermite:5 | past:0..5,
// e.g. "irreducible/klu+once+predict=hermite:5". docs/strategies.md explains each part.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace assur {

// The systems that the equations of a scene are divided into.
enum class Formulation : std::uint8_t {
  global,       // one system
  groups,       // the groups that the scene declares, and irreducible groups elsewhere
  irreducible,  // irreducible groups, after unknowns were eliminated by linear equations
};

// The matrices that one factorisation serves.
enum class Reuse : std::uint8_t {
  fresh,  // one: each Newton iteration factorises its own Jacobian
  step,   // all Newton iterations of a step use the first factorisation, as long as corrections contract
  run,    // later steps use it, too, as long as corrections contract
};

// Extrapolation of the posture to the next time, where Newton's method starts.
struct Predictor {
  // Formula of the extrapolation.
  enum class Kind : std::uint8_t {
    automatic,  // prepare() chooses one of the others by the derivatives that the outputs need
    taylor,     // q + dt q' + dt^2/2 q'', up to `order`
    hermite,    // quintic Hermite polynomial through q, q', q'' of the last two postures
    past,       // polynomial of degree `order` through the last order + 1 postures; needs no derivatives
  };
  Kind kind = Kind::automatic;  // formula
  std::int32_t order = 0;       // taylor: 0 to 2, hermite: 5, past: 0 to 5

  friend bool operator==(const Predictor&, const Predictor&) = default;
};

// Settings for the linear systems of a class.
struct SolverSettings {
  std::string backend = "eigen";  // Backend::id
  std::int32_t lanes = 1;         // W: largest number of groups of the class that are solved side by side
  bool single = false;            // +float: factorise in float, refine in double, fall back to double if that fails
  bool refine = false;            // +refine: refine each solution until its backward error is a few epsilons
  Reuse reuse = Reuse::fresh;     // +reuse: the matrices that one factorisation serves
  bool once = false;              // +once: one factorisation per step, at the predicted posture
  bool separate = false;          // +separate: another factorisation for accelerations, to repeat published experiments
  // Q: threads within the linear algebra of a pack, up to W groups in SIMD lanes; changes the last bits of the motion
  std::int32_t threads = 1;

  friend bool operator==(const SolverSettings&, const SolverSettings&) = default;
};

// Settings for all groups of a run.
struct RunSettings {
  Formulation formulation = Formulation::groups;  // division of the equations into systems
  // +together: the groups of all levels are linearised and factorised side by side, and only their coupling runs
  // through the levels; changes the last bits of the motion
  bool together = false;
  Predictor predictor = {};  // extrapolation to the next time
  std::int32_t chunks = 1;   // C: pieces of the time grid that run side by side; changes the last bits of the motion
  std::int32_t threads = 1;  // P: packs that are solved at once; changes no bit of the motion, if C is the same

  friend bool operator==(const RunSettings&, const RunSettings&) = default;
};

// A way to solve a scene.
struct Strategy {
  RunSettings run;        // for all groups
  SolverSettings solver;  // for all classes, unless the plan has a solver of its own for each class

  friend bool operator==(const Strategy&, const Strategy&) = default;
};

// Reads the text form; the formulation and the backend are required. Throws Error (input) that shows the grammar and
// the part that does not fit. Whether the backend exists is checked by prepare().
[[nodiscard]] Strategy parse_strategy(std::string_view text);

// The shortest text that parses to `strategy`.
[[nodiscard]] std::string to_string(const Strategy& strategy);

// Name of a formulation in strategy texts, e.g. "irreducible".
[[nodiscard]] std::string_view name(Formulation formulation) noexcept;

}  // namespace assur
