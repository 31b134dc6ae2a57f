#include "assur/structure.hpp"

#include <cs.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <unordered_set>

#include "scene/lowering.hpp"
#include "scene/outputs.hpp"
#include "structure/assembly.hpp"
#include "structure/blocks.hpp"
#include "structure/classes.hpp"
#include "structure/demand.hpp"
#include "structure/dense_block.hpp"
#include "structure/presolve.hpp"
#include "structure/rank.hpp"

namespace assur {
namespace {

constexpr double kConsistent = 1e-10;  // relative residual up to which dependent equations agree with each other

std::size_t idx(Index i) { return static_cast<std::size_t>(i); }

std::string shortened(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

class Analysis {
 public:
  Analysis(const Scene& scene, const StructureOptions& options) : options_(options) {
    s_ = lower(std::make_shared<const Scene>(scene), options.controlled, options.formulation != Formulation::irreducible);
    out_.formulation = options.formulation;
    out_.notes = s_.notes;
    column_.assign(s_.coordinates.size(), -1);
    q_ = options.posture.empty() ? s_.guess : options.posture;
    time_ = options.posture.empty() ? scene.time().start : options.time;
  }

  Structure run() {
    count();
    split_equations();
    blocks_ = decompose(s_, equations_, unknowns_);
    assemble_start();
    check_handedness();
    if (out_.cannot_assemble.empty()) eliminate_linear_equations();
    find_what_moves();
    form_groups();
    cut_to_outputs();
    classify();
    out_.start = std::move(q_);
    out_.system = std::make_shared<const System>(std::move(s_));
    return std::move(out_);
  }

 private:
  void count() {
    for (const Item& item : s_.items) {
      if (item.hidden) continue;
      (item.derived ? out_.derived : out_.coordinates) += item.components;
    }
    for (std::size_t c = 0; c < s_.coordinates.size(); ++c) {
      if (s_.coordinates[c].role == Role::unknown) unknowns_.push_back(static_cast<Index>(c));
    }
    out_.unknowns = static_cast<std::int64_t>(unknowns_.size());
    out_.equations = static_cast<std::int64_t>(s_.equations.size());
    for (const DriverInput& in : s_.inputs) out_.mobility += driven_freedoms(in);
  }

  [[nodiscard]] int driven_freedoms(const DriverInput& in) const {
    if (in.kind != DriverInput::Kind::frame) return 1;
    return in.count == s_.dimension ? s_.dimension : s_.dimension == 3 ? 6 : 3;
  }

  // Equations among known coordinates only are checked, never solved.
  void split_equations() {
    std::vector<Index> mentioned;
    for (Index e = 0; e < static_cast<Index>(s_.equations.size()); ++e) {
      s_.mentioned(e, mentioned);
      const bool solves = std::any_of(mentioned.begin(), mentioned.end(),
                                      [&](Index c) { return s_.coordinates[idx(c)].role == Role::unknown; });
      if (solves) {
        equations_.push_back(e);
      } else {
        out_.checks.push_back(e);
        out_.redundant.push_back({{s_.equation_name(e)}, s_.equation_name(e)});
        if (relative_residual(e) > kConsistent) contradiction({s_.equation_name(e)}, relative_residual(e));
      }
    }
  }

  [[nodiscard]] double relative_residual(Index e) const {
    const double scale = residual_scale(s_, e, q_);
    const double phi = std::abs(residual<double>(s_, e, q_));
    return scale > 0 ? phi / scale : phi;
  }

  void contradiction(const std::vector<std::string>& names, double by) {
    if (!out_.cannot_assemble.empty()) return;
    out_.cannot_assemble = "these contradict each other: ";
    for (std::size_t i = 0; i < names.size(); ++i) out_.cannot_assemble += (i == 0 ? "'" : ", '") + names[i] + "'";
    out_.cannot_assemble += " (relative residual " + shortened(by) + ")";
  }

  // ---- start posture

  void assemble_start() {
    std::vector<Index> singular = assemble_blocks();
    if (blocks_.square() && singular.empty()) return;
    if (!out_.cannot_assemble.empty() && blocks_.square()) return;
    study_doubtful_parts(singular);
  }

  // The equations of a frame driven inside a declared group hold for its mirror image as well.
  void check_handedness() {
    for (const Frame& f : s_.frames) {
      if (!out_.cannot_assemble.empty() || !out_.undetermined.empty()) return;
      double a[3][3];
      for (int j = 0; j < 3; ++j) {
        for (int k = 0; k < 3; ++k) a[j][k] = form_value<double>(s_, s_.items[idx(f.item[j])].form[k], q_);
      }
      const double volume = a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) +
                            a[0][1] * (a[1][2] * a[2][0] - a[1][0] * a[2][2]) +
                            a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0]);
      if (volume > 0) continue;
      const std::string& body = s_.scene->bodies()[idx(f.body)].name;
      out_.cannot_assemble = "the frame of body " + body +
                             " was assembled as its mirror image; start its vectors nearer to a right-handed frame";
    }
  }

  // Returns the blocks whose Jacobian is rank-deficient at the assembled posture.
  std::vector<Index> assemble_blocks() {
    std::vector<Index> singular;
    for (Index b = 0; b < blocks_.size(); ++b) {
      const BlockAssembly a = assemble(s_, blocks_.equations_of(b), blocks_.unknowns_of(b), q_, column_);
      if (!a.converged) {
        if (blocks_.square()) refuse_block(b, a);
        singular.push_back(b);
        continue;
      }
      if (a.singular) singular.push_back(b);
      if (a.mode == BlockAssembly::Mode::other) {
        out_.notes.push_back({"/", "group " + block_name(b) + " was assembled in another mode than its guess"});
      } else if (a.mode == BlockAssembly::Mode::not_decidable) {
        out_.notes.push_back({"/", "group " + block_name(b) +
                                       ": whether it was assembled in the mode of its guess is not decidable, the guess is "
                                       "near singular"});
      }
    }
    return singular;
  }

  void refuse_block(Index b, const BlockAssembly& a) {
    if (!out_.cannot_assemble.empty()) return;
    std::vector<Index> mentioned;
    s_.mentioned(a.worst_equation, mentioned);
    const bool is_length =
        std::any_of(mentioned.begin(), mentioned.end(), [&](Index c) { return s_.coordinates[idx(c)].dimension == 1; });
    out_.cannot_assemble = "group " + group_or_block_name(b) + " cannot be assembled: '" +
                           s_.equation_name(a.worst_equation) + "' is violated most, by " +
                           (is_length ? shortened(a.violation * s_.unit(1)) + " m" : shortened(a.violation));
  }

  // Connected components that hold a structural surplus or a singular block.
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
    for (const Index e : equations_) {
      unknowns_in(e);
      for (const Index c : mentioned) parent[idx(root(c))] = root(mentioned.front());
    }
    std::set<Index> doubtful;
    for (const Index u : blocks_.surplus_unknowns) doubtful.insert(root(u));
    for (const Index e : blocks_.surplus_equations) {
      unknowns_in(e);
      doubtful.insert(root(mentioned.front()));
    }
    for (const Index b : singular) doubtful.insert(root(blocks_.unknowns_of(b).front()));

    std::vector<Index> kept;
    std::unordered_map<Index, std::pair<std::vector<Index>, std::vector<Index>>> parts;
    for (const Index r : doubtful) parts[r];
    for (const Index e : equations_) {
      unknowns_in(e);
      const auto part = parts.find(root(mentioned.front()));
      if (part == parts.end()) {
        kept.push_back(e);
      } else {
        part->second.first.push_back(e);
      }
    }
    for (const Index u : unknowns_) {
      if (const auto part = parts.find(root(u)); part != parts.end()) part->second.second.push_back(u);
    }
    for (const Index r : doubtful) {
      const auto& [equations, unknowns] = parts[r];
      take(study_rank(s_, equations, unknowns, time_, q_, column_), static_cast<Index>(unknowns.size()), kept);
    }
    std::sort(kept.begin(), kept.end());
    equations_ = std::move(kept);
    blocks_ = decompose(s_, equations_, unknowns_);
    if (out_.undetermined.empty() && out_.cannot_assemble.empty()) assemble_blocks();
  }

  void take(const RankStudy& study, Index unknowns, std::vector<Index>& kept) {
    kept.insert(kept.end(), study.kept.begin(), study.kept.end());
    out_.checks.insert(out_.checks.end(), study.dropped.begin(), study.dropped.end());
    for (const Redundancy& r : study.redundant) {
      out_.redundant.push_back(r);
      const bool names_a_driver = std::any_of(r.constraints.begin(), r.constraints.end(),
                                              [](const std::string& n) { return n.rfind("driver ", 0) == 0; });
      if (names_a_driver) --out_.mobility;
    }
    out_.mobility += unknowns - study.rank;
    for (const Index u : study.undetermined) out_.undetermined.push_back(s_.coordinate_name(u));
    if (study.residual > kConsistent) {
      std::vector<std::string> names;
      for (const Redundancy& r : study.redundant) names.insert(names.end(), r.constraints.begin(), r.constraints.end());
      if (names.empty()) {
        for (const Index e : study.kept) names.push_back(s_.equation_name(e));
      }
      std::sort(names.begin(), names.end());
      names.erase(std::unique(names.begin(), names.end()), names.end());
      contradiction(names, study.residual);
    }
    if (study.singular_start && study.undetermined.empty()) {
      out_.notes.push_back({"/", "the start posture is singular: rank is lost there and nowhere else on the path"});
    }
  }

  void eliminate_linear_equations() {
    if (options_.formulation != Formulation::irreducible) return;
    out_.eliminated = presolve(s_, equations_, unknowns_);
    if (out_.eliminated > 0) blocks_ = decompose(s_, equations_, unknowns_);
  }

  // ---- groups

  void find_what_moves() {
    moves_.assign(s_.coordinates.size(), 0);
    for (std::size_t c = 0; c < s_.coordinates.size(); ++c) {
      moves_[c] = s_.coordinates[c].role == Role::driven && s_.coordinates[c].moving ? 1 : 0;
    }
    std::vector<Index> mentioned;
    block_moves_.assign(idx(blocks_.size()), 0);
    for (Index b = 0; b < blocks_.size(); ++b) {
      for (const Index e : blocks_.equations_of(b)) {
        s_.mentioned(e, mentioned);
        for (const Index c : mentioned) block_moves_[idx(b)] |= moves_[idx(c)];
      }
      for (const Index u : blocks_.unknowns_of(b)) moves_[idx(u)] = block_moves_[idx(b)];
      if (block_moves_[idx(b)] == 0) {
        const auto u = blocks_.unknowns_of(b);
        out_.static_coordinates.insert(out_.static_coordinates.end(), u.begin(), u.end());
      }
    }
  }

  struct Draft {
    std::string name;
    std::vector<Index> blocks;
    Index of = 0;
    Index level = 0;
    bool keep = false;
    int derivatives = -1, wanted = -1;
  };

  void form_groups() {
    group_of_.assign(idx(blocks_.size()), -1);
    if (options_.formulation == Formulation::global) {
      drafts_.push_back({"all", {}, 0, 0, false});
      std::fill(group_of_.begin(), group_of_.end(), 0);
    } else if (options_.formulation == Formulation::groups) {
      declared_groups();
    }
    for (Index b = 0; b < blocks_.size(); ++b) {
      if (group_of_[idx(b)] < 0) {
        group_of_[idx(b)] = static_cast<Index>(drafts_.size());
        drafts_.push_back({block_name(b), {}, 0, 0, false});
      }
      Draft& d = drafts_[idx(group_of_[idx(b)])];
      d.blocks.push_back(b);
      d.of += static_cast<Index>(blocks_.unknowns_of(b).size());
    }
    order_groups();
  }

  void declared_groups() {
    std::vector<Index> declared(s_.coordinates.size(), -1);
    for (std::size_t g = 0; g < s_.groups.size(); ++g) {
      drafts_.push_back({s_.groups[g].name, {}, 0, 0, s_.groups[g].keep});
      for (const Index u : s_.groups[g].unknowns) declared[idx(u)] = static_cast<Index>(g);
    }
    for (Index b = 0; b < blocks_.size(); ++b) {
      const auto unknowns = blocks_.unknowns_of(b);
      const Index g = declared[idx(unknowns.front())];
      for (const Index u : unknowns) {
        if (declared[idx(u)] == g) continue;
        const Index other = std::max(g, declared[idx(u)]);
        throw Error(Error::Kind::input,
                    {{"/groups/" + s_.groups[idx(other)].name,
                      "must be a union of irreducible groups, but cuts through " + block_name(b) + ": either all of it ("
                          + all_names(b) + ") or nothing belongs to the group"}});
      }
      group_of_[idx(b)] = g;
    }
  }

  // Levels by longest path among groups; a cycle means that an outside block lies between two of a group.
  void order_groups() {
    const std::size_t n = drafts_.size();
    std::vector<std::set<Index>> needs(n);
    for (Index b = 0; b < blocks_.size(); ++b) {
      for (const Index o : blocks_.needs_of(b)) {
        if (group_of_[idx(o)] != group_of_[idx(b)]) needs[idx(group_of_[idx(b)])].insert(group_of_[idx(o)]);
      }
    }
    std::vector<std::vector<Index>> feeds(n);
    std::vector<Index> waiting(n), ready, order;
    for (std::size_t g = 0; g < n; ++g) {
      waiting[g] = static_cast<Index>(needs[g].size());
      for (const Index o : needs[g]) feeds[idx(o)].push_back(static_cast<Index>(g));
      if (waiting[g] == 0) ready.push_back(static_cast<Index>(g));
    }
    while (!ready.empty()) {
      const Index g = ready.back();
      ready.pop_back();
      order.push_back(g);
      for (const Index f : feeds[idx(g)]) {
        drafts_[idx(f)].level = std::max(drafts_[idx(f)].level, drafts_[idx(g)].level + 1);
        if (--waiting[idx(f)] == 0) ready.push_back(f);
      }
    }
    if (order.size() != n) refuse_cycle(waiting, needs);
    // Groups in solving order; group_of_ follows.
    std::vector<Index> sorted(n), place(n);
    std::iota(sorted.begin(), sorted.end(), 0);
    std::sort(sorted.begin(), sorted.end(), [&](Index x, Index y) {
      const auto key = [&](Index g) {
        const Draft& d = drafts_[idx(g)];
        return std::tuple(d.level, d.blocks.empty() ? Index{0} : d.blocks.front(), g);
      };
      return key(x) < key(y);
    });
    std::vector<Draft> drafts;
    for (std::size_t k = 0; k < n; ++k) {
      place[idx(sorted[k])] = static_cast<Index>(k);
      drafts.push_back(std::move(drafts_[idx(sorted[k])]));
    }
    drafts_ = std::move(drafts);
    for (Index& g : group_of_) g = place[idx(g)];
  }

  [[noreturn]] void refuse_cycle(const std::vector<Index>& waiting, const std::vector<std::set<Index>>& needs) const {
    for (std::size_t g = 0; g < s_.groups.size(); ++g) {
      if (waiting[g] == 0) continue;
      for (const Index o : needs[g]) {
        if (waiting[idx(o)] == 0) continue;
        throw Error(Error::Kind::input,
                    {{"/groups/" + s_.groups[g].name, "needs " + drafts_[idx(o)].name +
                                                          ", which in turn needs this group: it lies between blocks of the "
                                                          "group and must belong to it"}});
      }
    }
    throw Error(Error::Kind::input, {{"/groups", "the declared groups need each other in a circle"}});
  }

  // ---- what the outputs need

  void cut_to_outputs() {
    const std::vector<Output> outputs = wanted_outputs(s_);
    std::vector<std::int8_t> need = needed_by_outputs(s_, outputs);
    for (const Draft& d : drafts_) {
      for (const Index b : d.blocks) {
        if (!d.keep) break;
        for (const Index u : blocks_.unknowns_of(b)) need[idx(u)] = 2;
      }
    }
    // Block by block from the last: which are needed at all. What is watched has to be known.
    std::vector<std::int8_t> positions = need;
    require_inputs(s_, out_.checks, 0, positions);
    block_needed_.assign(idx(blocks_.size()), 0);
    for (Index b = blocks_.size() - 1; b >= 0; --b) {
      const auto u = blocks_.unknowns_of(b);
      if (std::none_of(u.begin(), u.end(), [&](Index c) { return positions[idx(c)] >= 0; })) {
        out_.left_out.unknowns += static_cast<std::int64_t>(u.size());
        out_.left_out.equations += static_cast<std::int64_t>(blocks_.equations_of(b).size());
        continue;
      }
      block_needed_[idx(b)] = 1;
      require_inputs(s_, blocks_.equations_of(b), 0, positions);
    }
    derivatives_of_groups(need, 0, &Draft::wanted);
    need_ = need;
    derivatives_of_groups(need_, options_.predictor_derivatives, &Draft::derivatives);
  }

  [[nodiscard]] bool solved_each_step(Index b) const { return block_needed_[idx(b)] != 0 && block_moves_[idx(b)] != 0; }

  // From the last group back: the derivatives that it computes are those wanted of its unknowns, its inputs follow.
  void derivatives_of_groups(std::vector<std::int8_t>& need, int at_least, int Draft::* result) {
    for (auto d = drafts_.rbegin(); d != drafts_.rend(); ++d) {
      int derivatives = -1;
      for (const Index b : d->blocks) {
        if (!solved_each_step(b)) continue;
        derivatives = std::max(derivatives, at_least);
        for (const Index u : blocks_.unknowns_of(b)) derivatives = std::max(derivatives, int{need[idx(u)]});
      }
      (*d).*result = derivatives;
      if (derivatives < 0) continue;
      for (const Index b : d->blocks) {
        if (solved_each_step(b)) require_inputs_from_outside(b, static_cast<Index>(d.base() - drafts_.begin() - 1), derivatives, need);
      }
    }
  }

  // Inside the group only what others want counts as wanted: the last back-substitution may stop there.
  void require_inputs_from_outside(Index b, Index group, int derivatives, std::vector<std::int8_t>& need) {
    std::vector<Index> mentioned;
    for (const Index e : blocks_.equations_of(b)) {
      s_.mentioned(e, mentioned);
      for (const Index c : mentioned) {
        const Index o = block_at(c);
        const bool inside = o >= 0 && group_of_[idx(o)] == group;
        const auto n = static_cast<std::int8_t>(inside ? 0 : derivatives);
        need[idx(c)] = std::max(need[idx(c)], n);
      }
    }
  }

  // ---- classes

  void classify() {
    ClassTable table(s_, moves_);
    std::vector<Index> level_of;
    for (const Draft& d : drafts_) {
      std::vector<Index> blocks;
      bool is_static = false;
      for (const Index b : d.blocks) {
        if (solved_each_step(b)) blocks.push_back(b);
        if (block_moves_[idx(b)] == 0) is_static = true;
      }
      if (blocks.empty()) {
        if (is_static) {
          ++out_.left_out.static_groups;
        } else if (!d.blocks.empty()) {
          out_.left_out.groups.push_back(d.name);
        }
        continue;
      }
      Group group;
      group.name = d.name;
      group.of = d.of;
      group.level = d.level;
      group.wanted_derivatives = d.wanted;
      table.classify(content(d, blocks), group);
      if (d.wanted < 2) out_.left_out.levels.push_back({d.name, d.derivatives, d.derivatives > d.wanted});
      out_.groups.push_back(std::move(group));
    }
    watch_what_is_not_solved();
    out_.classes = table.take();
    // Levels without a gap, now that static and unneeded groups are gone.
    std::set<Index> used;
    for (const Group& g : out_.groups) used.insert(g.level);
    level_of.assign(used.begin(), used.end());
    for (Group& g : out_.groups) {
      g.level = static_cast<Index>(std::lower_bound(level_of.begin(), level_of.end(), g.level) - level_of.begin());
    }
    out_.levels = static_cast<Index>(level_of.size());
  }

  void watch_what_is_not_solved() {
    GroupContent watched;
    watched.derivatives = 0;
    watched.blocks = 0;
    std::vector<Index> mentioned;
    for (const Index e : out_.checks) {
      s_.mentioned(e, mentioned);
      const bool available = std::all_of(mentioned.begin(), mentioned.end(), [&](Index c) {
        const Index b = s_.coordinates[idx(c)].role == Role::unknown ? block_at(c) : -1;
        return b < 0 ? s_.coordinates[idx(c)].role != Role::unknown : block_moves_[idx(b)] == 0 || block_needed_[idx(b)] != 0;
      });
      const bool moving = std::any_of(mentioned.begin(), mentioned.end(), [&](Index c) { return moves_[idx(c)] != 0; });
      if (available && moving) watched.equations.push_back(e);
    }
    watched.equation_block.assign(watched.equations.size(), 0);
    ClassTable table(s_, moves_);
    table.classify(watched, out_.watch);
    out_.watch_class = table.take().front();
    out_.watch.name = "redundant equations";
  }

  Index block_at(Index coordinate) {
    if (block_of_.empty()) {
      block_of_.assign(s_.coordinates.size(), -1);
      for (Index k = 0; k < blocks_.size(); ++k) {
        for (const Index u : blocks_.unknowns_of(k)) block_of_[idx(u)] = k;
      }
    }
    return block_of_[idx(coordinate)];
  }

  [[nodiscard]] GroupContent content(const Draft& d, const std::vector<Index>& blocks) const {
    GroupContent c;
    c.derivatives = d.derivatives;
    c.blocks = static_cast<Index>(blocks.size());
    const bool all_predicted = options_.predictor_derivatives >= d.derivatives && d.derivatives > 0;
    const auto wanted = [&](Index u) { return all_predicted || d.derivatives == 0 || need_[idx(u)] >= d.derivatives; };
    for (const bool pass : {false, true}) {
      for (std::size_t k = 0; k < blocks.size(); ++k) {
        for (const Index u : blocks_.unknowns_of(blocks[k])) {
          if (wanted(u) != pass) continue;
          c.unknowns.push_back(u);
          c.unknown_block.push_back(static_cast<Index>(k));
        }
      }
      if (!pass) c.first_wanted = static_cast<Index>(c.unknowns.size());
    }
    for (std::size_t k = 0; k < blocks.size(); ++k) {
      for (const Index e : blocks_.equations_of(blocks[k])) {
        c.equations.push_back(e);
        c.equation_block.push_back(static_cast<Index>(k));
      }
    }
    return c;
  }

  // ---- names

  // The items of a block, at most four: "B1+e1+r1", "A+B+C+D+...".
  [[nodiscard]] std::string block_name(Index b) const { return names(b, 4, "+"); }
  [[nodiscard]] std::string all_names(Index b) const { return names(b, 1000, ", "); }
  [[nodiscard]] std::string names(Index b, std::size_t most, const char* separator) const {
    std::vector<std::string> found;
    const auto unknowns = blocks_.unknowns_of(b);
    for (std::size_t k = 0; k < unknowns.size() && found.size() <= most;) {
      // A whole point or vector by its name, else coordinate by coordinate.
      const Index id = s_.coordinates[idx(unknowns[k])].item;
      std::size_t end = k;
      while (end < unknowns.size() && s_.coordinates[idx(unknowns[end])].item == id) ++end;
      if (static_cast<int>(end - k) == s_.items[idx(id)].components) {
        found.push_back(s_.items[idx(id)].name);
      } else {
        for (std::size_t i = k; i < end; ++i) found.push_back(s_.coordinate_name(unknowns[i]));
      }
      k = end;
    }
    std::string out;
    for (std::size_t i = 0; i < std::min(found.size(), most); ++i) out += (i == 0 ? "" : separator) + found[i];
    return found.size() > most ? out + separator + "..." : out;
  }
  [[nodiscard]] std::string group_or_block_name(Index b) const {
    const Index u = blocks_.unknowns_of(b).front();
    for (const SystemGroup& g : s_.groups) {
      if (std::find(g.unknowns.begin(), g.unknowns.end(), u) != g.unknowns.end()) return g.name;
    }
    return block_name(b);
  }

  const StructureOptions& options_;
  System s_;
  Structure out_;
  std::vector<Index> equations_, unknowns_;
  Blocks blocks_;
  std::vector<double> q_;
  double time_ = 0;                         // of q_
  std::vector<Index> column_;               // scratch of DenseBlock
  std::vector<std::uint8_t> moves_;         // coordinates
  std::vector<std::uint8_t> block_moves_;   // blocks
  std::vector<std::uint8_t> block_needed_;  // blocks
  std::vector<Index> block_of_;             // coordinates; -1: known
  std::vector<Index> group_of_;             // blocks -> drafts_
  std::vector<Draft> drafts_;
  std::vector<std::int8_t> need_;           // coordinates: highest derivative that somebody reads
};

}  // namespace

Structure analyze(const Scene& scene, const StructureOptions& options) { return Analysis(scene, options).run(); }

std::int32_t Structure::fill(const Group& group) const {
  std::vector<Index> column(system->coordinates.size(), -1);
  const DenseBlock block(*system, group.equations, group.unknowns, column);
  Eigen::SparseMatrix<double> j = block.sparse_jacobian(start);
  j.makeCompressed();
  cs_di a{};
  a.nzmax = static_cast<int>(j.nonZeros());
  a.m = static_cast<int>(j.rows());
  a.n = static_cast<int>(j.cols());
  a.p = j.outerIndexPtr();
  a.i = j.innerIndexPtr();
  a.x = j.valuePtr();
  a.nz = -1;
  cs_dis* symbolic = cs_di_sqr(2, &a, 0);
  cs_din* numeric = symbolic == nullptr ? nullptr : cs_di_lu(&a, symbolic, 0.1);
  const std::int32_t fill = numeric == nullptr ? -1 : numeric->L->p[a.n] + numeric->U->p[a.n] - a.n;
  cs_di_nfree(numeric);
  cs_di_sfree(symbolic);
  return fill;
}

}  // namespace assur
