// The simulator: runs a plan, and owns all memory that this needs. After construction, step(), set(), output() and
// outputs() allocate no memory, take no lock and read no file, if the backends are marked `steady`, also if the step
// fails. Exceptions are steps that choose redundant equations or pivots anew (docs/control.md). step() throws only what
// laws and callbacks throw.
#pragma once

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "assur/jacobian.hpp"
#include "assur/law.hpp"
#include "assur/plan.hpp"
#include "assur/report.hpp"
#include "assur/rows.hpp"
#include "assur/step_settings.hpp"

namespace assur {

// Results of a run in SI units, contiguous [time][output]. Indices of rows and columns are not checked.
class Trajectory {
 public:
  // Names of the outputs: "C.x", "C.vx", "angle.rate", ... (docs/scenes.md lists all kinds)
  [[nodiscard]] const std::vector<std::string>& columns() const { return columns_; }
  // Times of the rows, s.
  [[nodiscard]] const std::vector<double>& times() const { return times_; }
  // Number of rows: the times that the run reached.
  [[nodiscard]] std::size_t rows() const { return times_.size(); }
  // Index of a column. Throws Error (input), with a list of the columns, if there is no such name.
  [[nodiscard]] std::size_t index(std::string_view column) const;
  // All outputs at times()[k].
  [[nodiscard]] std::span<const double> row(std::size_t k) const {
    return {values_.data() + k * columns_.size(), columns_.size()};
  }
  // One output at times()[row].
  [[nodiscard]] double operator()(std::size_t row, std::size_t column) const {
    return values_[row * columns_.size() + column];
  }
  // One output in the last row, by its name. Throws like index(), and Error (input) if the trajectory has no row.
  [[nodiscard]] double last(std::string_view column) const;
  // A copy of one output over all rows, by its name. Throws like index().
  [[nodiscard]] std::vector<double> column(std::string_view column) const;
  // All values: rows x columns.
  [[nodiscard]] const RowValues& values() const { return values_; }

 private:
  friend class Simulator;
  std::vector<std::string> columns_;
  std::vector<double> times_;
  RowValues values_;
};

// Writes a CSV with the columns `t` and all outputs. Each number is the shortest text that reads back as the same
// double; NaN is empty. If writing fails, the state of `out` says so.
void write_csv(std::ostream& out, const Trajectory& trajectory);

// Rows and numbers of write_npy().
struct NpyOptions {
  std::size_t every = 1;  // every n-th row, beginning with the first; at least 1
  bool single = false;    // true: in single precision
};

// Writes NumPy's format .npy (version 1.0, or 2.0 for very many columns): a structured array with one entry for each
// row, and the fields `t` and all outputs, so that numpy.load(file)["C.x"] is a column. Failures as in write_csv().
// Throws Error (input) for `every` = 0.
void write_npy(std::ostream& out, const Trajectory& trajectory, const NpyOptions& options = {});

// Accuracy of one group at a posture.
struct GroupFigures {
  std::int32_t group = 0;  // index into Structure::groups()
  double residual = 0;     // max over i of |Phi_i| / s_i with s_i = sum_j |dPhi_i/dq_j| |q_j| + |constant|
  // Factor by which the error of an unknown may exceed the residual: the maximum norm of |J^-1| s, relative to the
  // characteristic length.
  double condition = 0;
  double estimated_error = 0;  // of the unknowns, relative to the characteristic length; includes errors of the inputs
};

// Saved state of a simulator, which determines its next steps: posture, rates, older postures for the prediction, turns
// of angles, values that drivers were set to, targets that wait for the next step, the chosen set of redundant
// equations, and error estimates. A state may outlive its simulator.
class SimulatorState {
 public:
  SimulatorState();                                            // empty: Simulator::restore() refuses it
  SimulatorState(const SimulatorState& other);                 // copies the state
  SimulatorState(SimulatorState&& other) noexcept;             // `other` is then empty
  SimulatorState& operator=(const SimulatorState& other);      // copies the state
  SimulatorState& operator=(SimulatorState&& other) noexcept;  // `other` is then empty
  ~SimulatorState();

  // True until a simulator saves to it.
  [[nodiscard]] bool empty() const { return impl_ == nullptr; }
  // Time of the posture, s; NaN if the state is empty.
  [[nodiscard]] double time() const;

 private:
  friend class Simulator;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// A controlled driver, or one value of a controlled pose, of the simulators of one Prepared, or of others whose
// controlled drivers have the same names in the same order: found once by its name, so that a control loop looks up no
// text. See Simulator::driver().
class DriverHandle {
 public:
  DriverHandle() = default;  // of no driver: Simulator::set() refuses it

 private:
  friend class Simulator;
  DriverHandle(std::size_t index, std::size_t among) : index_(index), among_(among) {}
  std::size_t index_ = static_cast<std::size_t>(-1);
  std::size_t among_ = 0;  // stands for the names of all controlled drivers
};

// Moves one mechanism. Simulators share no data that changes: each thread of the program may use its own one, also
// within a parallel region of OpenMP, with the threads of its plan. One simulator serves one thread at a time; the
// thread may change. After a fork(), both processes may go on with those simulators that no thread was using at that
// moment; in the child they start new threads.
//
// Single steps use no chunks. P threads (RunSettings::threads) solve P packs of a level, or P packs of chunks, at once.
// Then several threads call callbacks at the same time, and with chunks also laws. With the same C, the motion is
// bitwise identical for every P.
//
// References and spans that a simulator returns are valid until its next call that is not const.
class Simulator {
 public:
  // Begins at the assembled start posture. Throws Error: environment if the plan cannot run here, input for a negative
  // limit or most_iterations = 0, numerical if no motion can start there: the posture has no velocities (it is
  // singular), or it is outside of a limit that ends motions.
  explicit Simulator(Prepared prepared, StepSettings settings = {});
  Simulator(Simulator&&) noexcept;             // the other simulator may then only be destroyed or assigned to
  Simulator& operator=(Simulator&&) noexcept;  // the other simulator may then only be destroyed or assigned to
  ~Simulator();

  // Time of the current posture, s; after construction the start time of the scene.
  [[nodiscard]] double time() const;

  // Moves to time t (s), which may be earlier than time(), and to the targets that were set, by continuation: the step
  // is divided where needed. If it fails, the status gives the reason, and the simulator keeps the last good posture on
  // the way, at time(); targets are dropped, and each driver that has ever been set, also if this step was its
  // first, rests there until its next target.
  // Code::inaccurate is not a failure: time t is reached, and an event gives the estimated error. If t is time(),
  // nothing happens and targets wait; if t is not finite, the step fails as not_finite. Exceptions from laws and
  // callbacks propagate, and leave the simulator like any failure.
  Status step(double t);

  // Sets the target of a controlled driver (PrepareOptions::controlled) for the next step: value, rate and acceleration
  // in SI units, absolute even if the laws are relative, unless Driver::sets_difference is true, as for coordinates of
  // joints: then they count from the posture as written.
  // Angles are not wrapped: a driver at 62.8 rad whose target is 0 turns back ten times. `driver` names a driver of an
  // angle, distance or coordinate, or one value of a pose, whose rotation is Rz(psi) Ry(theta) Rx(phi): "pose.x",
  // "pose.y", "pose.z", "pose.psi", "pose.theta", "pose.phi" in space, "pose.x", "pose.y", "pose.angle" in the plane,
  // where "pose" is the name of the driver. Values of a pose that are not set follow their laws. On the way the driver
  // follows the polynomial of degree 5 through value, rate and acceleration at both ends. A later step without a target
  // ends at rest, at the value that the driver has at its begin. Throws Error (input) if this is not a controlled
  // driver. A number that is not finite lets the next step fail as not_finite, with an event that names the driver; all
  // targets of that step are then dropped.
  void set(std::string_view driver, double value, double rate = 0, double acceleration = 0);
  // The same without a search for the name. `driver` is of this simulator, or of another one with the same controlled
  // drivers. Throws Error (input) for any other handle.
  void set(DriverHandle driver, double value, double rate = 0, double acceleration = 0);
  // The handle of a controlled driver. Throws like set().
  [[nodiscard]] DriverHandle driver(std::string_view name) const;
  // Names of the controlled drivers, and of each value of a controlled pose: those that set() takes.
  [[nodiscard]] std::vector<std::string> drivers() const;

  // Moves from time() by TimeGrid::step to the targets that were set, also beyond the end of the grid; other drivers
  // follow their laws. If the scene has no time grid, it moves by 1 s. A step that fails restores the state before it
  // (as save() holds it, with time and rates) and drops its targets: a driver whose first set() was for this step
  // follows its law again; status and events give the reason, and how far the mechanism could move. An exception from a
  // law or callback propagates and restores the state, too. Near a limit a driver may overshoot: if a
  // step fails while controlled drivers move, it is tried again, unless it ended as deadline or interrupted: all
  // controlled drivers stop at once at the begin of the step, and move from rest to the same targets. If it succeeds,
  // the status is that of the second try, and only Counters::rejected shows the first one.
  Status step();

  // Saves the state. The same steps from it then follow bit by bit, in this simulator or in another one of the same
  // Prepared, unless a solver has found another pivot order in between, which changes last bits. Allocates no memory if
  // `into` was saved to before by a simulator of the same Prepared.
  void save(SimulatorState& into);
  // Saves the state to a new object.
  [[nodiscard]] SimulatorState save();
  // Returns to a saved state, also to its targets; later targets are dropped. The counters and events of the report
  // continue. Throws Error (input) if the state is empty or belongs to another Prepared. A copy of a Prepared counts as
  // the same; the result of another prepare() does not.
  void restore(const SimulatorState& state);

  // Returns to the last posture that an undivided step reached, or to the start posture. From there a short step in any
  // direction has room: an undivided step uses at most 0.7 of the ball in which the posture is the only solution
  // (docs/method.md). Use it near a limit, after steps were divided or step(t) failed. The whole state returns with
  // its time, as with restore(). Changes nothing if the current posture is such a posture.
  void retreat();

  // Runs from the start posture over Prepared::time(). Calls reset() first, so targets are dropped and all drivers
  // follow their laws. Stops at the first failure and returns the rows that were reached; report() has the status. The
  // simulator then stands at the last row, or after a failure at the last good posture, which may be later; step() may
  // go on from there. Exceptions from laws, callbacks and the observer propagate. Throws Error (environment) if there
  // is no memory for the rows.
  Trajectory run(const Observer& observer = {});
  // The same over `times` (s). It first moves from the start posture to times[0], which may be any time. Equal times
  // give equal rows, and no times give no rows. Throws also Error (input) if they descend or are not finite.
  Trajectory run(std::span<const double> times, const Observer& observer = {});

  // Runs as run() does, and gives rows to `sink` instead of keeping them, so that the memory does not grow with the
  // number of times: a block has at most 1,024 rows, or RowSelection::block if that is less. The run uses no chunks,
  // else rows are those of run(), bit by bit. Returns the number of rows that were reached, including those that are
  // not selected; report() has the status. Throws as run(), and Error (input) for an unknown column, an empty sink, or
  // a number that is 0 in `selection`.
  std::size_t stream(const RowSelection& selection, const RowSink& sink, const Observer& observer = {});
  // The same over `times` (s).
  std::size_t stream(const RowSelection& selection, const RowSink& sink, std::span<const double> times,
                     const Observer& observer = {});

  // Returns to the assembled start posture, and clears the report and all targets of drivers.
  void reset();

  // Names of the limited quantities, in the order of Place::limit().
  [[nodiscard]] std::vector<std::string> limits() const;
  // Name of the object that a status of this simulator is about; "" if it is none. The index is not checked.
  [[nodiscard]] const std::string& name_of(Place place) const;

  // Names of the outputs, as in Trajectory::columns().
  [[nodiscard]] const std::vector<std::string>& columns() const;
  // All outputs at time() in SI units, in the order of columns(). The span is valid as long as the simulator, and shows
  // each new posture.
  [[nodiscard]] std::span<const double> outputs() const;
  // One output at time() by its name. Throws Error (input), with a list of the columns, if there is no such name.
  [[nodiscard]] double output(std::string_view column) const;
  // Index of a column in outputs(), for control loops. Throws like output().
  [[nodiscard]] std::size_t index(std::string_view column) const;

  // Accuracy of every group at time(), in the order of Structure::groups(). The report includes the findings. Allocates
  // memory and takes the time of 20 to 80 steps of a small mechanism.
  [[nodiscard]] std::vector<GroupFigures> examine();

  // The derivatives of the outputs with respect to the controlled drivers at the current posture: one factorisation of
  // each group, and one solution for each driver. Allocates memory only in the first call, and again after other
  // redundant equations were chosen.
  [[nodiscard]] const OutputJacobian& jacobian();

  // The derivatives of the equations at the current posture: of all groups in solving order, which gives a block lower
  // triangular matrix; or of one group (index into Structure::groups()). Parts that are left out or stand still have no
  // rows and columns (docs/method.md). Allocates memory. Throws Error (input) for a wrong index.
  [[nodiscard]] ConstraintJacobian constraint_jacobian() const;
  [[nodiscard]] ConstraintJacobian constraint_jacobian(std::int32_t group) const;

  // Report since construction, reset() or the begin of run(). Each call updates effort, fallbacks and estimates, and
  // may allocate memory, because solvers that did extra work are described in words; a control loop uses the status
  // that step() returns. step() keeps the latest 500 to 1,000 events (Report::dropped_events).
  [[nodiscard]] const Report& report() const;
  // How steps use machine code (PrepareOptions::machine_code), for example "AVX-512, one call for all" or "AVX2, 5 of 6
  // groups"; empty: they do not.
  [[nodiscard]] std::string machine_code() const;
  // The plan and structure in use; another choice among redundant equations replaces them.
  [[nodiscard]] Prepared prepared() const;

 private:
  Status go_to(double t);
  template <class TimeOf, class Take>
  std::size_t each_row(std::size_t count, const TimeOf& time_of, const Observer& observer, const Take& take);
  template <class TimeOf>
  std::size_t stream(const RowSelection& selection, const RowSink& sink, std::size_t count, const TimeOf& time_of,
                     const Observer& observer);
  [[nodiscard]] bool run_in_chunks(std::span<const double> times, const Observer& observer, Trajectory& out);
  friend Prepared rehearse(Prepared prepared);
  friend struct SimulatorAccess;  // for use inside the library
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Runs a motion once, over its time grid, and keeps the sets of redundant equations that it chose: simulators of the
// result change from one to another without analysing the scene again (docs/control.md has the times). Does nothing
// without redundant equations. A run that fails is no error: its sets are kept. Throws what laws and callbacks throw.
[[nodiscard]] Prepared rehearse(Prepared prepared);

// True errors of the outputs of a trajectory, each the largest over outputs and times.
struct ForwardError {
  double position = ErrorFigures::kUnknown,   // of values; NaN: no output is of this kind
      velocity = ErrorFigures::kUnknown,      // of rates
      acceleration = ErrorFigures::kUnknown;  // of accelerations
};

// Compares a trajectory with a reference in quadruple precision (113 bits). The reference has the same parameters and
// times, evaluates laws and residuals in quadruple precision, and corrects with factorisations in double. It calls
// functions of the program as the run does, so that errors of these functions remain undetected. The error of an output
// x is the maximum over the times of |x - x_ref|, divided by the maximum of |x_ref| or by a lower limit, whichever is
// larger (docs/accuracy.md; for lengths the characteristic length). It is infinite if x is not finite, except for
// derivatives that do not exist: of a distance at 0, and of an unsigned angle at 0 or pi. Throws Error: input for a
// loaded plan, a trajectory with other columns or without rows; environment if this build has no quadruple precision;
// numerical if the reference does not converge. Needs the library assur::assur.
[[nodiscard]] ForwardError forward_error(const Prepared& prepared, const Trajectory& trajectory);

// Proves the current posture of a simulator, see Certificate. Throws Error: input if load_plan() made the plan,
// environment if this build has no quadruple precision. Needs the library assur::assur.
[[nodiscard]] Certificate certify(const Simulator& simulator);

// Proves each row of a trajectory; returns one certificate for each row. Repeats the steps one after the other. A row
// that is not reproduced bit by bit gets no proof: it was computed in chunks, or with other settings. Throws Error as
// the function above and as Simulator. Needs the library assur::assur.
[[nodiscard]] std::vector<Certificate> certify(const Prepared& prepared, const Trajectory& trajectory,
                                               StepSettings settings = {});

}  // namespace assur
