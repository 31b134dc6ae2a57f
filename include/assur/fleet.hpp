// Fleets: many planar linkages of different structures over the same times. A linkage is an array of joints, each after
// those that it depends on; no scene, no text and no preparation is needed for it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "assur/curve.hpp"
#include "assur/ensemble.hpp"
#include "assur/scene.hpp"
#include "assur/status.hpp"

namespace assur {

// A joint of a planar linkage. Lengths in m, angles in rad, speeds in rad/s.
struct LinkageJoint {
  // How the joint depends on its parents.
  enum class Kind : std::uint8_t {
    ground,  // fixed at (value[0], value[1])
    // At distance value[0] from `first`; at time t, the direction from `first` has the angle value[1] + value[2] t from
    // the x axis.
    crank,
    dyad,  // at distances value[0] from `first` and value[1] from `second`, on the side `left`
    // On a link that holds both parents: first + value[0] (second - first) + value[1] * that turned by +90°. Not
    // checked: if the distance of the parents changes, the link is stretched.
    point,
    // One of three joints in a row, all of this kind, on one link: at distance value[0] from `first`. value[1] and
    // value[2] are its x and y in an approximate posture at the first time. The three positions give the shape of the
    // link, and Newton's method leads from them to the posture.
    triad,
  };
  Kind kind = Kind::ground;
  bool left = true;                     // of a dyad: on the left of the line from `first` to `second`
  std::uint16_t first = 0, second = 0;  // indices of the parents, smaller than the own one
  std::array<double, 3> value{};

  [[nodiscard]] static LinkageJoint ground(double x, double y) { return {Kind::ground, true, 0, 0, {x, y, 0}}; }
  [[nodiscard]] static LinkageJoint crank(std::uint16_t first, double radius, double angle, double speed) {
    return {Kind::crank, true, first, 0, {radius, angle, speed}};
  }
  [[nodiscard]] static LinkageJoint dyad(std::uint16_t first, std::uint16_t second, double to_first, double to_second,
                                         bool left) {
    return {Kind::dyad, left, first, second, {to_first, to_second, 0}};
  }
  [[nodiscard]] static LinkageJoint point(std::uint16_t first, std::uint16_t second, double along, double across) {
    return {Kind::point, true, first, second, {along, across, 0}};
  }
  [[nodiscard]] static LinkageJoint triad(std::uint16_t first, double to_first, double x, double y) {
    return {Kind::triad, true, first, 0, {to_first, x, y}};
  }
};

// A planar linkage.
struct Linkage {
  std::vector<LinkageJoint> joints;
  std::size_t traced = kLast;  // the joint whose path is computed

  static constexpr std::size_t kLast = std::numeric_limits<std::size_t>::max();  // stands for the last joint

  // A linkage from its posture at time 0, as data sets of linkages give it. parents: of each joint, {-1, -1} for a
  // ground, {i, -1} for a crank about joint i, {i, j} for a dyad. positions: of each joint, m. speed: of all cranks,
  // rad/s. Throws Error (input) if the numbers of parents and positions differ, or a parent is not before its child;
  // Fleet refuses the rest.
  [[nodiscard]] static Linkage at_posture(std::span<const std::array<int, 2>> parents,
                                          std::span<const PlanePoint> positions, double speed);
};

// The same linkage as a scene, with points named J0, J1, ... in their posture at time.start, whose positions
// are its outputs. In the library assur::assur. Throws Error: input as Fleet and for a grid without a step,
// numerical if a dyad or triad cannot be closed there. A Simulator may go on where a Fleet ends, through points where
// two motions cross. A point very close to the line of its parents makes the scene singular.
[[nodiscard]] Scene scene_of(const Linkage& linkage, const TimeGrid& time, std::string name = "linkage");

// The motion of one linkage of a fleet.
struct LinkageMotion {
  // ok; inaccurate (the motion is complete, but its estimated error or its residual exceeds the accuracy asked for);
  // fold (a dyad or triad, also one that the traced joint does not need, cannot be closed beyond `reached`);
  // branch_unknown (two postures of a dyad or triad come so close that the continuation is unknown, as in a flat
  // parallelogram, which a Simulator passes); singular or not_assembled (a dyad or triad is stretched or cannot be
  // closed at the first time); not_finite (a coordinate of the path or its error overflows).
  Status status;
  double reached = 0;     // last time at which all dyads and triads are known to be closed, s; NaN if none is
  double not_beyond = 0;  // if the motion ended: a time after `reached` at which it cannot be continued, s; else NaN
  // The dyad, or the first joint of the triad, that cannot be closed; -1: there is none, or it is unknown.
  std::int32_t joint = -1;
  double residual = 0;  // largest relative residual | |p - a|^2 - l^2 | / l^2 of all dyads and triads
  // Estimated error of the path (to first order, from rounding errors with random signs), divided by the largest
  // coordinate of the path or the mean length of the linkage, whichever is larger.
  double error = 0;
  std::span<const PlanePoint> path;  // of the traced joint, one for each time up to `reached`; valid within the sink
};

// How a fleet runs.
struct FleetOptions {
  int threads = 1;         // including the calling one
  double accuracy = 1e-6;  // estimated errors and residuals above it make a motion `inaccurate`
  Observer observer = {};  // may stop the run
  // Only the linkages `first` up to, without, `last`; kAll: up to the end.
  std::size_t first = 0, last = kAll;

  static constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();
};

// Work of a run.
struct FleetReport {
  std::size_t linkages = 0;    // all that were taken
  std::size_t done = 0;        // motions that are ok or inaccurate
  std::size_t inaccurate = 0;  // of these
  std::size_t jammed = 0;      // motions that ended before the last time, or are not_finite
  std::size_t not_closed = 0;  // linkages that could not be closed at the first time
  std::int64_t dyads = 0;      // dyads and triads that were solved, one for each time
  std::int64_t divided = 0;    // intervals between two times that were divided to follow a branch
  double residual = 0;         // the largest of all motions
  bool interrupted = false;    // true if the observer ended the run
};

// Summaries of the paths of a fleet.
struct FleetSummary {
  struct Member {
    Status status;       // as LinkageMotion; interrupted if the run ended before
    double reached = 0;  // as LinkageMotion
    ColumnSummary x, y;  // of the traced joint
  };
  std::vector<Member> members;
};

// Many linkages. All times of a linkage are solved side by side in SIMD lanes, in blocks of eight, from ground to the
// last joint. The result of a linkage depends on nothing but this linkage and the times: it is bitwise the same for any
// number of threads and for any part of a fleet.
//
// Between two times, the squared distance of the parents of each dyad is followed by a cubic with the rates at both
// times; where it comes close to a limit at which the dyad is stretched or folded, the interval is divided by eight,
// and so on. So a motion that leaves its branch between two times is found. A triad is solved by Newton's method from
// the posture and the rates at the time before; an interval is divided unless the inverse of its Jacobian matrix bounds
// the way to any other posture (Kantorovich).
class Fleet {
 public:
  // Makes linkage i in `to`, whose content is that of an earlier linkage. Called by all threads.
  using Source = std::function<void(std::size_t i, Linkage& to)>;
  // Takes the finished motion of linkage i. Called by all threads, once for each linkage, in any order.
  using Sink = std::function<void(std::size_t i, const LinkageMotion& motion)>;

  // Stored linkages. Throws Error (input) for the first linkage that is not valid: no joint, a parent that is not
  // before its joint, a number that is not finite, a length that is not positive, a triad without three joints in three
  // places, a traced joint that does not exist.
  explicit Fleet(std::vector<Linkage> linkages);
  // Linkages that are made when they are needed; nothing of them is kept.
  Fleet(std::size_t linkages, Source source);

  // Number of linkages.
  [[nodiscard]] std::size_t members() const { return size_; }

  // Moves the linkages, and gives their motions to `sink`. times: not descending, s; at least one. Throws Error (input)
  // for other times, a wrong range, options that are not positive, or a linkage of the source that is not valid.
  // Exceptions of source, sink and observer propagate.
  FleetReport stream(const Sink& sink, std::span<const double> times, const FleetOptions& options = {}) const;

  // Moves the linkages, and keeps summaries of their paths; those outside the range are `interrupted`. Throws as
  // stream().
  [[nodiscard]] FleetSummary summarize(std::span<const double> times, const FleetOptions& options = {}) const;

 private:
  std::size_t size_;
  Source source_;
};

}  // namespace assur
