// The motion between the ends of a step. A law may leave its chord there by its bow e = h^2/8 max|u''|: a step whose
// ends agree may hide a whole period. To first order the unknowns follow the bows as they follow changes of the laws:
// J dq = -Phi_h dh. Up to five probes carry the bows through the levels, one law each; further laws share probes with
// random signs. The unknowns of a block then leave their way by at most E = sum |probe|. The way stays in the ball of
// the branch (groups/branch.hpp) if omega E <= f^2, where f is the part of the ball that a step leaves free; the square
// allows for the growth of the Jacobian's inverse within the ball. A longer step must be divided.
//
// The probes are measured at an accepted posture. Steps far from the limit use them until all anchors have changed,
// other steps until the next anchor. On an even grid with harmonic laws an ordinary step costs a few comparisons, and
// linear laws cost nothing.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "evaluation/lane_array.hpp"
#include "motion/layout.hpp"

namespace assur {

// The bows of one mechanism, or of the mechanisms in the lanes of a tile.
class Bows {
 public:
  // laws: number of laws that may leave their chords; 0: no memory is needed. layout must outlive this object.
  void resize(Layout& layout, std::size_t laws, std::size_t mechanisms);

  // Forgets the probes.
  void clear() { measured_.at = -1; }
  // To be called when a step begins. A step close to its limit measures its own probes, so that its division does not
  // depend on earlier steps.
  void begin_step() { is_fresh_ = false; }
  // The next step close to its limit must measure new probes; other steps need none.
  void doubt() { measured_.doubted = true; }

  // Takes the bows of a mechanism's laws on a step. False if all laws follow their chords.
  bool take(std::span<const double> bows, std::size_t mechanism = 0);
  // After take(): true if the probes are valid for this step.
  [[nodiscard]] bool serve(std::int64_t branch_checks);

  // After take(): measures the probes at the accepted posture `state`. known(m, p, rates): writes the known coordinates
  // of mechanism m that follow from these rates of its laws to probe p. each(work): calls work(pack, solver) for every
  // pack, level after level.
  template <class Known, class Each>
  void measure(const double* state, std::int64_t branch_checks, const Known& known, const Each& each) {
    begin();
    for (std::size_t m = 0; m < mechanisms_; ++m) {
      for (std::size_t p = 0; p < probes_.size(); ++p) known(m, probes_[p], share(m, p));
    }
    each([&](std::size_t p, GroupSolver& solver) {
      regular_[p] = solver.follow(layout_->packs[p], state, probes_) ? 1 : 0;
    });
    finish(branch_checks);
  }

  // Length of the step over the largest allowed one, by the balls of the branch; its square if that is less than 1.
  [[nodiscard]] double part(std::size_t mechanism = 0) const;
  // Factor of the probes for the step of take(): 0 if no law leaves its chord.
  [[nodiscard]] double times(std::size_t mechanism = 0) const { return mechanisms_ == 0 ? 0 : times_[mechanism]; }
  // After measure(): changes of all coordinates, and the sum of their sizes, in the layout of the state.
  [[nodiscard]] std::span<double* const> probes() const { return probes_; }
  [[nodiscard]] const LaneArray& sizes() const { return sizes_; }

  // Figures of the last measurement.
  struct Measured {
    std::int64_t at = -1;               // number of branch checks, in a snapshot since then; -1: nothing is measured
    std::vector<double> weights, part;  // mechanisms x laws: their bows; mechanisms: square of part()
    std::vector<double> omega;          // of all blocks
    bool doubted = false;
  };
  void save(Measured& into, std::int64_t branch_checks) const {
    into = measured_;
    if (measured_.at >= 0) into.at = branch_checks - measured_.at;
  }
  void restore(const Measured& from, std::int64_t branch_checks) {
    measured_ = from;
    if (from.at >= 0) measured_.at = branch_checks - from.at;
    checked_ = -1;
    is_fresh_ = false;
  }

 private:
  static constexpr std::size_t kProbes = 5;  // as those of the error estimate (ErrorEstimate::kRandom)

  void begin();
  [[nodiscard]] std::span<const double> share(std::size_t mechanism, std::size_t probe);
  void finish(std::int64_t branch_checks);
  [[nodiscard]] bool conditions_have_grown() const;

  Layout* layout_ = nullptr;
  std::size_t laws_ = 0, mechanisms_ = 0;
  std::vector<double> bows_, times_, rates_;  // mechanisms x laws; mechanisms; laws
  std::vector<LaneArray> memory_;
  std::vector<double*> all_probes_;
  std::span<double* const> probes_;
  LaneArray sizes_;
  std::vector<std::uint8_t> regular_;  // packs
  Measured measured_;
  std::int64_t checked_ = -1;  // branch checks for which the probes are known to be valid
  bool is_fresh_ = false;      // measured in the current step
};

}  // namespace assur
