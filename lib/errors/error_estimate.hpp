// How wrong a posture is, to first order: what was left in every equation, and perturbations of random sign as large as
// its rounding, are carried through the groups in solving order and on to the outputs. A few such probes tell the size
// of the error as a norm of the whole map would, at the price of as many more right-hand sides (small-sample condition
// estimation: Kenney and Laub, SIAM J. Sci. Comput. 15, 1994).
//
// Where an accuracy is asked for, as many probes more tell how large an error is for each relative residual of any
// equation. What is left at one posture does not tell that: it may be in an equation that no output feels.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "assur/report.hpp"
#include "errors/static_errors.hpp"
#include "path/layout.hpp"
#include "path/levels.hpp"
#include "signals/output_program.hpp"

namespace assur {

class ErrorEstimate {
 public:
  // Relative to the largest value of the run so far, as ErrorFigures::forward_*.
  struct Figures {
    double position = 0, velocity = 0, acceleration = 0;

    [[nodiscard]] double worst() const;
  };

  // outputs: of the mechanism, or of those in the lanes of a tile, one next to the other. Both must outlive it.
  // accuracy: errors up to here are not in doubt; 0: up to kDoubtfulError.
  ErrorEstimate(const Structure& structure, Layout& layout, std::span<const OutputProgram> outputs, double accuracy);

  // What is known of the errors so far. Takes no memory once `into` has been taken from the same plan.
  struct Snapshot;
  void save(Snapshot& into) const;
  // branch_checks: as many as were done since it was saved.
  void restore(const Snapshot& from, std::int64_t branch_checks);

  // Systems of one structure, one for each mechanism; they must outlive what is measured next.
  void restart(std::span<const System* const> systems);
  // The run goes on from another one's of the same outputs: the largest errors and values so far are those of both. The
  // next step is measured.
  void continue_from(ErrorEstimate& before);

  // Is what was measured last out of date? Tell it of every step, of the posture, of the largest residual that it left,
  // and of what the measures of each mechanism divide by (OutputProgram::evaluate).
  [[nodiscard]] bool due(std::int64_t branch_checks, const double* const (&state)[3], double residual,
                         std::span<const double* const> divisors);

  // At the posture at hand; times, rows, divisors: of each mechanism, with its outputs. each(work) calls work(p,
  // solver) for every pack, level after level. All figures are infinite where a matrix is singular. It is of the run
  // only once it is kept: the posture may be improved and measured again first.
  template <class Each>
  void measure(std::span<const double> times, const double* const (&state)[3], std::span<const double* const> rows,
               std::span<const double* const> divisors, const Each& each) {
    begin(times, state);
    each([&](std::size_t p, GroupSolver& solver) {
      regular_[p] = solver.perturb(layout_.packs[p], state, probes(), seed_) ? 1 : 0;
    });
    finish(state, rows);
    for (std::size_t i = 0; i < used_; ++i) watch_divisors(mechanisms_[i], divisors[i]);
  }

  // What was measured is an error of the run. The status of its step has to follow in_doubt().
  void keep();

  // The largest relative residual of an equation with which errors are surely not larger than this, as far as was
  // measured; infinite if none matters, 0 if that is not known: without an accuracy asked for, or while it is missed.
  [[nodiscard]] double residual_for(double error) const { return knows_gain_ ? error / gain_ : 0; }
  // Until the next measurement equations are solved only as well as that.
  void loosen(bool loose) { loose_ = loose; }

  // Since restart(), if anything was solved.
  [[nodiscard]] bool measured() const {
    return measurements_ > 0 && !(driven_.empty() && static_.coordinates().empty());
  }
  // The residual up to which equations are solved where errors are in doubt; 0: as exactly as doubles allow. Who asks
  // for an accuracy does not pay more for it than who asks for nothing.
  [[nodiscard]] double best() const { return best_; }
  // When it was measured last, errors were larger than was asked for, or, where they had been before, than half of
  // that: from one measurement to the next they may double.
  [[nodiscard]] bool in_doubt(std::size_t mechanism) const {
    return mechanisms_[mechanism].now.worst() > mechanisms_[mechanism].limit;
  }
  [[nodiscard]] bool in_doubt() const {  // one of them
    for (std::size_t i = 0; i < used_; ++i) {
      if (in_doubt(i)) return true;
    }
    return false;
  }
  // Or not far from it: steps that are solved less well may be.
  [[nodiscard]] bool close_to_doubt() const { return kClose * worst_ > asked_; }
  [[nodiscard]] const Figures& now(std::size_t mechanism = 0) const { return mechanisms_[mechanism].now; }
  // Of the whole run: the largest errors over the largest values. Not in doubt as long as no step was.
  [[nodiscard]] ErrorFigures of_run(std::size_t mechanism = 0);
  // The pack whose unknowns are the most uncertain, and the lane.
  struct Place {
    std::size_t pack = 0;
    std::int32_t lane = 0;
  };
  [[nodiscard]] Place worst_of(std::size_t mechanism = 0) const { return mechanisms_[mechanism].worst; }
  // Largest error of a coordinate, internal units.
  [[nodiscard]] double of_coordinate(std::size_t address) const;

 private:
  static constexpr std::size_t kRandom = 5;  // probes of one cause with random signs
  static constexpr double kClose = 16;       // kConverged over what rounding leaves, and what conditions may grow by
  struct Size {                              // of an output, or of one of its derivatives
    double value = 0, error = 0;
    double gain = 0;  // error for each relative residual of any equation
  };
  struct Mechanism {
    std::vector<double> unit;              // outputs: SI units in an internal one
    std::array<double, 3> scale{1, 0, 0};  // fastest rate and largest acceleration of what drives, so far
    std::vector<Size> sizes, largest;      // now, and the largest of the run
    std::vector<double> rounding;          // sizes: the part of the error that has no sign
    Figures now;
    double limit = 0;  // beyond which they are in doubt
    Place worst;
    // Of what the measures divide by: the smallest that was measured, and between which the last measurement serves.
    std::vector<double> smallest, least, most;
    std::vector<double> fast;  // driven_: rates and accelerations beyond which the last measurements do not serve
  };
  void begin(std::span<const double> times, const double* const (&state)[3]);
  [[nodiscard]] Probes probes() const { return Probes(probes_).first(knows_gain_ ? probes_.size() : 1 + kRandom); }
  void perturb_static(const double* state);
  void perturb_known(std::span<const double> times, const double* const (&state)[3], const Probe& probe);
  void find_worst();
  void finish(const double* const (&state)[3], std::span<const double* const> rows);
  void carry(const Probe& probe, const double* const (&state)[3]);
  [[nodiscard]] bool conditions_have_grown(std::int64_t branch_checks, double error);
  void keep_steps_between();
  [[nodiscard]] Figures relative(const Mechanism& m, const std::vector<Size>& sizes, double Size::*what) const;
  void watch_divisors(Mechanism& m, const double* divisors) const;
  [[nodiscard]] static bool serves(const Mechanism& m, const double* divisors);
  [[nodiscard]] bool is_faster(const double* const (&state)[3]) const;

  Layout& layout_;
  StaticErrors static_;
  std::span<const OutputProgram> outputs_;
  double asked_, best_;
  std::vector<std::int32_t> driven_;           // addresses of what drives
  std::vector<std::int32_t> size_of_;          // columns: 3 * output + derivative
  std::vector<int> dimension_;                 // outputs: power of a length
  std::array<bool, 3> wanted_{};               // by some output: its value, rate, acceleration
  std::array<std::vector<double>, 3> memory_;  // of all probes, by derivative
  std::vector<Probe> probes_;                  // the first one: of what is left
  std::vector<double> slopes_;                 // of the outputs along a probe
  std::vector<Mechanism> mechanisms_;          // lanes
  std::vector<const System*> systems_;         // of those used
  bool static_known_ = true;                   // the probes hold the errors of what stands still
  std::size_t used_ = 0;                       // of them
  std::vector<double> omega_;                  // of all packs, when it was measured
  std::vector<std::uint8_t> regular_;          // packs
  double residual_ = 0;                        // the largest of a step that was measured
  std::int64_t branch_checks_ = 0;
  std::int64_t steps_ = 0, interval_ = 0;
  std::int64_t measurements_ = 0;
  std::uint64_t seed_ = 0;
  double worst_ = 0;  // of all mechanisms
  bool knows_gain_ = false;
  double gain_ = 0;  // the worst error of all mechanisms for each relative residual
  double left_ = 0;  // the largest residual of the steps since
  bool loose_ = false;
};

struct ErrorEstimate::Snapshot {
  std::vector<Mechanism> mechanisms;
  std::vector<double> omega;
  double residual = 0, worst = 0, gain = 0, left = 0;
  bool knows_gain = false, loose = false;
  std::int64_t branch_checks = 0, steps = 0, interval = 0, measurements = 0;
  std::uint64_t seed = 0;
};

// Adds what is in doubt to the events of a run: steps one after the other are one event, of the worst of them.
void record_doubt(std::vector<Event>& events, Event event);

}  // namespace assur
