#include "start/other_postures.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <string>

#include "decimal.hpp"
#include "decompositions.hpp"
#include "equations/dense_block.hpp"
#include "equations/residual_scale.hpp"
#include "graph/freedoms.hpp"
#include "index.hpp"
#include "numbers.hpp"
#include "start/assembly.hpp"
#include "start/rank.hpp"
#include "start/redundant_sets.hpp"

namespace assur {
namespace {
constexpr double kExact = 1e-12;         // rad or internal units: violation of an equation that holds
constexpr double kRefused = 4e-12;       // the same, of a mechanism that is refused, near the origin
constexpr double kRounded = 4 * kEps;    // the same, relative to the coordinates, far from it
constexpr double kSmall = 1e-5;          // the same: larger violations show that equations restrict the drivers
constexpr double kRounding = 32 * kEps;  // relative residual of an equation that holds up to rounding
constexpr double kFarthest = 0.4;        // the same, in strides, for small errors of lengths
constexpr int kTries = 3;                // random directions, and displacements in each; a choice
constexpr double kPathStride = 0.1;      // largest change of a driven coordinate between postures on the path; a choice
constexpr int kStepsElsewhere = 20;      // of Newton's method; a choice: a posture that takes more is not used
constexpr double kNoLongerFalls = 1e-12;     // a residual that no longer falls is rounding
constexpr std::size_t kMostRates = 1 << 24;  // numbers: 128 MiB

// A connected part of the system: equations that share unknowns or drivers.
struct Component {
  std::vector<Index> equations, kept, unknowns, inputs;
  std::vector<std::size_t> checks;  // indices into StartFindings::checks
};

class Union {
 public:
  explicit Union(std::size_t size) : parent_(size) { std::iota(parent_.begin(), parent_.end(), std::size_t{0}); }
  std::size_t root(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::size_t a, std::size_t b) { parent_[root(a)] = root(b); }

 private:
  std::vector<std::size_t> parent_;
};

// The inputs behind each known coordinate.
std::vector<std::vector<std::size_t>> inputs_behind(const System& s) {
  std::vector<std::vector<std::size_t>> behind(s.coordinates.size());
  for (std::size_t i = 0; i < s.inputs.size(); ++i) {
    for (Index k = 0; k < s.inputs[i].count; ++k) behind[idx(s.inputs[i].first + k)] = {i};
  }
  for (const Assignment& a : s.assignments) {
    for (const Term& t : s.form(a.form)) {
      const auto& more = behind[idx(t.coordinate)];
      behind[idx(a.coordinate)].insert(behind[idx(a.coordinate)].end(), more.begin(), more.end());
    }
  }
  return behind;
}

std::vector<Component> connected(const System& s, const DoubtfulParts& all, const std::vector<Index>& checks) {
  const std::size_t coordinates = s.coordinates.size(), inputs = s.inputs.size();
  const std::vector<std::vector<std::size_t>> behind = inputs_behind(s);
  // Nodes: coordinates, then inputs, then equations.
  Union nodes(coordinates + inputs + s.equations.size());
  std::vector<Index> mentioned;
  const auto node_of = [&](Index e) { return coordinates + inputs + idx(e); };
  for (const Index e : all.equations) {
    s.mentioned(e, mentioned);
    for (const Index c : mentioned) {
      if (s.coordinates[idx(c)].role == Role::unknown) nodes.join(node_of(e), idx(c));
      for (const std::size_t i : behind[idx(c)]) nodes.join(node_of(e), coordinates + i);
    }
  }
  std::map<std::size_t, Component> parts;
  for (const Index e : all.equations) parts[nodes.root(node_of(e))].equations.push_back(e);
  for (const Index e : all.kept) parts[nodes.root(node_of(e))].kept.push_back(e);
  for (const Index u : all.unknowns) parts[nodes.root(idx(u))].unknowns.push_back(u);
  for (std::size_t i = 0; i < inputs; ++i) {
    const auto part = parts.find(nodes.root(coordinates + i));
    if (part != parts.end()) part->second.inputs.push_back(static_cast<Index>(i));
  }
  for (std::size_t k = 0; k < checks.size(); ++k) {
    Component& part = parts[nodes.root(node_of(checks[k]))];
    part.checks.push_back(k);
  }
  std::vector<Component> out;
  for (auto& [root, part] : parts) out.push_back(std::move(part));
  return out;
}

class Look {
 public:
  Look(const System& system, const Component& part, const std::vector<double>& start, double time,
       const std::vector<Index>& checks, StartFindings& out, std::set<std::string>& impossible)
      : s_(system),
        p_(part),
        start_(start),
        time_(time),
        checks_(checks),
        out_(out),
        impossible_(impossible),
        freedoms_(system, part.inputs),
        column_(system.coordinates.size(), -1) {
    for (const Index u : part.unknowns) refused_ = std::max(refused_, kRounded * std::abs(start[idx(u)]));
  }

  // Degrees of freedom without the drivers, minus those of the drivers; at most 0 in a determined part.
  struct Mobility {
    std::int64_t at_start = 0, generic = 0;
  };

  Mobility run() {
    if (out_.cannot_assemble.empty() && out_.undetermined.empty()) {
      const bool on_path = walk_the_path();
      const bool near = look_nearby();
      for (const std::size_t k : p_.checks) classify(k, on_path, near);
    }
    return mobility();
  }

 private:
  // ---- do the dropped equations follow from the others?

  struct Seen {
    bool holds = true;
    Violation by;
    double time = 0;
  };

  bool solve(const std::vector<Index>& equations, std::vector<double>& q) {
    return p_.unknowns.empty() || equations.empty() || fit(s_, equations, p_.unknowns, q, column_) <= kConsistent;
  }

  // Violation of an equation by more than rounding.
  [[nodiscard]] bool is_violated(Index e, const std::vector<double>& q) const {
    const double phi = std::abs(residual<double>(s_, e, q));
    return !(phi <= kRounding * std::max(residual_scale(s_, e, q), kLeastScale)) && !(internal(amount(e, q)) <= kExact);
  }

  // The violation; relative to the size of the terms if the gradient nearly vanishes.
  [[nodiscard]] Violation amount(Index e, const std::vector<double>& q) const {
    Violation v = violation(s_, e, q);
    const double phi = std::abs(residual<double>(s_, e, q)) * s_.unit(v.is_length ? 1 : 0);
    if (phi < kLeastScale * v.by) v.by = std::min(v.by, phi / std::max(residual_scale(s_, e, q), kLeastScale));
    return v;
  }

  // Solves the kept equations and examines the dropped ones. Where the kept equations are singular, rounding or another
  // branch may violate the dropped ones; then a nearby posture is used where all equations hold.
  bool look_at(std::vector<double>& q, double time, std::map<std::size_t, Seen>& all) {
    const auto violated = [&](const std::vector<double>& at) { return [&](Index e) { return is_violated(e, at); }; };
    std::vector<double> together = q;
    if (!solve(p_.kept, q) || std::any_of(p_.kept.begin(), p_.kept.end(), violated(q))) return false;
    const auto is_off = [&](std::size_t k) { return is_violated(checks_[k], q); };
    if (std::none_of(p_.checks.begin(), p_.checks.end(), is_off)) return true;
    if (solve(p_.equations, together) && std::none_of(p_.equations.begin(), p_.equations.end(), violated(together))) {
      q = std::move(together);
      return true;
    }
    for (const std::size_t k : p_.checks) {
      if (!is_off(k)) continue;
      Seen& seen = all[k];
      const Violation by = amount(checks_[k], q);
      if (seen.holds || (seen.time == time && by.by > seen.by.by)) seen = {false, by, time};
    }
    return true;
  }

  // Examines the first steps of the grid, in strides short enough to stay on the branch. False if no step could be
  // examined.
  bool walk_the_path() {
    const double step = s_.scene->time().step;
    std::vector<double> q = start_, next;
    double t = time_;
    bool any = false;
    for (int k = 1; k <= kStepsOnPath && step > 0; ++k) {
      const double target = time_ + k * step;
      double h = target - t;
      while (t != target) {
        next = q;
        const double to = std::abs(target - t) <= h * 1.0000001 ? target : t + h;
        if (!drive(s_, to, next.data(), nullptr, nullptr).ok()) return any;
        double stride = 0;
        for (const Index i : p_.inputs) {
          for (Index c = s_.inputs[idx(i)].first; c < s_.inputs[idx(i)].first + s_.inputs[idx(i)].count; ++c) {
            stride = std::max(stride, std::abs(next[idx(c)] - q[idx(c)]));
          }
        }
        if (stride > kPathStride || !look_at(next, to, path_)) {
          if ((h /= 2) < step / 1024) return any;
          continue;
        }
        std::swap(q, next);
        t = to;
        any = true;
      }
    }
    return any;
  }

  // Examines other values of the drivers, near those at the start.
  bool look_nearby() {
    std::mt19937 random(1);
    std::vector<double> amounts(freedoms_.count());
    bool any = amounts.empty();
    for (int k = 0; k < kTries && !amounts.empty(); ++k) {
      double largest = 0;
      for (double& a : amounts) {
        a = 2 * static_cast<double>(random()) / static_cast<double>(std::mt19937::max()) - 1;
        largest = std::max(largest, std::abs(a));
      }
      for (double& a : amounts) a *= kNearby / largest;
      for (int shorter = 0; shorter < kTries; ++shorter) {
        std::vector<double> q = start_;
        freedoms_.move(amounts, q);
        if (look_at(q, time_, near_)) {
          any = true;
          if (shorter == 0) go_farther(amounts, std::move(q));
          break;
        }
        for (double& a : amounts) a /= -8;
      }
    }
    return any;
  }

  // An error of a length of 1e-9 is visible only far from the start posture. A posture there may be on another branch,
  // so large violations do not count.
  void go_farther(std::vector<double> amounts, std::vector<double> q) {
    for (double at = kNearby; 2 * at <= kFarthest; at *= 2) {
      const std::map<std::size_t, Seen> before = near_;
      freedoms_.move(amounts, q);
      if (!look_at(q, time_, near_) || !is_small(near_)) {
        near_ = before;
        return;
      }
      for (double& a : amounts) a *= 2;
    }
  }

  [[nodiscard]] double internal(const Violation& v) const { return v.by / (v.is_length ? s_.unit(1) : 1); }
  bool is_small(const std::map<std::size_t, Seen>& all) const {
    return std::all_of(all.begin(), all.end(), [&](const auto& k) { return internal(k.second.by) <= kSmall; });
  }

  void classify(std::size_t k, bool on_path, bool near) {
    Redundancy& r = out_.redundant[k];
    const Seen path = path_[k], off = near_[k];
    const Seen& shown = !path.holds ? path : off;
    r.kind = !path.holds ? Redundancy::Kind::start
             : !near     ? Redundancy::Kind::unknown
             : off.holds ? Redundancy::Kind::structural
             : on_path   ? Redundancy::Kind::motion
                         : Redundancy::Kind::unknown;
    r.violation = shown.by.by;
    r.is_length = shown.by.is_length;
    r.time = shown.time;
    // Small violations are errors of lengths, see below.
    if (r.kind != Redundancy::Kind::structural && (r.constraints.size() == 1 || internal(shown.by) > kSmall)) {
      name_drivers(r);
    }
    // Errors of lengths cause small violations near the start posture; large violations mean that drivers are
    // restricted.
    const bool is_error = internal(off.by) > refused_ && internal(off.by) <= kSmall;
    const bool never_holds = internal(path.by) > refused_ && path.time <= time_ + s_.scene->time().step;
    if (is_error || never_holds) impossible_.insert(r.dropped);
  }

  // Adds the drivers behind the known coordinates of the dependent equations.
  void name_drivers(Redundancy& r) const {
    const std::vector<std::vector<std::size_t>> behind = inputs_behind(s_);
    const std::set<std::string> equations(r.constraints.begin(), r.constraints.end());
    std::set<std::string> names = equations;
    std::vector<Index> mentioned;
    for (const Index e : p_.equations) {
      if (equations.count(s_.equation_name(e)) == 0) continue;
      s_.mentioned(e, mentioned);
      for (const Index c : mentioned) {
        for (const std::size_t i : behind[idx(c)]) names.insert("driver " + s_.drivers[idx(s_.inputs[i].driver)]);
      }
    }
    r.constraints.assign(names.begin(), names.end());
  }

  // ---- freedoms

  // The Jacobian with respect to the unknowns and the freedoms of the drivers.
  Eigen::MatrixXd jacobian(const std::vector<Index>& equations, const std::vector<double>& q) {
    const DenseBlock block(s_, equations, p_.unknowns, column_);
    Eigen::MatrixXd j(block.rows(), block.columns() + static_cast<Eigen::Index>(freedoms_.count()));
    j.leftCols(block.columns()) = block.jacobian(q);
    for (std::size_t f = 0; f < freedoms_.count(); ++f) {
      const std::vector<double> rate = freedoms_.rates(f, q);
      for (Eigen::Index i = 0; i < block.rows(); ++i) {
        double sum = 0;
        gradient<double>(s_, equations[static_cast<std::size_t>(i)], q,
                         [&](Index c, double value) { sum += value * rate[idx(c)]; });
        j(i, block.columns() + static_cast<Eigen::Index>(f)) = sum;
      }
    }
    // To unit length: |Phi| is then a distance. Rows that nearly vanish stay small, because they are only rounding.
    for (Eigen::Index i = 0; i < j.rows(); ++i) j.row(i) /= std::max(j.row(i).norm(), kLeastScale);
    return j;
  }

  using Decomposition = Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>;

  static Decomposition decompose(const Eigen::MatrixXd& j) {
    Decomposition d(j.rows(), j.cols());
    d.setThreshold(kDependentRows);
    d.compute(j);
    return d;
  }

  // The kept equations, and those dropped equations that restrict the drivers.
  std::vector<Index> independent() {
    std::vector<Index> all = p_.kept;
    for (const Index e : p_.equations) {
      if (std::find(p_.kept.begin(), p_.kept.end(), e) != p_.kept.end()) continue;
      const Eigen::MatrixXd row = jacobian({e}, start_).transpose();
      if (row.norm() == 0) continue;
      if (!all.empty()) {
        const Eigen::MatrixXd others = jacobian(all, start_).transpose();
        if ((others * decompose(others).solve(row) - row).norm() <= kDependentRows * 10) continue;
      }
      all.push_back(e);
    }
    return all;
  }

  void displace(const Eigen::VectorXd& by, std::vector<double>& q) const {
    const std::size_t n = p_.unknowns.size();
    for (std::size_t i = 0; i < n; ++i) q[idx(p_.unknowns[i])] += by[static_cast<Eigen::Index>(i)];
    const std::vector<double> amounts(by.data() + n, by.data() + by.size());
    freedoms_.move(amounts, q);
  }

  // Finds a posture that satisfies the equations, with free drivers, by Newton's method with the smallest steps.
  bool settle(const std::vector<Index>& equations, std::vector<double>& q) {
    const DenseBlock block(s_, equations, p_.unknowns, column_), all(s_, p_.equations, p_.unknowns, column_);
    double last = HUGE_VAL;
    for (int step = 0; step < kStepsElsewhere; ++step) {
      const double now = block.relative_residual(q);
      if (now <= 4 * kEps || (now <= kNoLongerFalls && now > last / 4)) break;
      last = now;
      Eigen::VectorXd phi = block.residuals(q);
      for (Eigen::Index i = 0; i < phi.size(); ++i) phi[i] /= slope(equations[static_cast<std::size_t>(i)], q);
      const Eigen::VectorXd by = -decompose(jacobian(equations, q)).solve(phi);
      if (!by.allFinite() || by.lpNorm<Eigen::Infinity>() > 1) return false;
      displace(by, q);
    }
    return all.relative_residual(q) <= kConsistent;
  }

  // Length of the equation's row in the Jacobian before scaling.
  double slope(Index e, const std::vector<double>& q) {
    const DenseBlock block(s_, {&e, 1}, p_.unknowns, column_);
    double sum = block.jacobian(q).squaredNorm();
    for (std::size_t f = 0; f < freedoms_.count(); ++f) {
      const std::vector<double> rate = freedoms_.rates(f, q);
      double along = 0;
      gradient<double>(s_, e, q, [&](Index c, double value) { along += value * rate[idx(c)]; });
      sum += along * along;
    }
    return sum > 0 ? std::sqrt(sum) : 1;
  }

  Mobility mobility() {
    const std::size_t columns = p_.unknowns.size() + freedoms_.count();
    Mobility out;
    if (p_.equations.empty() || columns == 0 || std::max(p_.equations.size(), columns) > kLargestDenseRank ||
        freedoms_.count() * s_.coordinates.size() > kMostRates) {
      // The kept equations are independent; restrictions of the drivers by dropped ones are not examined.
      out.at_start = out.generic =
          static_cast<std::int64_t>(p_.unknowns.size()) - static_cast<std::int64_t>(p_.kept.size());
      return out;
    }
    const auto beyond = [&](Eigen::Index rank) {
      return static_cast<std::int64_t>(p_.unknowns.size()) - static_cast<std::int64_t>(rank);
    };
    const Decomposition at_start = decompose(jacobian(p_.equations, start_));
    out.at_start = out.generic = beyond(at_start.rank());
    const Eigen::Index free = at_start.cols() - at_start.rank();
    if (!out_.cannot_assemble.empty() || free == 0) return out;
    // Null vectors are the last columns of Z^T.
    const Eigen::MatrixXd last = at_start.matrixZ().transpose().rightCols(free);
    const Eigen::MatrixXd basis = at_start.colsPermutation() * last;
    const std::vector<Index> equations = independent();
    std::mt19937 random(1);
    for (int k = 0; k < kTries; ++k) {
      Eigen::VectorXd along(free);
      for (Eigen::Index i = 0; i < free; ++i) {
        along[i] = 2 * static_cast<double>(random()) / static_cast<double>(std::mt19937::max()) - 1;
      }
      const Eigen::VectorXd by = basis * along;
      std::vector<double> q = start_;
      displace(by * (4 * kNearby / by.lpNorm<Eigen::Infinity>()), q);
      // At a singular start, equations may be dependent that are independent elsewhere.
      std::vector<double> again = q;
      if (!settle(equations, q) && !settle(p_.equations, q = std::move(again))) continue;
      out.generic = std::min(out.generic, beyond(decompose(jacobian(p_.equations, q)).rank()));
    }
    return out;
  }

  const System& s_;
  const Component& p_;
  const std::vector<double>& start_;
  double time_;
  const std::vector<Index>& checks_;
  StartFindings& out_;
  std::set<std::string>& impossible_;  // names of equations that prevent any motion
  Freedoms freedoms_;
  std::vector<Index> column_;  // scratch of DenseBlock
  double refused_ = kRefused;
  std::map<std::size_t, Seen> path_, near_;
};

// "'third1'", "3 equations of joints A, B, C".
std::string subject(const RedundantSet& set) {
  if (set.checked.size() == 1 && set.named.joints.empty()) return "'" + set.checked[0] + "'";
  const std::size_t count = set.checked.size();
  return std::to_string(count) + (count == 1 ? " equation" : " equations") + " of " + set.named.text();
}

// "; it restricts driver m, driver n", for a subject that does not name them.
std::string restricted(const RedundantSet& set) {
  if (set.checked.size() != 1 || !set.named.joints.empty()) return "";
  std::string out;
  for (const std::string& name : set.named.others) {
    if (name.starts_with("driver ") && name != set.checked[0]) out += (out.empty() ? "; it restricts " : ", ") + name;
  }
  return out;
}

// Describes equations that do not hold elsewhere, in a note, or refuses the scene.
void describe_or_refuse(const RedundantSet& set, bool is_impossible, StartFindings& out) {
  const bool is_one = set.checked.size() == 1;
  const std::string holds = subject(set) + (is_one ? " holds" : " hold");
  const std::string amount = general(set.worst.violation, 3) + (set.worst.is_length ? " m" : "");
  const std::string by = std::string(is_one ? "it is violated by " : "they are violated by up to ") + amount;
  std::string what;
  const bool is_told = is_impossible || set.kind == Redundancy::Kind::start || set.kind == Redundancy::Kind::motion;
  if (is_told && !(set.worst.violation > 0)) {  // the search met no posture in which it could be violated
    what = holds + " at the start posture, but no other posture was found in which all equations hold";
  } else if (set.kind == Redundancy::Kind::start) {
    what = holds + " at the start posture, but not later: at t = " + general(set.worst.time, 6) + " s " + by;
  } else if (is_impossible) {
    what = holds + " at the start posture, but not at other values of the drivers: " + by;
  } else if (set.kind == Redundancy::Kind::motion) {
    what = holds + " while the drivers follow their laws, but " + (is_one ? "does" : "do") +
           " not follow from the other equations: " + by + " at nearby values of the drivers";
  } else {
    return;
  }
  if (!is_impossible) {
    out.notes.push_back({"/", what});
  } else if (out.cannot_assemble.empty()) {
    out.cannot_assemble = "the mechanism cannot move: " + what + restricted(set);
  }
}

}  // namespace

bool is_length(const System& s, Index equation) {
  std::vector<Index> mentioned;
  s.mentioned(equation, mentioned);
  return std::any_of(mentioned.begin(), mentioned.end(), [&](Index c) { return s.coordinates[idx(c)].dimension == 1; });
}

Violation violation(const System& s, Index equation, const std::vector<double>& q) {
  std::map<Index, double> slope;
  gradient<double>(s, equation, q, [&](Index c, double value) {
    if (c != kOne) slope[c] += value;
  });
  double sum = 0;
  for (const auto& [c, value] : slope) sum += value * value;
  const double by = std::abs(residual<double>(s, equation, q)) / std::max(std::sqrt(sum), 1e-300);
  const bool length = is_length(s, equation);
  return {by * s.unit(length ? 1 : 0), length};
}

void look_at_other_postures(const System& s, const DoubtfulParts& parts, const std::vector<double>& q, double time,
                            StartFindings& out) {
  const std::int64_t driven = out.mobility;
  out.mobility_at_start = driven;
  std::set<std::string> impossible;
  for (const Component& part : connected(s, parts, out.checks)) {
    const Look::Mobility more = Look(s, part, q, time, out.checks, out, impossible).run();
    out.mobility += more.generic;
    out.mobility_at_start += more.at_start;
  }
  for (const RedundantSet& set : redundant_sets(*s.scene, out.redundant)) {
    const auto is_impossible = [&](const std::string& name) { return impossible.count(name) != 0; };
    describe_or_refuse(set, std::any_of(set.checked.begin(), set.checked.end(), is_impossible), out);
  }
}

}  // namespace assur
