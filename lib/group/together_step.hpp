// The step of all groups of a class at once, whatever their levels. Each group is linearised at the prediction, with
// inputs that other groups have not corrected yet:
//   J dx + H dh = -Phi      =>      dx = own + sum_k column_k load_k,   own = -J^-1 Phi,   column_k = J^-1 e_k
// Row k is an equation that reads unknowns of other groups, and load_k = -(H dh)_k is the effect of their changes on
// it. With the changes of those groups inserted, the loads of all groups are a linear recurrence through the levels:
//   load_k = -(H own)_k + sum_j gain_kj load_j,   gain_kj = -(H column_j)_k
// The rates and the accelerations have the same columns and gains at the solved posture, with their own right-hand
// sides. Together (path/together.hpp) calls the passes below for all classes in turn and runs the recurrence.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "assur/structure.hpp"
#include "equations/lane_array.hpp"
#include "equations/program.hpp"
#include "group/branch.hpp"
#include "group/pack.hpp"

namespace assur {

inline constexpr int kMostCoupledRows = 3;  // most coupled equations of a group

// Numbers of the coupled groups of all classes. An array of unknowns has its own addresses: those of a class are
// [unknown][group]. The first W numbers of every array are zero; they stand for inputs that no group computes.
struct Coupling {
  LaneArray own, change;                            // changes of the unknowns: alone, and with all loads
  std::array<LaneArray, kMostCoupledRows> columns;  // change of the unknowns for a load of 1, by coupled row
  LaneArray loads;                                  // loads of the coupled rows, by class [row][group]
  LaneArray gains;                                  // by class [gain][group]
};

// An array that is read or written by the lanes of a pack.
struct LaneAddresses {
  std::vector<InputRow> rows;
  std::vector<std::int32_t> addresses;  // rows x W
};

// W groups of one class on any levels.
struct TogetherPack {
  Pack pack;               // inputs and coefficients, and by lane the guard of each group; ball_used: W
  LaneAddresses unknowns;  // addresses of the unknowns in the state
  LaneAddresses known;     // addresses of the inputs; those that groups compute lead to a number without rates
  LaneAddresses sources;   // addresses in Coupling::own of the unknowns that the entries read
  std::size_t place = 0;   // number of its first group among the groups of the class
  bool driven = false;     // an input that no group computes moves
};

// The largest residuals of a step so far. The passes raise them, and stop at the first that is not finite.
struct TogetherFigures {
  double position = 0, velocity = 0, acceleration = 0;
};

// The passes over all packs of one class.
class TogetherStep {
 public:
  // An input that groups compute, as part of a coupled row (a number from 0 on). Entries with the same row and part
  // read the same group in every lane.
  struct Entry {
    std::int32_t row, input;
    std::size_t begin, end;  // terms of the slope of the equation along this input
    std::int32_t part = 0;
  };
  // A gain: the load of a row depends on a row of the group that a part of its entries reads.
  struct Gain {
    std::int32_t row, of;     // coupled rows of this group and of the other one
    std::int32_t begin, end;  // entries
  };
  // Where the numbers of the class lie in a Coupling; `groups`: with idle lanes.
  struct Places {
    std::size_t unknowns, loads, gains, groups;
  };
  enum class Progress : std::uint8_t { failed, open, solved };

  virtual ~TogetherStep() = default;

  [[nodiscard]] std::int32_t rows() const { return rows_; }
  [[nodiscard]] std::span<Entry> entries() { return entries_; }
  [[nodiscard]] std::span<const Gain> gains() const { return gains_; }
  [[nodiscard]] std::vector<TogetherPack>& packs() { return packs_; }

  // To be called when the packs are there and the entries are sorted by row and part. columns: the number of coupled
  // rows of the groups that each part of each row reads, in the order of the entries.
  virtual void place(const Places& places, std::span<const std::int32_t> columns) = 0;

  // To be called when coordinates at rest may have changed.
  virtual void begin(const double* state) = 0;
  // Computes equations, Jacobian, factors, own changes and columns at the current posture. iteration: 0 at the
  // prediction. solved: every residual is at most `converged`, or only rounding is left. failed: the factorisation, the
  // convergence or the first correction of a lane is unusual.
  [[nodiscard]] virtual Progress linearise(const double* state, int iteration, double converged, Coupling& coupling,
                                           TogetherFigures& figures) = 0;
  // Computes the loads from the own changes, and the gains. To be called when all classes have their own changes.
  virtual void couple(Coupling& coupling, bool with_gains) = 0;
  // Moves the unknowns. To be called when all loads are complete.
  virtual void correct(double* state, Coupling& coupling) = 0;
  // Computes the own rates from the rates of the inputs that no group computes; then the rates.
  virtual void own_rates(double* const (&state)[3], Coupling& coupling) = 0;
  virtual void finish_rates(double* const (&state)[3], const Coupling& coupling) = 0;
  // The same for accelerations. own_accelerations() also measures the rates.
  virtual void own_accelerations(double* const (&state)[3], Coupling& coupling, TogetherFigures& figures) = 0;
  virtual void finish_accelerations(double* const (&state)[3], Coupling& coupling) = 0;
  virtual void measure_accelerations(const Coupling& coupling, TogetherFigures& figures) = 0;
  // The part of its ball that each group used: W numbers for each pack. balls_last: packs, 1 if each group also stays
  // inside in a next step of this length, see ball_lasts().
  [[nodiscard]] virtual std::span<const double> balls_used() const = 0;
  [[nodiscard]] std::span<const std::uint8_t> balls_last() const { return balls_last_; }

 protected:
  std::int32_t rows_ = 0;
  std::vector<Entry> entries_;
  std::vector<Gain> gains_;
  std::vector<TogetherPack> packs_;
  std::vector<std::uint8_t> balls_last_;
};

// For a class that why_not_together() allows, and 4, 8 or 16 lanes. computed: inputs, 1 if a group computes the input
// in some group of the class. `program` and `blocks` must outlive the step.
[[nodiscard]] std::unique_ptr<TogetherStep> make_together_step(const GroupClass& group_class, const Program& program,
                                                               const BlockConditions& blocks,
                                                               std::span<const std::uint8_t> computed, int lanes);

// A chain of loads: loads[i] += gains[i] * loads[i - 1], where `before` is the load before the first one.
using ChainOfLoads = void (*)(const double* gains, double before, std::int32_t count, double* loads);
[[nodiscard]] ChainOfLoads chain_of_loads();

}  // namespace assur
