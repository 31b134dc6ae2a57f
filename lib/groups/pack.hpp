// Packs: groups of one class that are solved side by side.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "assur/backend.hpp"
#include "backends/lanes_elimination.hpp"
#include "evaluation/coefficients.hpp"
#include "evaluation/lane_array.hpp"
#include "executors/step_code.hpp"
#include "groups/pack_kernels.hpp"

namespace assur {

// Copies of the arrays of a pack that an attempt at a step overwrites; a rejected attempt restores them.
struct Kept {
  std::int64_t use_of = 0, anchor_of = 0, factors_of = 0;  // the attempt that overwrote them; 0: none
  LaneArray ball_used;
  LaneArray anchor, anchor_rates, anchor_time, omega;
};

// W instances of a class. All arrays are owned by the simulator; lanes beyond `used` repeat lane 0.
struct Pack {
  std::int32_t group_class = 0;
  std::int32_t level = 0;
  std::int32_t used = 1;             // lanes that hold a group
  std::vector<std::int32_t> groups;  // used: indices into Structure::groups()
  std::size_t unknowns = 0;          // address of the first unknown in the state arrays
  std::vector<std::int32_t> inputs;  // inputs x W addresses in the state arrays
  std::vector<InputRow> input_rows;  // inputs: the same in short, if the addresses are regular
  LaneArray coefficients;            // (coefficients, 0, 1) x W
  LaneArray lipschitz;               // equations x W
  LaneArray anchor;                  // for each block the coordinates that it reads x W, where omega was measured
  LaneArray anchor_rates;            // rates at the anchor, same layout
  LaneArray anchor_time;             // blocks x W: time of the anchor, s; NaN: unknown, or without rates
  LaneArray omega;                   // blocks x W
  std::span<double> ball_used;       // blocks x W: part of the ball used at the last posture inside it
  LaneArray own_use;                 // storage of ball_used, unless packs share an array (see Together)
  Kept kept;
  std::unique_ptr<LinearSolver> solver;  // own solver; null: the packs of the class share one
  std::unique_ptr<LinearSolver> pivots;  // own solvers are clones of it; null: of that of the first pack of the class
  bool restarts = false;                 // the solver begins anew before it is used
  bool factored = false;                 // +reuse=run: `solver` holds factors of an earlier posture
  // Machine code of the class, if there is some, which serves as long as `solver` eliminates in this way.
  CodeOfClass machine_code;
  std::shared_ptr<const lanes::Elimination> eliminates;

  // A status about the group in a lane.
  [[nodiscard]] Status failed(Code code, double figure, std::int32_t lane) const {
    return {code, Place::group(groups[std::min(static_cast<std::size_t>(lane), groups.size() - 1)]), figure};
  }
  // A status of the linear solver, which names a lane or none. An idle lane repeats lane 0, so its failure is that of
  // lane 0.
  [[nodiscard]] Status failed(const Status& s) const {
    return failed(s.code, s.figure, s.where.index < used ? std::max(s.where.index, 0) : 0);
  }

  // Keep copies; to be called before an attempt overwrites the arrays.
  void keep_use(std::int64_t attempt) {
    if (std::exchange(kept.use_of, attempt) == attempt) return;
    std::copy(ball_used.begin(), ball_used.end(), kept.ball_used.begin());
  }
  void keep_anchor(std::int64_t attempt) {
    if (std::exchange(kept.anchor_of, attempt) != attempt) copy_anchor(kept);
  }
  // Restores the pack to its state before the attempt, except for the pivot orders of `solver`.
  void undo(std::int64_t attempt) {
    if (kept.use_of == attempt) std::copy(kept.ball_used.begin(), kept.ball_used.end(), ball_used.begin());
    if (kept.anchor_of == attempt) restore_anchor(kept);
    if (kept.factors_of == attempt) factored = false;
    kept.use_of = kept.anchor_of = kept.factors_of = 0;
  }

  // Everything that the next step depends on, except for `solver`.
  void save(Kept& into) const {
    into.ball_used.assign(ball_used.begin(), ball_used.end());
    copy_anchor(into);
  }
  void restore(const Kept& from) {
    std::copy(from.ball_used.begin(), from.ball_used.end(), ball_used.begin());
    restore_anchor(from);
    factored = false;
  }

 private:
  // The arrays stay where they are: steps keep pointers to them.
  void restore_anchor(const Kept& from) {
    anchor = from.anchor;
    anchor_rates = from.anchor_rates;
    anchor_time = from.anchor_time;
    omega = from.omega;
  }
  void copy_anchor(Kept& into) const {
    into.anchor = anchor;
    into.anchor_rates = anchor_rates;
    into.anchor_time = anchor_time;
    into.omega = omega;
  }
};

}  // namespace assur
