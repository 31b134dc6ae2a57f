// How wrong a posture is, to first order: what was left in every equation, and perturbations of random sign as large as
// its rounding, are carried through the groups in solving order and on to the outputs. A few such probes tell the size
// of the error as a norm of the whole map would, at the price of as many more right-hand sides (small-sample condition
// estimation: Kenney and Laub, SIAM J. Sci. Comput. 15, 1994).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "assur/report.hpp"
#include "simulation/layout.hpp"
#include "simulation/levels.hpp"
#include "simulation/output_program.hpp"

namespace assur {

class ErrorEstimate {
 public:
  // Relative to the largest value of the run so far, as ErrorFigures::forward_*.
  struct Figures {
    double position = 0, velocity = 0, acceleration = 0;

    [[nodiscard]] double worst() const;
  };

  ErrorEstimate(const System& system, const Layout& layout, const OutputProgram& outputs, double asked);

  // Is what was measured last out of date? Tell it of every step, and of the largest residual that it left.
  [[nodiscard]] bool due(std::span<const Pack> packs, std::int64_t branch_checks, double residual);

  // At the posture at hand; row: its outputs. All figures are infinite where a matrix is singular.
  void measure(double t, const double* const (&state)[3], std::span<Pack> packs, Levels& levels,
               std::span<const double> row);

  // Until the next measurement the errors may be as large as this where the conditions are as they were.
  void expect(double error) { expected_ = error; }

  void restart();

  // Since restart(), if anything moves.
  [[nodiscard]] bool measured() const { return seed_ > 0 && !driven_.empty(); }
  [[nodiscard]] double asked() const { return asked_; }
  [[nodiscard]] const Figures& now() const { return now_; }
  // Of the whole run: the largest errors over the largest values.
  [[nodiscard]] Figures of_run() const;
  // The pack whose unknowns are the most uncertain, and the lane.
  [[nodiscard]] std::size_t worst_pack() const { return worst_pack_; }
  [[nodiscard]] std::int32_t worst_lane() const { return worst_lane_; }
  // Largest error of a coordinate, internal units.
  [[nodiscard]] double of_coordinate(std::size_t address) const;

 private:
  struct Size {  // of an output, or of one of its derivatives
    double error = 0, value = 0;
  };
  void begin(double t, const double* const (&state)[3]);
  void perturb_known(double t, const double* const (&state)[3], std::size_t probe);
  void find_worst(std::span<const Pack> packs, Levels& levels);
  void finish(const double* const (&state)[3], std::span<const double> row, bool regular);
  [[nodiscard]] Figures relative(const std::vector<Size>& sizes) const;

  const OutputProgram& outputs_;
  double asked_;
  std::vector<std::int32_t> driven_;   // addresses of what drives
  std::vector<std::int32_t> size_of_;  // columns: 3 * output + derivative
  std::vector<double> unit_;           // outputs: SI units in an internal one
  std::size_t size_ = 0, first_unknown_ = 0;
  std::array<std::array<std::vector<double>, 3>, kProbes> probes_;  // by derivative, like the state
  std::array<std::vector<double>, 3> moved_;                        // the state, moved along a probe
  std::vector<double> moved_row_;
  std::array<double, 3> scale_{1, 0, 0};  // fastest rate and largest acceleration of what drives, so far
  std::vector<Size> sizes_, largest_;     // now, and the largest of the run
  std::vector<double> omega_;             // of all packs, when it was measured
  std::vector<std::uint8_t> regular_;     // packs
  double residual_ = 0;                   // the largest of a step that was measured
  std::int64_t branch_checks_ = 0;
  std::int64_t steps_ = 0, interval_ = 0;
  std::uint64_t seed_ = 0;
  Figures now_;
  double expected_ = 0;
  std::size_t worst_pack_ = 0;
  std::int32_t worst_lane_ = 0;
  bool in_doubt_ = false;
};

}  // namespace assur
