// What was measured on a machine, and what it says about strategies that were not: samples of kernels, and a model
// that composes the cost of a step from them.
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

// What is timed: one call, for all lanes. The names are stored in databases.
enum class Kernel : std::uint8_t {
  evaluate,  // equations and Jacobian of a pack; depends on shape and W only
  factor,    // one factorisation of W matrices
  solve,     // one solution with one right-hand side of each
  pack,      // one whole step of a pack: position in one iteration, velocity, acceleration; with p > 1 while p threads
             // are at the same work
  meeting,   // the first of p threads works alone for 5 us, which count; then all start together and wait for each
             // other; the others are handed shape.n doubles in all by the first, change them and hand them back
  step,      // one step of a mechanism: checks what is composed of the others
  around,  // what a step takes beyond its packs: laws, prediction, outputs; shape.n unknowns of all groups, shape.terms
           // pieces of outputs as the dispatcher counts them
};

[[nodiscard]] std::string_view name(Kernel kernel) noexcept;
// Throws Error (input) that lists the kernels if there is none of that name.
[[nodiscard]] Kernel parse_kernel(std::string_view text);

// One thing measured. Only what the kernel depends on is set: of a strategy's text a bare matrix needs backend, W,
// precision, refinement and q.
struct Sample {
  std::string uid;  // 32 hexadecimal digits, drawn at random: the same sample in two databases is one
  Kernel kernel = Kernel::factor;
  Shape shape;
  Strategy strategy;
  double seconds = 0;   // median of one call, at the machine's usual pace: db/README.md
  double spread = 0;    // median absolute deviation, s
  double slowness = 1;  // how many times as long as usual it took when it was measured; 1: or not known
  std::int64_t repetitions = 0;
  // Of the result that was timed, the worst over lanes; NaN: not measured. Of a solution: |A x - b| / (|A| |x| + |b|)
  // and |x - x_ref| / |x_ref|, maximum norms; of a step: the worst of Report::error, and that of forward_error().
  double backward_error = 0;
  double forward_error = 0;

  friend bool operator==(const Sample&, const Sample&) = default;
};

// Where a predicted time comes from, the best first.
enum class Origin : std::uint8_t {
  measured,      // this very shape
  interpolated,  // between shapes that were measured
  extrapolated,  // further from them than a factor of two
  prior,         // nothing was measured: operations and overheads of a typical processor
};

[[nodiscard]] std::string_view name(Origin origin) noexcept;

struct Prediction {
  double seconds = 0;
  double factor = 1;  // two times in three the truth is within seconds / factor and seconds * factor
  Origin origin = Origin::prior;
};

// An immutable snapshot of what is known about a machine; any number of threads may ask it. The same samples in
// whatever order make the same model, bit for bit.
class PerformanceModel {
 public:
  PerformanceModel();  // nothing is known
  // `source` says whose samples these are, in words for people.
  explicit PerformanceModel(const std::vector<Sample>& samples, std::string source = {});
  // The same of samples that lie anywhere; they may go afterwards.
  explicit PerformanceModel(std::span<const Sample* const> samples, std::string source = {});
  PerformanceModel(const PerformanceModel&) = default;
  PerformanceModel& operator=(const PerformanceModel&) = default;
  ~PerformanceModel();

  // Time of one call of a kernel.
  [[nodiscard]] Prediction kernel(Kernel kernel, const Shape& shape, const Strategy& strategy) const;
  // Time of one step of a pack of W instances, composed from its kernels and the strategy's policies.
  [[nodiscard]] Prediction pack(const Shape& shape, const Strategy& strategy) const;
  // The same of several strategies, in less time than one by one.
  [[nodiscard]] std::vector<Prediction> packs(const Shape& shape, std::span<const Strategy> strategies) const;
  // Time that p threads lose by starting together, handing over so many doubles and back, and waiting for each other.
  [[nodiscard]] Prediction meeting(std::int32_t p, double doubles = 0) const;
  // How much longer packs of groups with n unknowns take where p threads work at once; 1 where nothing is known. The
  // median of what was measured at some n, and between them by log n.
  [[nodiscard]] double contention(std::int32_t p, std::int32_t n) const;
  // Time of one step of a mechanism with so many unknowns beyond its packs: laws, prediction, outputs. pieces: terms of
  // the outputs. From counts, at the speed that this machine has otherwise.
  [[nodiscard]] Prediction around(std::int64_t unknowns, std::int64_t pieces = 0) const;
  // Largest backward error of a solution that was seen near this shape; 0 if none was looked at.
  [[nodiscard]] double backward_error(const Shape& shape, const Strategy& strategy) const;

  [[nodiscard]] std::size_t samples() const;
  [[nodiscard]] const std::string& source() const;

 private:
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

// What the databases say about the machine at hand, read once for each process and then kept.
struct MachineModel {
  std::shared_ptr<const PerformanceModel> model;  // never null
  std::vector<std::string> messages;              // what was not believed or could not be read, and why
};

// In the order ASSUR_DB, the user's database, that of the installation: see db/README.md. Never throws for what is in
// the files; never writes. ASSUR_DB set to nothing: no database at all. In assur::assur.
[[nodiscard]] const MachineModel& machine_model();

}  // namespace assur
