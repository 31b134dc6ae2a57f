// Estimates the errors of a posture to first order. Probes carry the residual of every equation, and perturbations as
// large as rounding with random signs, through the groups in solving order to the outputs. A few probes estimate the
// size of the error as well as a norm of the whole map would; each probe costs one more right-hand side (small-sample
// condition estimation: Kenney and Laub, SIAM J. Sci. Comput. 15, 1994).
// If an accuracy is required, the same number of further probes gives the error for a unit relative residual in any
// equation. The residual of a single posture cannot give this error, because the residual may be in an equation that no
// output depends on.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "assur/report.hpp"
#include "drivers/inputs.hpp"
#include "errors/static_errors.hpp"
#include "groups/pack_kernels.hpp"
#include "motion/layout.hpp"
#include "motion/levels.hpp"
#include "outputs/output_program.hpp"
#include "outputs/output_steps.hpp"

namespace assur {

// Estimates of one run, or of the runs in the lanes of a tile.
class ErrorEstimate {
 public:
  // Errors relative to the largest value of the run so far, defined like ErrorFigures::forward_position.
  struct Figures {
    double position = 0, velocity = 0, acceleration = 0;

    [[nodiscard]] double worst() const;
  };

  // outputs: of the mechanism, or of each mechanism in the lanes of a tile. All arguments must outlive the estimate.
  // accuracy: larger errors are in doubt; 0: errors larger than kDoubtfulError.
  ErrorEstimate(const GroupedSystem& structure, Layout& layout, std::span<const OutputProgram> outputs,
                double accuracy);

  // From now on differentiates the outputs of all lanes by step programs, which must outlive the estimate.
  void use(OutputSteps& steps) { output_steps_ = &steps; }

  // Saves the estimates. Allocates no memory if `into` holds a snapshot of the same plan.
  struct Snapshot;
  void save(Snapshot& into) const;
  // Returns to a snapshot. branch_checks: number of branch checks since it was saved.
  void restore(const Snapshot& from, std::int64_t branch_checks);

  // Begins a new run. systems: one for each mechanism, all of one structure; evaluated: their evaluated inputs; inputs:
  // null if all inputs follow their laws. All arguments must outlive the run.
  void restart(std::span<const System* const> systems, std::span<const Index> evaluated,
               const Inputs* inputs = nullptr);
  // Continues another run of the same outputs: takes over its largest errors and values. The next step is measured.
  void continue_from(ErrorEstimate& before);

  // True if a new measurement is due. Call it for every step with the time of each mechanism, the posture, its largest
  // residual, and the divisors of the measures (OutputProgram::evaluate), measures x mechanisms.
  [[nodiscard]] bool due(std::int64_t branch_checks, std::span<const double> times, const double* const (&state)[3],
                         double residual, const double* divisors);

  // Measures the errors of the current posture. times, rows: times and outputs of each mechanism; divisors: as above.
  // each(work) must call work(p, solver) for every pack, level after level. All figures are infinite if a matrix is
  // singular. The errors of the run do not include the measurement before keep(): the posture may be improved and
  // measured again.
  template <class Each>
  void measure(std::span<const double> times, const double* const (&state)[3], std::span<const double* const> rows,
               const double* divisors, const Each& each) {
    (void)measure(times, state, rows, divisors, each, [] { return false; });
  }
  // The same with a deadline: late() is called before each pack. If it is true, nothing is measured, due() remains
  // true, and the result is false.
  template <class Each, class Late>
  [[nodiscard]] bool measure(std::span<const double> times, const double* const (&state)[3],
                             std::span<const double* const> rows, const double* divisors, const Each& each,
                             const Late& late) {
    begin(times, state);
    std::atomic<bool> ends = false;
    Unseen unseen = of_other_steps();
    bool again = false;
    do {
      each([&](std::size_t p, GroupSolver& solver) {
        if (ends || late()) {
          ends = true;
          return;
        }
        const ChangePointPosture& posture = layout_.change_points[p];
        if (posture.exists()) solver.perturb(layout_.packs[p], posture, state, probes(), seed_);
        regular_[p] = posture.exists() || solver.perturb(layout_.packs[p], state, probes(), unseen, seed_) ? 1 : 0;
      });
      if (ends) {
        steps_ = interval_;
        --measurements_;
        return false;
      }
      finish(state, rows);
      again = !again && find_contradictions(unseen);
    } while (again);
    for (std::size_t i = 0; i < used_; ++i) watch_divisors(i, divisors);
    return true;
  }

  // Includes the measurement in the errors of the run. Set the status of the step by in_doubt() afterwards.
  void keep();

  // The largest relative residual for which, by the last measurement, errors are not larger than `error`. Infinite if
  // no residual matters; 0 if unknown, because no accuracy is required or because the accuracy is missed.
  [[nodiscard]] double residual_for(double error) const { return knows_gain_ ? error / gain_ : 0; }
  // loose: until the next measurement, equations are solved to a larger residual.
  void loosen(bool loose) { loose_ = loose; }
  // False for a while after measurements of loose steps came so often that exact ones would have taken less time.
  [[nodiscard]] bool may_loosen() const { return exact_ == 0; }
  // Passes the largest relative residual of a mechanism's redundant equations to the next measurement. If the residual
  // exceeds the errors of the posture, numbers of the scene contradict each other by so much; any equation may have it.
  void contradict(std::size_t mechanism, double residual) { mechanisms_[mechanism].redundant = residual; }

  // True if errors were measured since restart(), and if anything is driven or solved.
  [[nodiscard]] bool measured() const {
    return measurements_ > 0 && !(driven_.empty() && static_.coordinates().empty() && layout_.packs.empty());
  }
  // The residual to which equations are solved while errors are in doubt; 0: as exactly as doubles allow. With an
  // accuracy it is kConverged, so that the run does not take more work than a run without.
  [[nodiscard]] double best() const { return best_; }
  // True if the last measured errors exceed the required accuracy. After a doubtful measurement the limit is half of
  // the accuracy, because errors may double between two measurements.
  [[nodiscard]] bool in_doubt(std::size_t mechanism) const {
    return mechanisms_[mechanism].now.worst() > mechanisms_[mechanism].limit;
  }
  [[nodiscard]] bool in_doubt() const {  // of any mechanism
    for (std::size_t i = 0; i < used_; ++i) {
      if (in_doubt(i)) return true;
    }
    return false;
  }
  // True if errors are in doubt, or would be if steps were solved less exactly.
  [[nodiscard]] bool close_to_doubt() const { return kClose * worst_ > asked_; }
  [[nodiscard]] const Figures& now(std::size_t mechanism = 0) const { return mechanisms_[mechanism].now; }
  // The largest errors of the run over its largest values.
  [[nodiscard]] ErrorFigures of_run(std::size_t mechanism = 0);
  // The pack and lane with the most uncertain unknowns.
  struct PackLane {
    std::size_t pack = 0;
    std::int32_t lane = 0;
  };
  [[nodiscard]] PackLane worst_of(std::size_t mechanism = 0) const { return mechanisms_[mechanism].worst; }
  // Largest error of a coordinate, internal units.
  [[nodiscard]] double of_coordinate(std::size_t address) const;

 private:
  static constexpr std::size_t kRandom = 5;  // probes of one cause with random signs
  static constexpr double kClose = 16;       // (kConverged / residual of rounding) * growth of conditions
  static constexpr double kGrownTwice = 2;   // growth of a condition or a residual that asks for a new measurement
  static constexpr std::int64_t kStepsBetween = 512;  // steps between measurements; a choice: one costs as much as 25
  struct Size {                                       // figures of an output, or of one of its derivatives
    double value = 0, error = 0;
    double gain = 0;  // error for a unit relative residual of any equation
  };
  struct Mechanism {
    std::vector<double> unit;              // outputs: SI value of an internal unit
    std::array<double, 3> scale{1, 0, 0};  // 1; fastest rate and largest acceleration of driven coordinates so far
    std::vector<Size> sizes, largest;      // sizes: of the current posture; largest: of the run
    std::vector<double> rounding;          // sizes: the part of the error with random signs
    Figures now;
    double limit = 0;  // larger errors are in doubt
    PackLane worst;
    double before = 0, step = 0;      // time of the last step, and its length, s
    double measured = 0, serves = 0;  // time of the last measurement, and how long its rounding of laws is valid, s
    double redundant = 0;             // residual of the redundant equations
    std::vector<Jet<double>> laws;    // bounds of the rounding of the evaluated laws, internal units
  };
  // The last measurement is valid within these bounds; the lanes of a number are side by side.
  struct Watched {
    std::vector<double> least, most;         // divisors of the measures
    std::vector<double> smallest;            // of these divisors at all measurements
    std::vector<double> rate, acceleration;  // driven_: largest ones
  };
  void begin(std::span<const double> times, const double* const (&state)[3]);
  [[nodiscard]] Probes probes() const { return Probes(probes_).first(knows_gain_ ? probes_.size() : 1 + kRandom); }
  void perturb_static(const double* state);
  void find_rounding_of_laws(std::size_t mechanism, double t);
  void round_laws(const System& system, double t, bool now, std::vector<Jet<double>>& bounds) const;
  [[nodiscard]] bool begins_at_rest(const Mechanism& m, const System& system) const;
  [[nodiscard]] bool has_grown(const Mechanism& m) const;
  void perturb_known(const double* const (&state)[3], const Probe& probe);
  void find_worst();
  [[nodiscard]] Unseen of_other_steps() const;
  [[nodiscard]] bool find_contradictions(Unseen& unseen) const;
  void finish(const double* const (&state)[3], std::span<const double* const> rows);
  void carry(const Probe& probe, const double* const (&state)[3]);
  [[nodiscard]] bool conditions_have_grown(std::int64_t branch_checks, double error);
  void keep_steps_between();
  [[nodiscard]] Figures relative(const Mechanism& m, const std::vector<Size>& sizes, double Size::*what) const;
  void watch_divisors(std::size_t mechanism, const double* divisors);
  [[nodiscard]] bool serves(const double* divisors) const;
  [[nodiscard]] bool is_faster(const double* const (&state)[3]) const;

  Layout& layout_;
  StaticErrors static_;
  std::span<const OutputProgram> outputs_;
  const PackKernels& kernels_;
  double asked_, best_;
  std::vector<std::int32_t> driven_;           // addresses of driven coordinates
  std::vector<std::int32_t> size_of_;          // columns: 3 * output + derivative
  std::vector<int> dimension_;                 // outputs: power of length
  std::vector<std::uint8_t> is_angle_;         // outputs
  std::array<bool, 3> wanted_{};               // true if an output needs values, rates, accelerations
  std::array<std::vector<double>, 3> memory_;  // errors of all probes, by derivative
  std::vector<Probe> probes_;                  // the first one carries the residuals
  OutputSteps* output_steps_ = nullptr;
  std::vector<double> slopes_;         // changes of the outputs along a probe: columns x lanes
  std::vector<Mechanism> mechanisms_;  // lanes
  Watched watched_;
  std::vector<const System*> systems_;  // systems of the used mechanisms
  std::span<const Index> evaluated_;    // inputs
  const Inputs* inputs_ = nullptr;
  std::vector<Jet<double>> ahead_;     // like Mechanism::laws, at a later time
  bool static_known_ = true;           // the probes hold the errors of static coordinates
  std::size_t used_ = 0;               // number of used mechanisms
  std::vector<double> omega_;          // omega of the blocks of all packs at the last measurement
  std::vector<std::uint8_t> regular_;  // packs
  double residual_ = 0;                // the largest residual of a measured step
  std::int64_t branch_checks_ = 0;
  std::int64_t steps_ = 0, interval_ = 0;
  std::int64_t measurements_ = 0;
  std::uint64_t seed_ = 0;
  double worst_ = 0;  // largest error of all mechanisms at the last measurement
  bool knows_gain_ = false;
  double gain_ = 0;  // largest error of all mechanisms for a unit relative residual
  double left_ = 0;  // largest residual of the steps since the last measurement
  bool loose_ = false;
  std::int64_t exact_ = 0, patience_ = 0;  // measurements until steps may be loose again, and the last such number
};

struct ErrorEstimate::Snapshot {
  std::vector<Mechanism> mechanisms;
  Watched watched;
  std::vector<double> omega;
  double residual = 0, worst = 0, gain = 0, left = 0;
  bool knows_gain = false, loose = false;
  std::int64_t branch_checks = 0, steps = 0, interval = 0, measurements = 0, exact = 0, patience = 0;
  std::uint64_t seed = 0;
};

// Adds a doubtful step to the events of a run. Consecutive steps become one event with the worst of their figures.
void record_doubt(std::vector<Event>& events, Event event);

}  // namespace assur
