// Limits of measures along a run. Between two postures a limited quantity is the polynomial of degree 5 through its
// value, rate and acceleration at both ends; where the polynomial leaves or enters a limit, postures are solved to
// bracket the time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "assur/report.hpp"
#include "equations/system.hpp"
#include "numbers.hpp"
#include "outputs/angle_turns.hpp"
#include "outputs/output_program.hpp"

namespace assur {

// Smallest difference of times, over the time itself. A choice: some roundings of the sums that give times.
inline constexpr double kResolvedTime = 16 * kEps;

// The polynomial of degree 5 on [0, 1] in Bernstein form: it lies between its least and its largest coefficient.
class Quintic {
 public:
  // Rates and accelerations per unit interval. If one of them is not finite, the polynomial is the straight line.
  Quintic(const Jet<double>& begin, const Jet<double>& end);

  [[nodiscard]] std::span<const double> coefficients() const { return c_; }
  [[nodiscard]] double at(double s) const;
  // Places in (0, 1) where it turns back, ascending, within 2^-26.
  struct Extrema {
    std::array<double, 8> at;
    std::size_t count = 0;
  };
  [[nodiscard]] Extrema extrema() const;

 private:
  std::array<double, 6> c_;
};

// The measures with bounds, in their order, each once.
[[nodiscard]] std::vector<Index> limited_quantities(const System& system);

// The bounds of one mechanism.
class LimitWatch {
 public:
  // `address`: coordinates -> index into the state arrays. `system` must outlive this object.
  LimitWatch(const System& system, std::span<const std::int32_t> address);
  LimitWatch(const LimitWatch&) = delete;
  LimitWatch& operator=(const LimitWatch&) = delete;

  // Marks the addresses that are read.
  void mark(std::vector<std::uint8_t>& addresses) const { outputs_.mark(addresses); }
  // Signed angles among the limited quantities; they must be followed from posture to posture.
  [[nodiscard]] AngleTurns& turns() { return turns_; }

  using Posture = const double* const (&)[3];  // [d]: d-th derivatives of the coordinates, by address

  // Begins at a posture. known: values() there, if the motion began before; else a signed angle begins at the value of
  // its driver's law, or within its limit if whole turns bring it there.
  void start(Posture q, double time, std::span<const double> known);
  // Bounds that the last accepted posture violates.
  [[nodiscard]] std::vector<std::size_t> violated() const;

  // Reads the posture that may be accepted next. True if a quantity may leave or enter its limit on the way there.
  [[nodiscard]] bool may_change(Posture q, double time);
  // After may_change(): true if the laws may leave their chords so far that the polynomial misses a quantity that left
  // or entered its limit on the way. times: factor of the bows, see measure()
  [[nodiscard]] bool hides_change(double times) const;
  // Measures how far each quantity may leave its way within a step, to first order: by the changes of the coordinates
  // that the probes hold. resting: zeros, of the size of the state
  void measure(Posture q, std::span<double* const> probes, const double* resting, std::size_t lane = 0);
  // A quantity leaves its limit (`leaves`) or returns into it, between two times.
  struct Change {
    std::size_t bound;
    bool leaves;
    double from, until;
  };
  // After may_change(): the changes on the way, in their order, up to the first one that ends the motion. solve(t)
  // solves the posture at a time on the way and returns its coordinates by address, or null. The result is valid until
  // the next call.
  [[nodiscard]] std::span<const Change> changes(const std::function<const double*(double)>& solve);
  [[nodiscard]] bool ends(const Change& change) const { return change.leaves && system_.bounds[change.bound].ends; }
  // The status of a motion that ends at this change.
  [[nodiscard]] Status status(const Change& change) const {
    return {Code::limit_reached, Place::limit(limits_[change.bound]), system_.bounds[change.bound].value};
  }
  // After may_change(): accepts that posture.
  void accept();

  // The limited quantities at the last accepted posture, SI units; the measures of a sum come before it.
  [[nodiscard]] const std::vector<double>& values() const { return values_; }

  // State at the last accepted posture, which restore() returns to.
  struct Snapshot {
    std::vector<double> row, bows;
  };
  void save(Snapshot& into) const {
    into.row = now_;
    into.bows = bows_;
  }
  void restore(const Snapshot& from, double time) {
    next_ = from.row;
    bows_ = from.bows;
    next_time_ = time;
    accept();
  }

  [[nodiscard]] Code kind(const Change& change) const {
    return ends(change) ? Code::limit_reached : change.leaves ? Code::limit_exceeded : Code::within_limits;
  }
  [[nodiscard]] Event event(const Change& change) const;
  // "A.angle is 1.5 rad, above its largest allowed value 1.2 rad": describes a violated bound.
  [[nodiscard]] std::string describe(std::size_t bound) const;

 private:
  struct Side {
    std::size_t column;  // column of the value in a row
    double sign;         // the quantity is outside if sign * (value - bound) > rounding
    double rounding;
    double hidden;  // a smaller bow counts as none
  };
  [[nodiscard]] double excess(std::size_t bound, double value) const {
    return sides_[bound].sign * (value - system_.bounds[bound].value) - sides_[bound].rounding;
  }
  void read(Posture q, std::vector<double>& row, std::span<const double> near);
  void bracket(std::size_t bound, double from, double excess_from, double until, double excess_until,
               const std::function<const double*(double)>& solve);
  [[nodiscard]] Quintic way(std::size_t bound) const;
  [[nodiscard]] const MeasureForms& measure(std::size_t bound) const {
    return system_.measures[idx(system_.bounds[bound].measure)];
  }

  const System& system_;
  OutputProgram outputs_;
  AngleTurns turns_;
  std::vector<std::size_t> angles_;   // columns of signed angles
  std::vector<Side> sides_;           // one for each bound
  std::vector<double> bows_;          // one for each bound, see measure()
  std::vector<std::int32_t> limits_;  // bounds: index into limited_quantities()
  std::vector<double> no_turns_, divisors_;
  std::vector<double> now_, next_, probe_;  // rows: value, rate and acceleration of each quantity
  std::vector<double> values_;              // values in now_
  double now_time_ = 0, next_time_ = 0;
  std::vector<Change> found_;  // by changes()
};

}  // namespace assur
