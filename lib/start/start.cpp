#include "start/start.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <numbers>
#include <numeric>
#include <optional>
#include <unordered_map>
#include <utility>

#include "decimal.hpp"
#include "decompositions.hpp"
#include "equations/dense_block.hpp"
#include "equations/outputs.hpp"
#include "equations/own_values.hpp"
#include "equations/residual_scale.hpp"
#include "graph/block_names.hpp"
#include "graph/demand.hpp"
#include "graph/freedoms.hpp"
#include "index.hpp"
#include "scene/names.hpp"
#include "scene/triple.hpp"
#include "start/assembly.hpp"
#include "start/directions.hpp"
#include "start/frame_axes.hpp"
#include "start/gearing.hpp"
#include "start/other_postures.hpp"
#include "start/posture_study.hpp"
#include "start/rank.hpp"
#include "start/redundant_sets.hpp"
#include "start/walk.hpp"
#include "start/walk_path.hpp"

namespace assur {
namespace {

constexpr double kSamePosture = 1e-6;  // internal units; another tooth turns a wheel by more than 2 pi / 1000
// The search for the period of a driver. Measured: a geared five-bar that starts after 1000 turns is ready after 0.02 s
// instead of 5.9 s, and a slider-crank after 10,000 turns would be refused. A search that finds nothing, as for gears
// with the ratio 100/41, takes as long as the first 10 turns of the way.
constexpr double kManyTurns = 8;    // before the period is sought; a choice
constexpr int kLongestPeriod = 50;  // turns; a choice
constexpr int kMostSought = 20000;  // steps; a fifth of kMostWalkedSteps
constexpr std::size_t kMostRedundantNamed = 12, kMostDriversNamed = 6, kMostPointsNamed = 4;  // a line or two each

// A point that moves farther than this from its guess to the start posture is reported; internal units. Typical
// lengths are 1 to 2, and guesses by eye are within half of a length.
constexpr double kMovedFar = 0.75;

std::string shortened(double value) { return general(value, 3); }
std::string precise(double value) { return general(value, 6); }

// Finds the start posture: closes the posture as written, with the drivers held at the values that they have there,
// and then moves all drivers together to the values of their laws. Both are followed like a motion.
class DrivenStart {
 public:
  DrivenStart(const System& system, Problem& problem, StartFindings& out)
      : s_(system), p_(problem), out_(out), column_(system.coordinates.size(), -1) {}

  void run() {
    const bool is_guess = p_.is_guess;
    Attempt found = is_guess ? from_guess() : attempt(p_, out_, p_.q);
    p_ = std::move(found.problem);
    out_ = std::move(found.out);
    if (out_.cannot_assemble.empty()) {
      if (is_assembled(out_)) out_.cannot_assemble = wrong_driver(p_.q);
      check_directions();
    }
    if (is_guess && is_assembled(out_)) {
      note_farthest_point();
      note_turned_vector();
    }
    if (is_guess && !out_.undetermined.empty() && is_determined_nearby(found.doubtful, p_.q)) refuse_dead_centre();
    out_.mobility_at_start = out_.mobility;
    if (is_guess) look_at_other_postures(s_, found.doubtful, p_.q, p_.time, out_);
  }

 private:
  struct Attempt {
    Problem problem;
    StartFindings out;
    DoubtfulParts doubtful;
  };

  Attempt attempt(const Problem& problem, const StartFindings& out, const std::vector<double>& q) const {
    Attempt a{problem, out, {}};
    a.problem.q = q;
    a.doubtful = study_posture(s_, a.problem, a.out);
    return a;
  }

  // At other values of the drivers than those of the laws.
  Attempt attempt_beside(const std::vector<double>& q) const {
    Problem beside = p_;
    beside.is_guess = false;
    return attempt(beside, out_, q);
  }

  // ---- from the posture as written to the start

  Attempt from_guess() {
    const std::vector<double> at_laws = p_.q;
    WalkPath way = way_to_laws(s_, at_laws, p_.time);
    const bool moves = is_moving(s_, way);
    note_drivers(way);
    std::vector<double> q = at_laws;
    if (moves) drive_by_values(s_, way.from, q);
    if (!moves && is_closed(q)) return attempt(p_, out_, q);
    const std::vector<double> written = q;
    std::vector<WalkedPart> parts = walked_parts(q);
    if (!close(s_, parts, q)) {
      std::optional<Attempt> closed = search(written);
      if (!closed) return searched_at(at_laws, moves);
      q = closed->problem.q;
      note_search(written, q, moves ? "the drivers held" : "the drivers at their laws", closed->out);
      if (!moves) return std::move(*closed);
      out_.notes = std::move(closed->out.notes);
    }
    if (!moves) {
      Attempt closed = attempt(p_, out_, q);
      return is_assembled(closed.out) || !closed.out.undetermined.empty() ? std::move(closed)
                                                                          : searched_at(at_laws, true);
    }
    // The drivers can only be moved from a posture that determines all unknowns.
    const bool is_redundant = !is_regular(parts);
    if (!undefined_driver(s_, q).empty() || (is_redundant && !choose(q, parts))) return searched_at(at_laws, true);
    const std::string refusal = move(way, parts, is_redundant, q);
    if (!refusal.empty()) return refused(at_laws, refusal);
    p_.q = with_unknowns_of(q);  // parts left behind stay where they are
    Attempt arrived = attempt(p_, out_, p_.q);
    if (!is_assembled(arrived.out) || is_same(arrived.problem.q, q)) return arrived;
    return refused(at_laws, "the start posture is singular, so that the way to it does not determine it");
  }

  [[nodiscard]] bool is_closed(const std::vector<double>& q) {
    std::vector<Index> all(s_.equations.size());
    std::iota(all.begin(), all.end(), 0);
    return DenseBlock(s_, all, p_.unknowns, column_).relative_residual(q) <= kSatisfied;
  }

  // Any posture with the values of the laws, without a way to it.
  Attempt searched_at(const std::vector<double>& at_laws, bool notes) {
    std::optional<Attempt> found = search(at_laws);
    if (!found) return attempt(p_, out_, at_laws);
    if (notes) note_search(at_laws, found->problem.q, "the drivers at their laws", found->out);
    return std::move(*found);
  }

  void note_drivers(const WalkPath& way) {
    for (std::size_t i = 0; i < s_.inputs.size(); ++i) {
      const DriverInput& in = s_.inputs[i];
      const auto has_none = [](double x) { return std::isnan(x); };
      if (std::any_of(in.written.begin(), in.written.end(), has_none)) {
        out_.notes.push_back({"/drivers/" + name(in),
                              "the driver has no value in the posture as written, so it has the value of its law at "
                              "once"});
      }
      if (!count_turns(s_) || s_.scene->drivers()[idx(in.driver)].sets_difference) continue;
      for (std::size_t k = 0; k < in.laws.size(); ++k) {
        const double counted = in.laws[k](p_.time).value - way.from[i][k];
        if (!is_angle(s_, in, k) || !(std::abs(counted) > std::numbers::pi)) continue;
        out_.notes.push_back({"/drivers/" + name(in),
                              "the driver does not count whole turns, so it turns the gears by " +
                                  precise(way.change[i][k]) + " rad from the posture as written to the start, not by " +
                                  precise(counted) + " rad; drive the coordinate of a joint to count them"});
      }
    }
  }

  // Blocks, and connected parts with more equations than unknowns. Parts with fewer equations stay as they are.
  std::vector<WalkedPart> walked_parts(const std::vector<double>& q) const {
    Problem p = p_;
    StartFindings ignored = out_;
    p.q = q;
    divide(s_, p, ignored);
    std::vector<Index> parent(s_.coordinates.size()), mentioned;
    std::iota(parent.begin(), parent.end(), 0);
    const auto root = [&](Index c) {
      while (parent[idx(c)] != c) c = parent[idx(c)] = parent[idx(parent[idx(c)])];
      return c;
    };
    std::vector<Index> first(p.equations.size());
    for (std::size_t i = 0; i < p.equations.size(); ++i) {
      s_.mentioned(p.equations[i], mentioned);
      std::erase_if(mentioned, [&](Index c) { return s_.coordinates[idx(c)].role != Role::unknown; });
      first[i] = mentioned.front();
      for (const Index c : mentioned) parent[idx(root(c))] = root(mentioned.front());
    }
    std::vector<std::uint8_t> is_free(parent.size(), 0), is_surplus(parent.size(), 0);
    for (const Index u : p.blocks.surplus_unknowns) is_free[idx(root(u))] = 1;
    for (const Index u : p.blocks.over_unknowns) is_surplus[idx(root(u))] = 1;
    std::vector<WalkedPart> parts;
    for (Index b = 0; b < p.blocks.size(); ++b) {
      const auto equations = p.blocks.equations_of(b), unknowns = p.blocks.unknowns_of(b);
      const Index r = root(unknowns.front());
      if (is_free[idx(r)] != 0 || is_surplus[idx(r)] != 0) continue;
      parts.push_back({{equations.begin(), equations.end()}, {unknowns.begin(), unknowns.end()}});
    }
    std::unordered_map<Index, std::size_t> place;
    const auto part_of = [&](Index c) -> WalkedPart* {
      const Index r = root(c);
      if (is_free[idx(r)] != 0 || is_surplus[idx(r)] == 0) return nullptr;
      const auto [at, is_new] = place.emplace(r, parts.size());
      if (is_new) parts.emplace_back();
      return &parts[at->second];
    };
    for (const Index u : p.unknowns) {
      if (WalkedPart* part = part_of(u)) part->unknowns.push_back(u);
    }
    for (std::size_t i = 0; i < p.equations.size(); ++i) {
      if (WalkedPart* part = part_of(first[i])) part->equations.push_back(p.equations[i]);
    }
    return parts;
  }

  // Marks the parts on which neither an output nor a limit, a driver or a declared group that is kept depends.
  void mark_needed(std::vector<WalkedPart>& parts) const {
    std::vector<std::int8_t> need = needed_by_outputs(s_, wanted_outputs(s_));
    const std::vector<std::int8_t> of_limits =
        s_.bounds.empty() ? std::vector<std::int8_t>(need.size(), -1) : needed_by_outputs(s_, limited_outputs(s_));
    for (std::size_t c = 0; c < need.size(); ++c) need[c] = std::max(need[c], of_limits[c]);
    const auto require = [&](Index c) { need[idx(c)] = std::max(need[idx(c)], std::int8_t{0}); };
    for (const Positive& p : s_.positive) require(p.coordinate);
    for (const DriverInput& in : s_.inputs) {
      for (const Index form : in.own) {
        for (const Term& t : s_.form(form)) require(t.coordinate);
      }
    }
    for (const SystemGroup& g : s_.groups) {
      if (g.keep) std::for_each(g.unknowns.begin(), g.unknowns.end(), require);
    }
    for (auto part = parts.rbegin(); part != parts.rend(); ++part) {
      const auto is_read = [&](Index u) { return need[idx(u)] >= 0; };
      part->is_needed = std::any_of(part->unknowns.begin(), part->unknowns.end(), is_read);
      if (part->is_needed) require_inputs(s_, part->equations, 0, need);
    }
  }

  // Finds any posture with these values of the drivers: block after block by damped steps, else all equations together
  // by least squares, because a rough guess may take the first groups to a posture in which the others do not fit.
  std::optional<Attempt> search(const std::vector<double>& guess) {
    const auto take = [&](const std::vector<double>& q) -> std::optional<Attempt> {
      Attempt a = guess == p_.q ? attempt(p_, out_, q) : attempt_beside(q);
      if (!is_assembled(a.out) || !wrong_driver(a.problem.q).empty()) return std::nullopt;
      return a;
    };
    if (std::optional<Attempt> found = take(guess)) return found;
    if (p_.unknowns.empty() || p_.unknowns.size() > kLargestDenseRank) return std::nullopt;
    std::vector<Index> all(s_.equations.size());
    std::iota(all.begin(), all.end(), 0);
    std::vector<double> q = guess;
    if (fit(s_, all, p_.unknowns, q, column_) > kConsistent) return std::nullopt;
    return take(q);
  }

  void note_search(const std::vector<double>& from, const std::vector<double>& to, const std::string& values,
                   StartFindings& out) const {
    Index most = -1;
    double farthest = 0;
    for (const Index u : p_.unknowns) {
      const double moved = std::abs(to[idx(u)] - from[idx(u)]);
      if (moved > farthest) farthest = moved, most = u;
    }
    if (most < 0) return;
    const Coordinate& c = s_.coordinates[idx(most)];
    out.notes.push_back({"/",
                         "the posture as written cannot be closed in small steps, because it or a posture on the "
                         "way is singular; a search with " +
                             values + " closed it: " + s_.items[idx(c.item)].name + " moved most, by " +
                             shortened(farthest * s_.unit(c.dimension)) + (c.dimension == 1 ? " m" : "")});
  }

  // True if every unknown is in a part that has as many equations as unknowns.
  [[nodiscard]] bool is_regular(const std::vector<WalkedPart>& parts) const {
    std::size_t unknowns = 0;
    for (const WalkedPart& p : parts) unknowns += p.unknowns.size() == p.equations.size() ? p.unknowns.size() : 0;
    return unknowns == p_.unknowns.size();
  }

  // Moves q along the way. Returns the reason why that is impossible; "": q is there.
  std::string move(WalkPath way, std::vector<WalkedPart> parts, bool is_redundant, std::vector<double>& q) {
    double share = 0, chosen_at = -1;
    mark_needed(parts);
    skip_periods(parts, q, way);
    for (;;) {
      way.passes = !is_redundant || chosen_at == share;
      const Walked w = walk(s_, parts, way, q);
      const double left = 1 - share;
      for (const Walked::ChangePoint& c : w.passed) {
        out_.notes.push_back({"/", "on the way from the posture as written to the start, group " +
                                       group(parts[c.part]) + " passes a change point at " +
                                       percent(share + left * c.share) +
                                       " of the way; the start posture is on the smooth continuation"});
      }
      share += left * w.share;
      if (w.end == Walked::End::arrived) {
        leave_behind(w, parts);
        return "";
      }
      for (std::size_t i = 0; i < way.from.size(); ++i) {
        for (std::size_t k = 0; k < way.from[i].size(); ++k) {
          way.from[i][k] += w.share * way.change[i][k];
          way.change[i][k] *= 1 - w.share;
        }
      }
      if (!(is_redundant && chosen_at != share && w.end == Walked::End::singular && choose(q, parts))) {
        return reason(w, parts, way, share);
      }
      chosen_at = share;
    }
  }

  void leave_behind(const Walked& w, const std::vector<WalkedPart>& parts) {
    for (const std::size_t k : w.left) {
      p_.left_behind.insert(p_.left_behind.end(), parts[k].unknowns.begin(), parts[k].unknowns.end());
      out_.notes.push_back({"/", "group " + group(parts[k]) +
                                     " cannot follow the drivers from the posture as written to the start; it is left "
                                     "out, because no output depends on it"});
    }
    std::sort(p_.left_behind.begin(), p_.left_behind.end());
  }

  // Chooses independent equations at a posture.
  bool choose(const std::vector<double>& q, std::vector<WalkedPart>& parts) const {
    const Attempt a = attempt_beside(q);
    const Blocks& blocks = a.problem.blocks;
    if (!is_assembled(a.out) || !blocks.square() || !is_same(a.problem.q, q)) return false;
    parts.clear();
    for (Index b = 0; b < blocks.size(); ++b) {
      const auto equations = blocks.equations_of(b), unknowns = blocks.unknowns_of(b);
      parts.push_back({{equations.begin(), equations.end()}, {unknowns.begin(), unknowns.end()}});
    }
    mark_needed(parts);
    return true;
  }

  // Subtracts whole turns of a driver after which the posture is the same: the driver alone, or gears.
  void skip_periods(const std::vector<WalkedPart>& parts, const std::vector<double>& start, WalkPath& way) const {
    const bool has_gears = count_turns(s_);
    std::size_t moving = 0;
    for (const std::vector<double>& all : way.change) {
      moving += static_cast<std::size_t>(std::count_if(all.begin(), all.end(), [](double c) { return c != 0; }));
    }
    if (moving > 1 && !has_gears) return;
    const std::vector<WalkedPart> turned = has_gears ? parts_of_gears(s_, parts) : parts;
    for (std::size_t i = 0; i < way.change.size(); ++i) {
      for (std::size_t k = 0; k < way.change[i].size(); ++k) {
        double& change = way.change[i][k];
        const double turns = is_angle(s_, s_.inputs[i], k) ? std::floor(std::abs(change) / kTurn) : 0;
        if (turns < kManyTurns) continue;
        WalkPath turn = way;
        for (std::vector<double>& all : turn.change) std::fill(all.begin(), all.end(), 0.0);
        turn.change[i][k] = std::copysign(kTurn, change);
        std::vector<double> q = start;
        const auto is_back = [&](Index u) { return std::abs(q[idx(u)] - start[idx(u)]) <= kSamePosture; };
        const auto all_back = [&](const WalkedPart& p) {
          return std::all_of(p.unknowns.begin(), p.unknowns.end(), is_back);
        };
        int steps = 0;
        for (int period = 1; period <= kLongestPeriod && period <= turns && steps < kMostSought; ++period) {
          const Walked w = walk(s_, turned, turn, q);
          steps += w.steps;
          if (w.end != Walked::End::arrived) break;
          if (!std::all_of(turned.begin(), turned.end(), all_back)) continue;
          change = std::fmod(change, period * kTurn);
          break;
        }
      }
    }
  }

  // The unknowns of q and the drivers of the laws.
  [[nodiscard]] std::vector<double> with_unknowns_of(const std::vector<double>& q) const {
    std::vector<double> at = p_.q;
    for (const Index u : p_.unknowns) at[idx(u)] = q[idx(u)];
    return at;
  }

  [[nodiscard]] bool is_same(const std::vector<double>& a, const std::vector<double>& b) const {
    return std::all_of(p_.unknowns.begin(), p_.unknowns.end(),
                       [&](Index u) { return std::abs(a[idx(u)] - b[idx(u)]) <= kSamePosture; });
  }

  // ---- refusals

  [[nodiscard]] std::string group(const WalkedPart& part) const {
    Blocks one;
    one.equations = part.equations;
    one.unknowns = part.unknowns;
    one.start.push_back(static_cast<Index>(part.unknowns.size()));
    return group_or_block_name(s_, one, 0);
  }

  static std::string percent(double share) { return shortened(100 * share) + " %"; }

  // "m = 0.3 rad, hand.x = 1 m"
  [[nodiscard]] std::string values_in_words(const DriverValues& values) const {
    std::string text;
    for (std::size_t i = 0; i < values.size() && i < kMostDriversNamed; ++i) {
      const DriverInput& in = s_.inputs[i];
      for (std::size_t k = 0; k < values[i].size(); ++k) {
        const std::string part =
            in.kind == DriverInput::Kind::frame ? std::string(".") + pose_part(k, s_.dimension) : "";
        const std::string unit = is_angle(s_, in, k) ? " rad" : in.dimension == 1 ? " m" : "";
        text += (text.empty() ? "" : ", ") + name(in) + part + " = " + precise(values[i][k]) + unit;
      }
    }
    return values.size() > kMostDriversNamed ? text + ", ..." : text;
  }

  [[nodiscard]] std::string reason(const Walked& w, const std::vector<WalkedPart>& parts, const WalkPath& way,
                                   double share) const {
    const std::string where =
        "at " + percent(share) + " of the way from the posture as written (" + values_in_words(way.from) + ")";
    switch (w.end) {
      case Walked::End::vanished:
        return "the start posture cannot be reached: " + where + ", driver " + s_.drivers[idx(w.driver)] +
               " has no value, because its direction or distance vanishes";
      case Walked::End::too_long:
        return "the start posture cannot be reached: the way from the posture as written takes more than " +
               std::to_string(kMostWalkedSteps) + " steps";
      default:
        return "the start posture cannot be reached: " + where + ", group " + group(parts[w.part]) +
               " meets a fold or another singular posture";
    }
  }

  // If there is another posture with the values of the laws, tells how to start there.
  Attempt refused(const std::vector<double>& at_laws, std::string why) {
    if (count_turns(s_)) why += "; the way decides which teeth of the gears mesh";
    std::optional<Attempt> other = search(at_laws);
    if (other && !undefined_driver(s_, other->problem.q).empty()) other.reset();
    Attempt a = other ? std::move(*other) : attempt(p_, out_, at_laws);
    // Equations that repeat others everywhere leave no way.
    const bool is_posture = !other && a.out.cannot_assemble.empty() && !a.out.undetermined.empty();
    if (is_posture && !is_determined_nearby(a.doubtful, a.problem.q)) return a;
    a.out.undetermined.clear();
    const std::string unassembled = std::exchange(a.out.cannot_assemble, why);
    if (!other) {
      a.out.cannot_assemble +=
          "; no posture with the values of the laws was found" + (unassembled.empty() ? "" : ": " + unassembled);
      return a;
    }
    a.out.cannot_assemble += "; another posture has the values of the laws";
    std::size_t named = 0;
    for (const Point& point : s_.scene->points()) {
      const Item& item = s_.item(point.name);
      if (!is_unknown(item) || named == kMostPointsNamed) continue;
      Triple there = at(item, a.problem.q);
      for (Number& x : there) x *= s_.unit(1);
      a.out.cannot_assemble +=
          (named++ == 0 ? "; to start there, write " : ", ") + point.name + " at " + in_words(there);
    }
    return a;
  }

  static bool is_assembled(const StartFindings& out) { return out.cannot_assemble.empty() && out.undetermined.empty(); }

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

  [[nodiscard]] Triple at(const Item& item, const std::vector<double>& q) const {
    Triple at{};
    for (int k = 0; k < item.components; ++k) {
      at[static_cast<std::size_t>(k)] = form_value<double>(s_, item.form[k], q);
    }
    return at;
  }

  // "(1, 2) m"; at: in m.
  [[nodiscard]] std::string in_words(const Triple& at) const {
    return "(" + precise(at[0]) + ", " + precise(at[1]) + (s_.dimension == 3 ? ", " + precise(at[2]) : "") + ") m";
  }

  // Reports the point that is farthest from its guess.
  void note_farthest_point() {
    const Point* most = nullptr;
    Triple where{};
    double farthest = kMovedFar * s_.unit(1);
    for (const Point& point : s_.scene->points()) {
      const Item& item = s_.item(point.name);
      if (!is_unknown(item)) continue;
      Triple now = at(item, p_.q);
      for (Number& x : now) x *= s_.unit(1);
      const double moved = triple::norm(triple::subtract(now, point.at));
      if (!(moved > farthest)) continue;
      farthest = moved;
      most = &point;
      where = now;
    }
    if (most == nullptr) return;
    out_.notes.push_back({"/points/" + most->name, "the start posture is far from the guess: " + most->name +
                                                       " moved most, by " + shortened(farthest) + " m, from " +
                                                       in_words(most->at) + " to " + in_words(where)});
  }

  // Reports the vector with the largest angle to its guess, if that exceeds a right angle.
  void note_turned_vector() {
    const Vector* most = nullptr;
    double least = 0;  // cosine
    for (const Vector& vector : s_.scene->vectors()) {
      const Item& item = s_.item(vector.name);
      if (!is_unknown(item)) continue;
      const Triple now = at(item, p_.q);
      const double cosine = triple::dot(now, vector.at) / (triple::norm(now) * triple::norm(vector.at));
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
  bool is_determined_nearby(const DoubtfulParts& parts, const std::vector<double>& at) {
    std::vector<Index> equations, mentioned, inputs(s_.inputs.size());
    std::copy_if(parts.equations.begin(), parts.equations.end(), std::back_inserter(equations), [&](Index e) {
      s_.mentioned(e, mentioned);
      return std::any_of(mentioned.begin(), mentioned.end(),
                         [&](Index c) { return s_.coordinates[idx(c)].role == Role::unknown; });
    });
    if (std::max(equations.size(), parts.unknowns.size()) > kLargestDenseRank) return false;
    std::iota(inputs.begin(), inputs.end(), 0);
    const Freedoms freedoms(s_, inputs);
    const DenseBlock block(s_, equations, parts.unknowns, column_);
    for (const double by : {kNearby, -kNearby}) {
      if (freedoms.count() == 0) return false;
      std::vector<double> q = at;
      freedoms.move(std::vector<double>(freedoms.count(), by), q);
      if (fit(s_, equations, parts.unknowns, q, column_) > kConsistent) continue;
      Eigen::MatrixXd j = block.jacobian(q);
      for (Eigen::Index i = 0; i < j.rows(); ++i) j.row(i).normalize();
      Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(j.rows(), j.cols());
      qr.setThreshold(kDependentRows);
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

  const System& s_;
  Problem& p_;
  StartFindings& out_;
  std::vector<Index> column_;  // scratch of DenseBlock
};

}  // namespace

void assemble_start(const System& system, Problem& problem, StartFindings& out) {
  DrivenStart(system, problem, out).run();
}

}  // namespace assur
