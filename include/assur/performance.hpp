// Measurements of a machine, and the performance model: it predicts the time of a step by any strategy from measured
// times of kernels. The functions in this header need the library assur::assur.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "assur/backend.hpp"
#include "assur/strategy.hpp"

namespace assur {

// The pieces of work that are timed; each time is that of one call, which serves all W lanes. Databases store the
// names.
enum class Kernel : std::uint8_t {
  evaluate,  // equations and Jacobian of a pack; depends on shape and W only
  factor,    // one factorisation of W matrices
  solve,     // one solution of W systems, each with one right-hand side
  pack,      // one step of a pack (up to W groups of a class in SIMD lanes): position in one iteration, velocity and
             // acceleration; if P > 1, while P threads do the same work; with +together a pack's share of such a step
  meeting,   // P threads start together and wait for each other, after the first has worked alone for 5 us (included).
             // Thread 0 passes shape.n doubles (in all) to the others, which change them and pass them back
  step,      // one step of a mechanism; only to compare with the sum of the other kernels
  around,    // the part of a step beyond its packs: laws, prediction, outputs. shape.n: unknowns of all groups;
             // shape.terms: terms of the outputs
};

// Name of a kernel as in databases, e.g. "factor".
[[nodiscard]] std::string_view name(Kernel kernel) noexcept;
// The kernel with this name. Throws Error (input), with a list of the kernels, if there is no such name.
[[nodiscard]] Kernel parse_kernel(std::string_view text);

// One measured time. (assur::sample() is unrelated: it makes mechanisms.) The strategy is set as far as the kernel
// depends on it: for a bare matrix, backend, W, precision, refinement and Q.
struct Sample {
  std::string uid;                 // 32 random hexadecimal digits, which identify the sample in all databases
  Kernel kernel = Kernel::factor;  // the work
  Shape shape;                     // its size
  Strategy strategy;               // the way it was done
  double seconds = 0;              // median time of one call at the usual pace of the machine (db/README.md)
  double spread = 0;               // median absolute deviation of the times, s
  double slowness = 1;             // time at the pace of the measurement over time at the usual pace; 1 if unknown
  std::int64_t repetitions = 0;    // number of measured times, of which the medians are taken
  // Largest backward error of the timed results over the lanes; NaN: not measured. For a solution it is
  // |A x - b| / (|A| |x| + |b|) in maximum norms, for packs and steps ErrorFigures::residual().
  double backward_error = 0;
  // Largest forward error of the timed solutions over the lanes, |x - x_ref| / |x_ref| in maximum norms; NaN: not
  // measured, as for packs and steps.
  double forward_error = 0;

  friend bool operator==(const Sample&, const Sample&) = default;
};

// Evidence for a predicted time, from the best to the weakest.
enum class Origin : std::uint8_t {
  measured,      // this shape was measured
  interpolated,  // a measured shape is at most a factor of two away
  extrapolated,  // all measured shapes are further away, or were measured with another W or other threads
  prior,         // no such measurement: operation counts and overheads of a typical processor
};

// Name of an origin as in the command's output, e.g. "interpolated".
[[nodiscard]] std::string_view name(Origin origin) noexcept;

// A predicted time.
struct Prediction {
  double seconds = 0;             // expected time
  double factor = 1;              // with probability 2/3 the time is between seconds / factor and seconds * factor
  Origin origin = Origin::prior;  // evidence
};

// Predicts times on one machine. A model is immutable; any number of threads may use it, and copies share its data. The
// order of the samples does not matter: the same samples make the same model, bit for bit.
class PerformanceModel {
 public:
  PerformanceModel();  // without samples: all predictions are of origin `prior`
  // A model that is fitted to samples. `source` describes their origin for people. Samples with impossible figures are
  // ignored: a time outside 1e-15 to 1e9 s, a negative size, or a spread or error that is negative.
  explicit PerformanceModel(std::vector<Sample> samples, std::string source = {});
  PerformanceModel(const PerformanceModel&) = default;             // shares the data
  PerformanceModel& operator=(const PerformanceModel&) = default;  // shares the data
  ~PerformanceModel();

  // Time of one call of a kernel.
  [[nodiscard]] Prediction kernel(Kernel kernel, const Shape& shape, const Strategy& strategy) const;
  // Time of one step of a pack of W groups. If the pack was not measured, the time is composed of kernels. With
  // +together: a share of a step of all levels, with the recurrence through them; shape.groups are those of all levels
  [[nodiscard]] Prediction pack(const Shape& shape, const Strategy& strategy) const;
  // pack() for several strategies, faster than one call for each. The result has their order.
  [[nodiscard]] std::vector<Prediction> packs(const Shape& shape, std::span<const Strategy> strategies) const;
  // Time that p threads lose by starting together, passing this number of doubles there and back, and waiting for each
  // other. 0 if p < 2.
  [[nodiscard]] Prediction meeting(std::int32_t p, double doubles = 0) const;
  // Factor by which packs of groups with n unknowns take longer if p threads work at once; 1 if nothing was measured.
  // Between measured n, it is interpolated in log n.
  [[nodiscard]] double contention(std::int32_t p, std::int32_t n) const;
  // Time that a step takes beyond its packs, for laws, prediction and outputs. unknowns: of all groups of the
  // mechanism; pieces: terms of the outputs.
  [[nodiscard]] Prediction around(std::int64_t unknowns, std::int64_t pieces = 0) const;
  // Whole steps of one mechanism (Kernel::step) that were measured, with the strategy that all its classes share.
  struct MeasuredStep {
    Strategy strategy;
    Prediction time;
  };
  // Those of the mechanism whose steps have this shape, in the order of the texts of their strategies.
  [[nodiscard]] std::vector<MeasuredStep> steps(const Shape& shape) const;
  // Largest measured backward error of a solution with n/2 to 2 n unknowns; 0 if none was measured.
  [[nodiscard]] double backward_error(const Shape& shape, const Strategy& strategy) const;

  // Number of samples.
  [[nodiscard]] std::size_t samples() const;
  // Description of the samples for people.
  [[nodiscard]] const std::string& source() const;

 private:
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

// The model of this machine, with messages about its databases.
struct MachineModel {
  std::shared_ptr<const PerformanceModel> model;  // never null
  std::vector<std::string> messages;              // databases that cannot be read, and samples that are left out
};

// The model of this machine from the tuning databases. The first call reads them, and the result is kept as long as the
// process. The database is the file ASSUR_DB, or else that of the user and that of the installation (db/README.md); if
// ASSUR_DB is set and empty, there is none. Unreadable or damaged files give messages, not errors. Never writes.
[[nodiscard]] const MachineModel& machine_model();

}  // namespace assur
