#include "assur/modes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>

#include "decompositions.hpp"
#include "equations/dense_block.hpp"
#include "equations/lowering.hpp"
#include "equations/own_values.hpp"
#include "equations/residual_scale.hpp"
#include "index.hpp"
#include "modes/homotopy.hpp"
#include "modes/quadratics.hpp"
#include "numbers.hpp"
#include "plan/prepare_at.hpp"
#include "scene/names.hpp"
#include "scene/triple.hpp"
#include "start/assembly.hpp"
#include "start/start.hpp"
#include "structure/grouping.hpp"

namespace assur {
namespace {

constexpr std::size_t kMostWithLinear = 48;  // unknowns of a group before linear equations are eliminated; a choice
constexpr int kPolishSteps = 8;              // of Newton's method; the tests take 6
constexpr double kAtFold = 1e-4;             // internal units: a multiple solution is known to about 1e-6

// A mode with its unknowns as in the posture.
struct Found {
  Eigen::VectorXd x;  // internal units
  AssemblyMode mode;
};

// A group with its equations and unknowns.
struct Members {
  std::string name;
  std::vector<Index> blocks, equations, unknowns;
};

// The groups of a whole scene, solved one after the other from its start posture.
class Mechanism {
 public:
  explicit Mechanism(const Scene& scene)
      : s_(lower(std::make_shared<const Scene>(scene))), column_(s_.coordinates.size(), -1) {
    Problem p;
    for (std::size_t c = 0; c < s_.coordinates.size(); ++c) {
      if (s_.coordinates[c].role == Role::unknown) p.unknowns.push_back(static_cast<Index>(c));
    }
    p.q = s_.guess;
    p.time = scene.time().start;
    const std::vector<Index> unknowns = p.unknowns;
    GroupedSystem found;
    assemble_start(s_, p, found);
    checks_ = found.checks;
    blocks_ = std::move(p.blocks);
    const bool is_singular = !found.undetermined.empty();
    if (is_singular || !found.cannot_assemble.empty()) {
      // A group without a posture, or at a fold. The groups come from all equations, also the dropped ones.
      blocks_ = decompose(s_, solving(), unknowns);
      checks_.clear();
      if (!blocks_.square() && is_singular) {
        throw Error(Error::Kind::input, "undetermined: no equation determines " + found.undetermined.front() +
                                            (found.undetermined.size() > 1 ? " and others" : "") +
                                            "; add a constraint or a driver");
      }
      if (!blocks_.square()) throw Error(Error::Kind::numerical, found.cannot_assemble);
    }
    q_ = std::move(p.q);
    make_groups();
    if (!found.cannot_assemble.empty() && groups_.empty()) {
      throw Error(Error::Kind::numerical, found.cannot_assemble);
    }
  }

  [[nodiscard]] const System& system() const { return s_; }
  [[nodiscard]] const std::vector<double>& posture() const { return q_; }
  [[nodiscard]] std::size_t size() const { return groups_.size(); }
  [[nodiscard]] const Members& group(std::size_t g) const { return groups_[g]; }

  // The group of this name, or the one that solves this point, vector or scalar. Throws Error (input) if there is none.
  [[nodiscard]] std::size_t find(std::string_view name) const {
    std::vector<std::string_view> known;
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      if (groups_[g].name == name) return g;
      known.push_back(groups_[g].name);
    }
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      for (const Index u : groups_[g].unknowns) {
        if (s_.coordinate_name(u) == name || s_.items[idx(s_.coordinates[idx(u)].item)].name == name) return g;
      }
    }
    throw Error(Error::Kind::input, "no group has the name " + in_quotes(name) + " or solves an unknown of that name" +
                                        known_instead(name, known));
  }

  // Assembles the group from q if groups that it depends on have moved.
  void prepare(std::size_t g) {
    const Members& m = groups_[g];
    if (std::any_of(m.blocks.begin(), m.blocks.end(), [&](Index b) { return stale_[idx(b)] != 0; })) {
      for (const Index b : m.blocks) {
        (void)assemble(s_, blocks_.equations_of(b), blocks_.unknowns_of(b), q_, column_);
      }
    }
    is_assembled_[g] = needs_unassembled(g).empty() && block(m).relative_residual(q_) <= kConsistent;
  }
  [[nodiscard]] bool is_assembled(std::size_t g) const { return is_assembled_[g]; }

  // After prepare(): all modes of a group.
  [[nodiscard]] AssemblyModes modes(std::size_t g, std::vector<Found>& found) {
    const Members& m = groups_[g];
    AssemblyModes out;
    out.group = m.name;
    for (const Index u : m.unknowns) out.unknowns.push_back(s_.coordinate_name(u));
    out.why_none = why_none(g);
    if (!out.why_none.empty()) return out;
    const Quadratics reduced = quadratics(s_, m.equations, m.unknowns, q_);
    if (reduced.kind == Quadratics::Kind::dependent) {
      out.why_none = "has equations that depend on each other here, so that its postures are not isolated";
    } else if (reduced.size() > kMostPolynomials) {
      out.why_none = "has " + std::to_string(reduced.size()) + " unknowns" +
                     (reduced.size() < std::ssize(m.unknowns) ? " after linear equations" : "") + "; at most " +
                     std::to_string(kMostUnknownsOfModes) + " can be computed";
    }
    if (!out.why_none.empty()) return out;
    collect(m, reduced, found, out);
    take_start(g, found, out);
    for (const Found& f : found) out.modes.push_back(f.mode);
    return out;
  }

  // Moves the group to one of its modes. Groups that depend on it are then assembled anew.
  void choose(std::size_t g, const Eigen::VectorXd& x, bool is_start) {
    const Members& m = groups_[g];
    for (std::size_t j = 0; j < m.unknowns.size(); ++j) q_[idx(m.unknowns[j])] = x[static_cast<Eigen::Index>(j)];
    is_assembled_[g] = true;
    if (is_start) return;
    for (const Index b : later(m.blocks)) stale_[idx(b)] = 1;
  }

  // The first group without a posture; "": all have one.
  [[nodiscard]] std::string unassembled() const {
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      if (!is_assembled_[g]) return groups_[g].name;
    }
    return "";
  }

 private:
  // All equations that mention unknowns.
  [[nodiscard]] std::vector<Index> solving() const {
    std::vector<Index> equations, mentioned;
    for (Index e = 0; e < static_cast<Index>(s_.equations.size()); ++e) {
      s_.mentioned(e, mentioned);
      if (std::any_of(mentioned.begin(), mentioned.end(),
                      [&](Index c) { return s_.coordinates[idx(c)].role == Role::unknown; })) {
        equations.push_back(e);
      }
    }
    return equations;
  }

  void make_groups() {
    block_of_.assign(s_.coordinates.size(), -1);
    for (Index b = 0; b < blocks_.size(); ++b) {
      for (const Index u : blocks_.unknowns_of(b)) block_of_[idx(u)] = b;
    }
    group_of_block_.assign(idx(blocks_.size()), -1);
    stale_.assign(idx(blocks_.size()), 0);
    for (const Draft& draft : form_groups(s_, blocks_, Formulation::groups)) {
      if (draft.blocks.empty()) continue;
      Members m{draft.name, draft.blocks, {}, {}};
      for (const Index b : draft.blocks) {
        for (const Index u : blocks_.unknowns_of(b)) m.unknowns.push_back(u);
        for (const Index e : blocks_.equations_of(b)) m.equations.push_back(e);
        group_of_block_[idx(b)] = static_cast<Index>(groups_.size());
      }
      std::sort(m.unknowns.begin(), m.unknowns.end());
      groups_.push_back(std::move(m));
    }
    is_assembled_.assign(groups_.size(), true);
  }

  [[nodiscard]] DenseBlock block(const Members& m) { return {s_, m.equations, m.unknowns, column_}; }

  // Blocks that read unknowns of these blocks, directly or through others. Blocks are in solving order.
  [[nodiscard]] std::vector<Index> later(const std::vector<Index>& blocks) const {
    std::vector<std::uint8_t> is_later(idx(blocks_.size()), 0);
    std::vector<Index> out;
    for (Index b = 0; b < blocks_.size(); ++b) {
      if (std::find(blocks.begin(), blocks.end(), b) != blocks.end()) continue;
      for (const Index needed : blocks_.needs_of(b)) {
        if (is_later[idx(needed)] == 0 && std::find(blocks.begin(), blocks.end(), needed) == blocks.end()) continue;
        is_later[idx(b)] = 1;
        out.push_back(b);
        break;
      }
    }
    return out;
  }

  // A group without a posture that this one reads; "": none.
  [[nodiscard]] std::string needs_unassembled(std::size_t g) const {
    for (const Index b : groups_[g].blocks) {
      for (const Index needed : blocks_.needs_of(b)) {
        const Index of = group_of_block_[idx(needed)];
        if (idx(of) != g && !is_assembled_[idx(of)]) return groups_[idx(of)].name;
      }
    }
    return "";
  }

  [[nodiscard]] std::string why_none(std::size_t g) const {
    const Members& m = groups_[g];
    if (const std::string needed = needs_unassembled(g); !needed.empty()) {
      return "depends on group " + needed + ", which has no posture; choose a mode of it";
    }
    for (const Index e : m.equations) {
      if (s_.equations[idx(e)].callback >= 0) {
        return "has the equation '" + s_.equation_name(e) + "' of a function or a gear, which is not a polynomial";
      }
    }
    if (m.unknowns.size() > kMostWithLinear) {
      return "has " + std::to_string(m.unknowns.size()) + " unknowns; at most " + std::to_string(kMostUnknownsOfModes) +
             " may remain after linear equations are eliminated";
    }
    return "";
  }

  void collect(const Members& m, const Quadratics& reduced, std::vector<Found>& found, AssemblyModes& out) {
    if (reduced.kind == Quadratics::Kind::contradictory) return;
    Solutions solutions;
    if (reduced.size() > 0) {
      solutions = solve(reduced);
    } else {
      solutions.paths = 1;
      solutions.real.push_back({Eigen::VectorXd::Zero(0), kInfinity});
    }
    out.paths = solutions.paths;
    out.not_real = solutions.complex;
    out.diverged = solutions.diverged;
    out.multiple = solutions.multiple;
    out.lost = solutions.lost;
    for (const Eigen::VectorXd& z : solutions.real_multiple) {
      out.folds.push_back(in_si(m, reduced.origin + reduced.basis * z));
    }
    const std::vector<double> start = q_;
    for (const Solutions::Simple& simple : solutions.real) {
      const Eigen::VectorXd x = reduced.origin + reduced.basis * simple.z;
      set(m, x);
      std::optional<Found> mode = polished(m);
      if (!mode || (mode->x - x).norm() > simple.apart / 2) {
        ++out.lost;
      } else if (is_excluded(m)) {
        ++out.excluded;
      } else {
        found.push_back(std::move(*mode));
      }
      q_ = start;
    }
    const auto key = [](const Found& f) {  // insensitive to rounding
      std::vector<double> k(f.mode.values.size());
      std::transform(f.mode.values.begin(), f.mode.values.end(), k.begin(),
                     [](double v) { return std::nearbyint(v * 0x1p24); });
      return k;
    };
    std::stable_sort(found.begin(), found.end(), [&](const Found& a, const Found& b) { return key(a) < key(b); });
  }

  // Puts the start posture first, with its own values.
  void take_start(std::size_t g, std::vector<Found>& found, AssemblyModes& out) {
    const Members& m = groups_[g];
    if (!is_assembled_[g] || is_excluded(m)) return;
    const Eigen::VectorXd x = gather(m);
    const auto distance = [&](const Found& f) { return (f.x - x).norm(); };
    const auto nearest = std::min_element(found.begin(), found.end(),
                                          [&](const Found& a, const Found& b) { return distance(a) < distance(b); });
    Found start = described(m);
    // Both solve the equations to rounding, which the condition amplifies.
    if (nearest != found.end() && distance(*nearest) <= 1e3 * kEps * start.mode.condition * (1 + x.norm())) {
      found.erase(nearest);
      found.insert(found.begin(), std::move(start));
      out.has_start = true;
      return;
    }
    const std::vector<double> at = in_si(m, x);
    for (const std::vector<double>& fold : out.folds) {
      double far = 0;
      for (std::size_t j = 0; j < at.size(); ++j) {
        const double unit = s_.unit(s_.coordinates[idx(m.unknowns[j])].dimension);
        far = std::max(far, std::abs(fold[j] - at[j]) / unit);
      }
      if (far <= kAtFold * (1 + x.norm())) return;
    }
    ++out.lost;
    found.insert(found.begin(), std::move(start));
    out.has_start = true;
  }

  void set(const Members& m, const Eigen::VectorXd& x) {
    for (std::size_t j = 0; j < m.unknowns.size(); ++j) q_[idx(m.unknowns[j])] = x[static_cast<Eigen::Index>(j)];
  }

  [[nodiscard]] Eigen::VectorXd gather(const Members& m) const {
    Eigen::VectorXd x(static_cast<Eigen::Index>(m.unknowns.size()));
    for (std::size_t j = 0; j < m.unknowns.size(); ++j) x[static_cast<Eigen::Index>(j)] = q_[idx(m.unknowns[j])];
    return x;
  }

  [[nodiscard]] std::vector<double> in_si(const Members& m, const Eigen::VectorXd& x) const {
    std::vector<double> out;
    for (std::size_t j = 0; j < m.unknowns.size(); ++j) {
      out.push_back(x[static_cast<Eigen::Index>(j)] * s_.unit(s_.coordinates[idx(m.unknowns[j])].dimension));
    }
    return out;
  }

  // Newton's method on the equations as the simulation evaluates them, from q_. Empty if they do not hold at the end.
  [[nodiscard]] std::optional<Found> polished(const Members& m) {
    const DenseBlock equations = block(m);
    double best = equations.relative_residual(q_);
    for (int k = 0; k < kPolishSteps; ++k) {
      const Eigen::VectorXd x = gather(m);
      set(m, x - equations.jacobian(q_).fullPivLu().solve(equations.residuals(q_)));
      const double now = equations.relative_residual(q_);
      if (now < best) {
        best = now;
        continue;
      }
      if (!(now <= best)) set(m, x);
      break;
    }
    if (!(best <= kConsistent)) return std::nullopt;
    return described(m);
  }

  [[nodiscard]] Found described(const Members& m) {
    const DenseBlock equations = block(m);
    Eigen::MatrixXd j = equations.jacobian(q_);
    for (Eigen::Index i = 0; i < j.rows(); ++i) {
      j.row(i) /= std::max(j.row(i).norm(), std::numeric_limits<double>::min());
    }
    const Eigen::VectorXd sigma = j.jacobiSvd().singularValues();
    const Eigen::VectorXd x = gather(m);
    return {x, {in_si(m, x), equations.relative_residual(q_), sigma[0] / sigma[sigma.size() - 1]}};
  }

  // True if q_ solves the equations of the group, but is not a posture of the mechanism. Compares only
  // unknowns of the group and of groups before it.
  [[nodiscard]] bool is_excluded(const Members& m) const {
    const auto group = static_cast<Index>(&m - groups_.data());
    std::vector<std::uint8_t> after;  // blocks; computed when it is needed, for large scenes
    const auto is_known = [&](Index c) {
      if (after.empty()) {
        after.assign(idx(blocks_.size()), 0);
        for (const Index b : later(m.blocks)) after[idx(b)] = 1;
      }
      return block_of_[idx(c)] < 0 || after[idx(block_of_[idx(c)])] == 0;
    };
    const auto is_judged = [&](const std::vector<Index>& coordinates) {
      const auto is_own = [&](Index c) {
        const Index b = block_of_[idx(c)];
        return b >= 0 && group_of_block_[idx(b)] == group;
      };
      return std::any_of(coordinates.begin(), coordinates.end(), is_own) &&
             std::all_of(coordinates.begin(), coordinates.end(), is_known);
    };
    const auto add_form = [&](Index form, std::vector<Index>& to) {
      for (const Term& t : s_.form(form)) to.push_back(t.coordinate);
    };
    std::vector<Index> reads;
    for (const Index e : checks_) {
      s_.mentioned(e, reads);
      if (is_judged(reads) &&
          !(std::abs(residual<double>(s_, e, q_)) <= 1e-8 * std::max(residual_scale(s_, e, q_), kLeastScale))) {
        return true;
      }
    }
    for (const Positive& p : s_.positive) {
      if (is_judged({p.coordinate}) && !(q_[idx(p.coordinate)] > 0)) return true;
    }
    for (const DriverInput& in : s_.inputs) {
      reads.clear();
      for (const Index form : in.own) add_form(form, reads);
      if (is_judged(reads) && why_undefined(s_, in, q_).empty() && mismatch(s_, in, q_)) return true;
    }
    for (const Frame& f : s_.frames) {
      Triple a[3];
      reads.clear();
      for (std::size_t j = 0; j < 3; ++j) {
        const Item& item = s_.items[idx(f.item[j])];
        for (std::size_t k = 0; k < 3; ++k) {
          add_form(item.form[k], reads);
          a[j][k] = form_value<double>(s_, item.form[k], q_);
        }
      }
      if (is_judged(reads) && !(triple::dot(triple::cross(a[0], a[1]), a[2]) > 0)) return true;
    }
    return false;
  }

  System s_;
  std::vector<Index> column_;  // scratch of DenseBlock
  Blocks blocks_;
  std::vector<Index> checks_;  // redundant equations
  std::vector<double> q_;      // all coordinates, internal units
  std::vector<Members> groups_;
  std::vector<Index> block_of_;        // coordinates -> blocks; -1: known
  std::vector<Index> group_of_block_;  // blocks -> groups_
  std::vector<std::uint8_t> stale_;    // blocks: 1 if a block that it reads was moved to another mode
  std::vector<bool> is_assembled_;     // groups_
};

// Choices by group; empty: the start posture.
std::vector<std::optional<std::size_t>> by_group(const Mechanism& mechanism, const std::vector<ModeChoice>& chosen) {
  std::vector<std::optional<std::size_t>> out(mechanism.size());
  for (const ModeChoice& c : chosen) {
    const std::size_t g = mechanism.find(c.group);
    if (out[g]) {
      throw Error(Error::Kind::input, "two choices name group " + mechanism.group(g).name + "; leave one out");
    }
    out[g] = c.mode;
  }
  return out;
}

std::string counted_modes(const AssemblyModes& modes) {
  return std::to_string(modes.modes.size()) + (modes.modes.size() == 1 ? " mode" : " modes") +
         (modes.complete() ? "" : ", perhaps more");
}

// Goes through the groups in solving order, makes the choices, and calls take(modes) with those of the `wanted` groups.
template <class Take>
void visit(Mechanism& mechanism, const std::vector<ModeChoice>& chosen, const std::vector<bool>& wanted, Take&& take) {
  const auto choices = by_group(mechanism, chosen);
  for (std::size_t g = 0; g < mechanism.size(); ++g) {
    mechanism.prepare(g);
    if (!wanted[g] && !choices[g]) continue;
    std::vector<Found> found;
    AssemblyModes modes = mechanism.modes(g, found);
    if (choices[g]) {
      if (!modes.why_none.empty()) {
        throw Error(Error::Kind::input, "no mode of group " + modes.group + " can be chosen: it " + modes.why_none);
      }
      if (*choices[g] >= found.size()) {
        throw Error(Error::Kind::input, "group " + modes.group + " has no mode " + std::to_string(*choices[g]) +
                                            ": it has " + counted_modes(modes) + ", counted from 0");
      }
      mechanism.choose(g, found[*choices[g]].x, *choices[g] == 0 && modes.has_start);
    }
    if (wanted[g]) take(std::move(modes));
  }
}

}  // namespace

std::size_t AssemblyModes::nearest(std::string_view point, const Triple& at) const {
  std::vector<std::pair<std::size_t, double>> components;  // index into unknowns, wanted value
  for (std::size_t j = 0; j < unknowns.size(); ++j) {
    const std::string& name = unknowns[j];
    if (name.size() != point.size() + 2 || !name.starts_with(point) || name[point.size()] != '.') continue;
    if (const int k = name.back() - 'x'; k >= 0 && k < 3) components.emplace_back(j, at[static_cast<std::size_t>(k)]);
  }
  if (components.empty()) {
    throw Error(Error::Kind::input, "group " + group + " does not solve a point or vector " + in_quotes(point));
  }
  if (modes.empty()) throw Error(Error::Kind::input, "group " + group + " has no mode");
  std::vector<double> far;
  for (const AssemblyMode& mode : modes) {
    double sum = 0;
    for (const auto& [j, wanted] : components) sum += (mode.values[j] - wanted) * (mode.values[j] - wanted);
    far.push_back(std::sqrt(sum));
  }
  const auto best = static_cast<std::size_t>(std::min_element(far.begin(), far.end()) - far.begin());
  for (std::size_t k = 0; k < far.size(); ++k) {
    if (k != best && far[k] <= far[best] * (1 + 1e-6)) {
      throw Error(Error::Kind::input, "modes " + std::to_string(std::min(k, best)) + " and " +
                                          std::to_string(std::max(k, best)) + " of group " + group +
                                          " are equally near to the place given for " + in_quotes(point) +
                                          "; choose one by its number");
    }
  }
  return best;
}

std::vector<AssemblyModes> assembly_modes(const Scene& scene, const std::vector<ModeChoice>& chosen) {
  Mechanism mechanism(scene);
  std::vector<AssemblyModes> out;
  visit(mechanism, chosen, std::vector<bool>(mechanism.size(), true),
        [&](AssemblyModes modes) { out.push_back(std::move(modes)); });
  return out;
}

AssemblyModes assembly_modes(const Scene& scene, std::string_view group, const std::vector<ModeChoice>& chosen) {
  Mechanism mechanism(scene);
  std::vector<bool> wanted(mechanism.size(), false);
  wanted[mechanism.find(group)] = true;
  AssemblyModes out;
  visit(mechanism, chosen, wanted, [&](AssemblyModes modes) { out = std::move(modes); });
  if (!out.why_none.empty()) {
    throw Error(Error::Kind::input, "the modes of group " + out.group + " cannot be computed: it " + out.why_none);
  }
  return out;
}

Prepared prepare_in_modes(const Scene& scene, const std::vector<ModeChoice>& chosen, const PrepareOptions& options) {
  if (chosen.empty()) return prepare(scene, options);
  Mechanism mechanism(scene);
  visit(mechanism, chosen, std::vector<bool>(mechanism.size(), false), [](const AssemblyModes&) {});
  if (const std::string group = mechanism.unassembled(); !group.empty()) {
    throw Error(Error::Kind::numerical, "group " + group + " cannot be assembled in the chosen modes; choose others");
  }
  Preparation prepared = prepare_at(scene, options, {mechanism.posture(), scene.time().start, true});
  const std::vector<double>& start = prepared.structure->start;
  for (const ModeChoice& c : chosen) {
    const Members& m = mechanism.group(mechanism.find(c.group));
    for (const Index u : m.unknowns) {
      if (std::abs(start[idx(u)] - mechanism.posture()[idx(u)]) <= 1e-6) continue;
      throw Error(Error::Kind::numerical, "the scene does not keep mode " + std::to_string(c.mode) + " of group " +
                                              m.name + ": " + mechanism.system().coordinate_name(u) +
                                              " has another value at the start");
    }
  }
  return Preparation::shared(std::move(prepared));
}

}  // namespace assur
