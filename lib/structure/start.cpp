#include "structure/start.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <numbers>
#include <numeric>
#include <optional>
#include <set>
#include <unordered_map>
#include <utility>

#include "decimal.hpp"
#include "decompositions.hpp"
#include "index.hpp"
#include "scene/own_values.hpp"
#include "scene/residual_scale.hpp"
#include "scene/triple.hpp"
#include "structure/approach.hpp"
#include "structure/assembly.hpp"
#include "structure/block_names.hpp"
#include "structure/dense_block.hpp"
#include "structure/directions.hpp"
#include "structure/frame_axes.hpp"
#include "structure/freedoms.hpp"
#include "structure/gearing.hpp"
#include "structure/idle_parts.hpp"
#include "structure/other_postures.hpp"
#include "structure/rank.hpp"
#include "structure/redundant_sets.hpp"
#include "structure/violated.hpp"

namespace assur {
namespace {

// rad or internal units, from the value of a driver in the scene to that of its law
constexpr double kFarFromWritten = 0.1;
constexpr double kAsWritten = 1e-9;        // rad or m: the drivers have their values in the posture as written
constexpr double kSameTooth = 1e-6;        // internal units; another tooth turns a wheel by more than 2 pi / 1000
constexpr double kManyTurns = 8;           // of one driver, before a period of the gears is sought
constexpr int kLongestPeriod = 50;         // turns
constexpr double kNearby = 0.05;           // rad or internal units: displacement of drivers from a singular posture
constexpr double kDependentNearby = 1e-7;  // pivots of rows of length 1
// equations or unknowns; dense decompositions of larger matrices take seconds
constexpr std::size_t kLargestNearby = 600;
constexpr std::size_t kMostRedundantNamed = 12;
constexpr std::size_t kMostFlips = 8;  // drivers that take the longer way round, one at a time

// A point that moves farther than this from its guess to the start posture is reported; internal units. Typical
// lengths are 1 to 2, and guesses by eye are within half of a length.
constexpr double kMovedFar = 0.75;

std::string shortened(double value) { return general(value, 3); }
std::string precise(double value) { return general(value, 6); }

class Start {
 public:
  Start(const System& system, Problem& problem, Structure& out)
      : s_(system), p_(problem), out_(out), column_(system.coordinates.size(), -1) {}

  // Returns the parts that are not regular.
  DoubtfulParts run() {
    split_equations();
    p_.blocks = decompose(s_, p_.equations, p_.unknowns);
    leave_out_idle_parts();
    const std::vector<Index> singular = assemble_blocks();
    const bool refused = !out_.cannot_assemble.empty() && p_.blocks.square();
    if (!refused && !(p_.blocks.square() && singular.empty())) study_doubtful_parts(singular);
    check_frames();
    return std::move(doubtful_);
  }

 private:
  // Equations among known coordinates are only checked, never solved.
  void split_equations() {
    std::vector<Index> mentioned;
    for (Index e = 0; e < static_cast<Index>(s_.equations.size()); ++e) {
      s_.mentioned(e, mentioned);
      const bool solves = std::any_of(mentioned.begin(), mentioned.end(),
                                      [&](Index c) { return s_.coordinates[idx(c)].role == Role::unknown; });
      if (solves) {
        p_.equations.push_back(e);
      } else {
        doubtful_.equations.push_back(e);
        out_.checks.push_back(e);
        out_.redundant.push_back({{s_.equation_name(e)}, s_.equation_name(e)});
        if (relative_residual(e) > kConsistent) contradiction({s_.equation_name(e)}, relative_residual(e), {&e, 1});
      }
    }
  }

  void leave_out_idle_parts() {
    IdleParts idle = find_idle_parts(s_, p_.blocks);
    if (idle.unknowns.empty()) return;
    const auto erase = [](std::vector<Index>& from, const std::vector<Index>& these) {
      std::erase_if(from, [&](Index i) { return std::binary_search(these.begin(), these.end(), i); });
    };
    erase(p_.unknowns, idle.unknowns);
    erase(p_.equations, idle.equations);
    p_.blocks = decompose(s_, p_.equations, p_.unknowns);
    out_.notes.insert(out_.notes.end(), idle.notes.begin(), idle.notes.end());
    idle_ = std::move(idle.unknowns);
  }

  [[nodiscard]] double relative_residual(Index e) const {
    const double scale = residual_scale(s_, e, p_.q);
    const double phi = std::abs(residual<double>(s_, e, p_.q));
    return scale > 0 ? phi / scale : phi;
  }

  void contradiction(const std::vector<std::string>& names, double by, std::span<const Index> equations) {
    if (!out_.cannot_assemble.empty()) return;
    const Named named = in_words_of(*s_.scene, names);
    const std::string what = named.joints.empty()   ? "equations"
                             : named.others.empty() ? "joints"
                                                    : "joints and equations";
    out_.cannot_assemble = "these " + what + " contradict each other: ";
    bool is_first = true;
    for (const auto* list : {&named.joints, &named.others}) {
      for (const std::string& name : *list)
        out_.cannot_assemble += (is_first ? "'" : ", '") + name + "'", is_first = false;
    }
    out_.cannot_assemble += " (relative residual " + shortened(by) + "); " + most_violated(s_, equations, p_.q);
  }

  // Returns the blocks whose Jacobian is rank-deficient at the assembled posture.
  std::vector<Index> assemble_blocks() {
    std::vector<Index> singular;
    for (Index b = 0; b < p_.blocks.size(); ++b) {
      const BlockAssembly a = assemble(s_, p_.blocks.equations_of(b), p_.blocks.unknowns_of(b), p_.q, column_);
      if (!a.converged) {
        if (p_.blocks.square()) refuse_block(b);
        singular.push_back(b);
        continue;
      }
      if (a.singular) singular.push_back(b);
      if (a.mode == BlockAssembly::Mode::other) {
        out_.notes.push_back(
            {"/", "group " + block_name(s_, p_.blocks, b) + " was assembled in another mode than its guess"});
      } else if (a.mode == BlockAssembly::Mode::not_decidable) {
        out_.notes.push_back(
            {"/", "group " + block_name(s_, p_.blocks, b) +
                      ": whether it was assembled in the mode of its guess is not decidable, because the guess is "
                      "nearly singular"});
      }
    }
    return singular;
  }

  void refuse_block(Index b) {
    if (!out_.cannot_assemble.empty()) return;
    out_.cannot_assemble = "group " + group_or_block_name(s_, p_.blocks, b) +
                           " cannot be assembled: " + most_violated(s_, p_.blocks.equations_of(b), p_.q);
  }

  // Connected components with a structural surplus or a singular block.
  void study_doubtful_parts(const std::vector<Index>& singular) {
    std::vector<Index> parent(s_.coordinates.size());
    std::iota(parent.begin(), parent.end(), 0);
    const auto root = [&](Index c) {
      while (parent[idx(c)] != c) c = parent[idx(c)] = parent[idx(parent[idx(c)])];
      return c;
    };
    std::vector<Index> mentioned;
    const auto unknowns_in = [&](Index e) {
      s_.mentioned(e, mentioned);
      std::erase_if(mentioned, [&](Index c) { return s_.coordinates[idx(c)].role != Role::unknown; });
    };
    for (const Index e : p_.equations) {
      unknowns_in(e);
      for (const Index c : mentioned) parent[idx(root(c))] = root(mentioned.front());
    }
    std::set<Index> doubtful;
    for (const Index u : p_.blocks.surplus_unknowns) doubtful.insert(root(u));
    for (const Index e : p_.blocks.surplus_equations) {
      unknowns_in(e);
      doubtful.insert(root(mentioned.front()));
    }
    for (const Index b : singular) doubtful.insert(root(p_.blocks.unknowns_of(b).front()));

    std::vector<Index> kept;
    std::unordered_map<Index, std::pair<std::vector<Index>, std::vector<Index>>> parts;
    for (const Index r : doubtful) parts[r];
    for (const Index e : p_.equations) {
      unknowns_in(e);
      const auto part = parts.find(root(mentioned.front()));
      if (part == parts.end()) {
        kept.push_back(e);
      } else {
        part->second.first.push_back(e);
      }
    }
    for (const Index u : p_.unknowns) {
      if (const auto part = parts.find(root(u)); part != parts.end()) part->second.second.push_back(u);
    }
    for (const Index r : doubtful) {
      const auto& [equations, unknowns] = parts[r];
      doubtful_.equations.insert(doubtful_.equations.end(), equations.begin(), equations.end());
      doubtful_.unknowns.insert(doubtful_.unknowns.end(), unknowns.begin(), unknowns.end());
      const auto laws_from = p_.is_guess ? std::optional(p_.time) : std::nullopt;
      take(study_rank(s_, equations, unknowns, laws_from, p_.q, column_), equations, kept);
    }
    std::sort(kept.begin(), kept.end());
    p_.equations = std::move(kept);
    p_.blocks = decompose(s_, p_.equations, p_.unknowns);
    if (out_.undetermined.empty() && out_.cannot_assemble.empty()) assemble_blocks();
  }

  void take(const RankStudy& study, const std::vector<Index>& equations, std::vector<Index>& kept) {
    kept.insert(kept.end(), study.kept.begin(), study.kept.end());
    doubtful_.kept.insert(doubtful_.kept.end(), study.kept.begin(), study.kept.end());
    out_.checks.insert(out_.checks.end(), study.dropped.begin(), study.dropped.end());
    out_.redundant.insert(out_.redundant.end(), study.redundant.begin(), study.redundant.end());
    for (const Index u : study.undetermined) out_.undetermined.push_back(s_.coordinate_name(u));
    if (study.residual > kConsistent) {
      std::vector<std::string> names;
      for (const Redundancy& r : study.redundant) names.insert(names.end(), r.constraints.begin(), r.constraints.end());
      if (names.empty()) {
        for (const Index e : study.kept) names.push_back(s_.equation_name(e));
      }
      std::sort(names.begin(), names.end());
      names.erase(std::unique(names.begin(), names.end()), names.end());
      contradiction(names, study.residual, equations);
    }
    if (study.singular_start && study.undetermined.empty()) {
      out_.notes.push_back(
          {"/", "the start posture is singular: the Jacobian loses rank there, but not elsewhere on the path"});
    }
  }

  // The equations of a frame driven inside a declared group also hold for its mirror image. If all axes are known, no
  // equation checks them.
  void check_frames() {
    for (const Frame& f : s_.frames) {
      if (!out_.cannot_assemble.empty() || !out_.undetermined.empty()) return;
      if (is_idle(f)) continue;
      const FrameAxes axes = frame_axes(s_, f, p_.q);
      const std::string body = "the frame of body " + s_.scene->bodies()[idx(f.body)].name;
      if (axes.mirrored) {
        out_.cannot_assemble =
            body + " was assembled as its mirror image; choose guesses of its vectors nearer to a right-handed frame";
        return;
      }
      if (axes.skew <= kSkew) continue;
      out_.cannot_assemble = body + " does not have perpendicular axes of length 1 in the start posture (error " +
                             shortened(axes.skew) + "); correct its fixed or driven vectors";
    }
  }

  [[nodiscard]] bool is_idle(const Frame& f) const {
    return std::any_of(std::begin(f.item), std::end(f.item), [&](Index item) {
      const Term first = s_.form(s_.items[idx(item)].form[0])[0];
      return std::binary_search(idle_.begin(), idle_.end(), first.coordinate);
    });
  }

  const System& s_;
  Problem& p_;
  Structure& out_;
  std::vector<Index> idle_;  // unknowns that are left out
  DoubtfulParts doubtful_;
  std::vector<Index> column_;  // scratch of DenseBlock
};

// Direction in which an angle turns.
enum class Way : std::uint8_t { shorter, longer };

// Finds the start posture in which every driver has the value of its law. Newton's method from a distant guess may end
// in a posture with another value that satisfies the same equations. Then the drivers are moved to their values step by
// step.
class DrivenStart {
 public:
  DrivenStart(const System& system, Problem& problem, Structure& out)
      : s_(system), p_(problem), out_(out), column_(system.coordinates.size(), -1) {}

  void run() {
    Problem asked = p_;
    Structure described = out_;
    const bool is_meshed = !asked.is_guess || mesh_gears(asked, described);
    Attempt direct = attempt(asked, described, asked.q);
    std::string wrong = is_assembled(direct.out) ? wrong_driver(direct.problem.q) : "";
    const bool may_be_led = asked.is_guess && direct.problem.blocks.square();
    if (may_be_led && (!wrong.empty() || (!direct.out.cannot_assemble.empty() && is_far()))) {
      const auto take = [&](const std::vector<double>& q) {
        Attempt led = attempt(asked, described, q);
        if (!is_assembled(led.out) || !wrong_driver(led.problem.q).empty()) return false;
        direct = std::move(led);
        wrong.clear();
        return true;
      };
      const Blocks blocks = direct.problem.blocks;
      const std::vector<double> found = direct.problem.q;
      const bool has_values = !wrong.empty();
      const bool on_branch = lead_from_guess(blocks, asked.q, Branch::same, take) ||
                             (has_values && lead_from_posture(blocks, found, Branch::same, take));
      if (!on_branch && has_values &&
          (lead_from_guess(blocks, asked.q, Branch::any, take) ||
           lead_from_posture(blocks, found, Branch::any, take))) {
        direct.out.notes.push_back({"/",
                                    "no posture on the branch of the guess has the driver values that the laws give; "
                                    "the start posture is on another branch"});
      }
    }
    if (asked.is_guess && !direct.out.cannot_assemble.empty()) {
      if (std::optional<Attempt> together = attempt_together(asked, described)) direct = std::move(*together);
    }
    p_ = std::move(direct.problem);
    out_ = std::move(direct.out);
    if (out_.cannot_assemble.empty()) {
      out_.cannot_assemble = std::move(wrong);
      check_directions();
    }
    if (is_assembled(out_) ? !(is_meshed && is_same_tooth(asked.q)) : is_out_of_reach_) {
      out_.cannot_assemble =
          "the gears cannot be turned from the posture as written (coordinates 0) to the start posture, so it is "
          "unknown which teeth mesh there; describe a posture nearer to the start posture";
    }
    if (asked.is_guess && is_assembled(out_)) {
      note_farthest_point();
      note_turned_vector();
    }
    if (asked.is_guess && !out_.undetermined.empty() && is_determined_nearby(direct.doubtful)) refuse_dead_centre();
    out_.mobility_at_start = out_.mobility;
    if (asked.is_guess) look_at_other_postures(s_, direct.doubtful, p_.q, p_.time, out_);
  }

 private:
  struct Attempt {
    Problem problem;
    Structure out;
    DoubtfulParts doubtful;
  };

  Attempt attempt(const Problem& problem, const Structure& out, const std::vector<double>& q) const {
    Attempt a{problem, out, {}};
    a.problem.q = q;
    a.doubtful = Start(s_, a.problem, a.out).run();
    return a;
  }

  // Groups are assembled one after the other, so that a rough guess may take the first ones to a posture in which the
  // others do not fit. The least-squares posture of all equations does not: tries again from there.
  std::optional<Attempt> attempt_together(const Problem& asked, const Structure& described) {
    if (asked.unknowns.empty() || asked.unknowns.size() > kLargestNearby) return std::nullopt;
    std::vector<Index> all(s_.equations.size());
    std::iota(all.begin(), all.end(), 0);
    std::vector<double> q = asked.q;
    if (fit(s_, all, asked.unknowns, q, column_) > kConsistent) return std::nullopt;
    Attempt together = attempt(asked, described, q);
    if (!is_assembled(together.out) || !wrong_driver(together.problem.q).empty()) return std::nullopt;
    return together;
  }

  static bool is_assembled(const Structure& out) { return out.cannot_assemble.empty() && out.undetermined.empty(); }

  // ---- checks

  // The first driver whose value differs from that of its law; empty: none.
  [[nodiscard]] std::string wrong_driver(const std::vector<double>& q) const {
    for (const DriverInput& in : s_.inputs) {
      if (!why_undefined(s_, in, q).empty()) continue;  // reported elsewhere
      const std::optional<Mismatch> off = mismatch(s_, in, q);
      if (!off) continue;
      const std::string unit = off->unit.empty() ? "" : " " + off->unit;
      return "driver " + name(in) + ": in the start posture its " + off->what + " is " + precise(off->has) + unit +
             ", but its law gives " + precise(off->wanted) + unit + "; choose a guess nearer to that value";
    }
    return "";
  }

  void check_directions() {
    std::string why = undefined_driver(s_, p_.q);
    if (!why.empty()) {
      out_.undetermined.clear();
    } else if (out_.undetermined.empty()) {
      why = wrong_axis(s_, p_.q);
    }
    if (!why.empty()) out_.cannot_assemble = std::move(why);
  }

  // True if the item depends on an unknown.
  [[nodiscard]] bool is_unknown(const Item& item) const {
    return std::any_of(item.form, item.form + item.components, [&](Index form) {
      const auto terms = s_.form(form);
      return std::any_of(terms.begin(), terms.end(),
                         [&](const Term& t) { return s_.coordinates[idx(t.coordinate)].role == Role::unknown; });
    });
  }

  [[nodiscard]] Triple found(const Item& item) const {
    Triple at{};
    for (int k = 0; k < item.components; ++k) {
      at[static_cast<std::size_t>(k)] = form_value<double>(s_, item.form[k], p_.q);
    }
    return at;
  }

  // Reports the point that is farthest from its guess.
  void note_farthest_point() {
    const Point* most = nullptr;
    Triple where{};
    double farthest = kMovedFar * s_.unit(1);
    for (const Point& point : s_.scene->points()) {
      const Item& item = s_.item(point.name);
      if (!is_unknown(item)) continue;
      Triple at = found(item);
      for (double& a : at) a *= s_.unit(1);
      const double moved = triple::norm(triple::subtract(at, point.at));
      if (!(moved > farthest)) continue;
      farthest = moved;
      most = &point;
      where = at;
    }
    if (most == nullptr) return;
    const auto written = [&](const Triple& at) {
      return "(" + precise(at[0]) + ", " + precise(at[1]) + (s_.dimension == 3 ? ", " + precise(at[2]) : "") + ") m";
    };
    out_.notes.push_back({"/points/" + most->name, "the start posture is far from the guess: " + most->name +
                                                       " moved most, by " + shortened(farthest) + " m, from " +
                                                       written(most->at) + " to " + written(where)});
  }

  // Reports the vector with the largest angle to its guess, if that exceeds a right angle.
  void note_turned_vector() {
    const Vector* most = nullptr;
    double least = 0;  // cosine
    for (const Vector& vector : s_.scene->vectors()) {
      const Item& item = s_.item(vector.name);
      if (!is_unknown(item)) continue;
      const Triple at = found(item);
      const double cosine = triple::dot(at, vector.at) / (triple::norm(at) * triple::norm(vector.at));
      if (!(cosine < least)) continue;
      least = cosine;
      most = &vector;
    }
    if (most == nullptr) return;
    out_.notes.push_back({"/vectors/" + most->name, "the start posture is far from the guess: " + most->name +
                                                        " turned most, by " +
                                                        shortened(std::acos(std::max(least, -1.0))) + " rad"});
  }

  [[nodiscard]] const std::string& name(const DriverInput& in) const { return s_.drivers[idx(in.driver)]; }

  // True if nothing is undetermined after a small displacement of the drivers: the posture is singular, not the scene.
  bool is_determined_nearby(const DoubtfulParts& parts) {
    std::vector<Index> equations, mentioned, inputs(s_.inputs.size());
    std::copy_if(parts.equations.begin(), parts.equations.end(), std::back_inserter(equations), [&](Index e) {
      s_.mentioned(e, mentioned);
      return std::any_of(mentioned.begin(), mentioned.end(),
                         [&](Index c) { return s_.coordinates[idx(c)].role == Role::unknown; });
    });
    if (std::max(equations.size(), parts.unknowns.size()) > kLargestNearby) return false;
    std::iota(inputs.begin(), inputs.end(), 0);
    const Freedoms freedoms(s_, inputs);
    const DenseBlock block(s_, equations, parts.unknowns, column_);
    for (const double by : {kNearby, -kNearby}) {
      if (freedoms.count() == 0) return false;
      std::vector<double> q = p_.q;
      freedoms.move(std::vector<double>(freedoms.count(), by), q);
      if (fit(s_, equations, parts.unknowns, q, column_) > kConsistent) continue;
      Eigen::MatrixXd j = block.jacobian(q);
      for (Eigen::Index i = 0; i < j.rows(); ++i) j.row(i).normalize();
      Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(j.rows(), j.cols());
      qr.setThreshold(kDependentNearby);
      if (qr.compute(j).rank() == j.cols()) return true;
    }
    return false;
  }

  void refuse_dead_centre() {
    std::string names;
    for (std::size_t i = 0; i < std::min(out_.undetermined.size(), kMostRedundantNamed); ++i) {
      names += (i == 0 ? "" : ", ") + out_.undetermined[i];
    }
    if (out_.undetermined.size() > kMostRedundantNamed) names += ", ...";
    out_.undetermined.clear();
    out_.cannot_assemble = "the start posture is singular (a dead centre): the Jacobian does not determine " + names +
                           ", though it does at nearby postures; start with other values of the drivers";
  }

  // ---- another way to the start

  [[nodiscard]] DriverValues values(const std::vector<double>& q, bool own) const {
    DriverValues out;
    for (const DriverInput& in : s_.inputs) out.push_back(own ? own_values(s_, in, q) : wanted_values(s_, in, q));
    return out;
  }

  [[nodiscard]] DriverValues written() const {
    DriverValues out;
    for (const DriverInput& in : s_.inputs) out.push_back(in.written);
    return out;
  }

  [[nodiscard]] bool is_far() const {
    const DriverValues from = written(), to = values(p_.q, false);
    for (std::size_t i = 0; i < s_.inputs.size(); ++i) {
      for (const double d : difference(s_, s_.inputs[i], from[i], to[i])) {
        if (std::abs(d) > kFarFromWritten * std::min(1.0, s_.unit(1))) return true;
      }
    }
    return false;
  }

  // The changes of the drivers from the posture as written to the start, in the form of DriverValues. Coordinates of
  // joints count whole turns; other angles turn the shorter way.
  DriverValues counted_change(const DriverValues& from, double time, Structure& out) const {
    const DriverValues wanted = values(p_.q, false);
    DriverValues change;
    for (std::size_t i = 0; i < s_.inputs.size(); ++i) {
      const DriverInput& in = s_.inputs[i];
      change.push_back(difference(s_, in, wanted[i], from[i]));
      for (std::size_t k = 0; k < change[i].size(); ++k) {
        if (!is_angle(s_, in, k)) continue;
        const double counted = in.laws[k](time).value - from[i][k];
        if (s_.scene->drivers()[idx(in.driver)].sets_difference) {
          change[i][k] = counted;
        } else if (std::abs(counted) > std::numbers::pi) {
          out.notes.push_back({"/drivers/" + name(in),
                               "the driver does not count whole turns, so it turns the gears by " +
                                   precise(change[i][k]) + " rad from the posture as written to the start, not by " +
                                   precise(counted) + " rad; drive the coordinate of a joint to count them"});
        }
      }
    }
    return change;
  }

  // Turns the gears from the posture as written to the start with all turns counted: the equation of a gear also holds
  // at other teeth. Other groups that cannot follow keep their guesses. False if the gears cannot be turned to the
  // start.
  bool mesh_gears(Problem& asked, Structure& described) {
    if (!gearing(s_).count_turns) return true;
    const DriverValues from = written();
    DriverValues change = counted_change(from, asked.time, described);
    const auto is_small = [](double by) { return std::abs(by) <= kAsWritten; };
    if (std::all_of(change.begin(), change.end(),
                    [&](const auto& all) { return std::all_of(all.begin(), all.end(), is_small); })) {
      return true;
    }
    std::vector<double> q = asked.q;
    drive_by_values(s_, from, q);
    const Attempt as_written = attempt(asked, described, q);
    const Blocks& all = as_written.problem.blocks;
    if (!all.square()) return false;
    const Blocks gears = blocks_of_gears(s_, all);
    skip_periods(gears, as_written.problem.q, from, change);
    const auto reach = [&](const Blocks& blocks, Branch branch) {
      q = as_written.problem.q;
      return approach(s_, blocks, from, change, branch, q, column_);
    };
    if (!reach(all, Branch::same) && !reach(gears, Branch::same) && !reach(gears, Branch::any)) {
      is_out_of_reach_ = is_assembled(as_written.out);
      return false;
    }
    geared_ = gears.unknowns;
    for (const Index u : geared_) asked.q[idx(u)] = q[idx(u)];
    return true;
  }

  // Subtracts from `change` whole turns of single drivers that leave the posture of the gears unchanged.
  void skip_periods(const Blocks& gears, const std::vector<double>& start, const DriverValues& from,
                    DriverValues& change) {
    constexpr double kTurn = 2 * std::numbers::pi;
    for (std::size_t i = 0; i < change.size(); ++i) {
      for (std::size_t k = 0; k < change[i].size(); ++k) {
        const double turns = is_angle(s_, s_.inputs[i], k) ? std::floor(std::abs(change[i][k]) / kTurn) : 0;
        if (turns < kManyTurns) continue;
        DriverValues turn = change;
        for (std::vector<double>& all : turn) std::fill(all.begin(), all.end(), 0.0);
        turn[i][k] = std::copysign(kTurn, change[i][k]);
        std::vector<double> q = start;
        const auto is_back = [&](Index u) { return std::abs(q[idx(u)] - start[idx(u)]) <= kSameTooth; };
        for (int period = 1; period <= kLongestPeriod && period <= turns; ++period) {
          if (!approach(s_, gears, from, turn, Branch::same, q, column_)) break;
          if (!std::all_of(gears.unknowns.begin(), gears.unknowns.end(), is_back)) continue;
          change[i][k] = std::fmod(change[i][k], period * kTurn);
          break;
        }
      }
    }
  }

  // True if the unknowns of the gears have the values `led`, which mesh_gears() found.
  [[nodiscard]] bool is_same_tooth(const std::vector<double>& led) const {
    return std::all_of(geared_.begin(), geared_.end(),
                       [&](Index u) { return std::abs(p_.q[idx(u)] - led[idx(u)]) <= kSameTooth; });
  }

  // Stays on the branch of the guess: first assembles with the values of the drivers in the scene.
  template <class Take>
  bool lead_from_guess(const Blocks& blocks, std::vector<double> q, Branch branch, Take&& take) {
    const DriverValues from = written(), to = values(q, false);
    drive_by_values(s_, from, q);
    for (Index b = 0; b < blocks.size(); ++b) {
      if (!assemble(s_, blocks.equations_of(b), blocks.unknowns_of(b), q, column_).converged) return false;
    }
    return lead(blocks, from, to, q, branch, take);
  }

  // Starts from the posture with wrong values, which solves the equations for these values.
  template <class Take>
  bool lead_from_posture(const Blocks& blocks, std::vector<double> q, Branch branch, Take&& take) {
    const DriverValues from = values(q, true), to = values(q, false);
    for (const Positive& p : s_.positive) q[idx(p.coordinate)] = std::abs(q[idx(p.coordinate)]);
    return lead(blocks, from, to, q, branch, take);
  }

  // Tries the shorter way round first, then the longer way for each driver that turns by more than a right angle, then
  // for all of them.
  template <class Take>
  bool lead(const Blocks& blocks, const DriverValues& from, const DriverValues& to, const std::vector<double>& q,
            Branch branch, Take&& take) {
    const std::vector<Way> shorter(s_.inputs.size(), Way::shorter);
    std::vector<std::vector<Way>> ways = {shorter};
    std::vector<Way> all = shorter;
    for (std::size_t i = 0; i < s_.inputs.size() && ways.size() <= kMostFlips; ++i) {
      const DriverInput& in = s_.inputs[i];
      if (in.kind != DriverInput::Kind::direction) continue;
      if (!(std::abs(difference(s_, in, to[i], from[i])[0]) > std::numbers::pi / 2)) continue;
      ways.push_back(shorter);
      ways.back()[i] = all[i] = Way::longer;
    }
    if (ways.size() > 2) ways.push_back(all);
    return std::any_of(ways.begin(), ways.end(), [&](const std::vector<Way>& way) {
      DriverValues change;
      for (std::size_t i = 0; i < way.size(); ++i) {
        const DriverInput& in = s_.inputs[i];
        change.push_back(difference(s_, in, to[i], from[i]));
        for (std::size_t k = 0; k < change[i].size(); ++k) {
          if (way[i] == Way::longer && is_angle(s_, in, k)) {
            change[i][k] -= std::copysign(2 * std::numbers::pi, change[i][k]);
          }
        }
      }
      std::vector<double> led = q;
      return approach(s_, blocks, from, change, branch, led, column_) && take(led);
    });
  }

  const System& s_;
  Problem& p_;
  Structure& out_;
  bool is_out_of_reach_ = false;  // the gears mesh in the posture as written, but no way leads to the start
  std::vector<Index> geared_;     // unknowns of the gears and of the blocks that they read
  std::vector<Index> column_;     // scratch of DenseBlock
};

}  // namespace

void assemble_start(const System& system, Problem& problem, Structure& out) { DrivenStart(system, problem, out).run(); }

}  // namespace assur
