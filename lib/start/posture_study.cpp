#include "start/posture_study.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "decimal.hpp"
#include "equations/residual_scale.hpp"
#include "graph/block_names.hpp"
#include "graph/idle_parts.hpp"
#include "index.hpp"
#include "scene/names.hpp"
#include "start/assembly.hpp"
#include "start/frame_axes.hpp"
#include "start/other_postures.hpp"
#include "start/rank.hpp"
#include "start/redundant_sets.hpp"
#include "start/violated.hpp"

namespace assur {
namespace {

// See study_posture().
class PostureStudy {
 public:
  PostureStudy(const System& system, Problem& problem, StartFindings& out)
      : s_(system), p_(problem), out_(out), column_(system.coordinates.size(), -1) {}

  // Returns the parts that are not regular.
  DoubtfulParts run() {
    divide();
    const std::vector<Index> singular = assemble_blocks();
    const bool refused = !out_.cannot_assemble.empty() && p_.blocks.square();
    if (!refused && !(p_.blocks.square() && singular.empty())) study_doubtful_parts(singular);
    check_frames();
    return std::move(doubtful_);
  }

  // Finds the equations to solve and their blocks, without idle parts.
  void divide() {
    split_equations();
    p_.blocks = decompose(s_, p_.equations, p_.unknowns);
    leave_out_idle_parts();
    leave_out_parts_behind();
  }

 private:
  // Leaves parts out that no output needs, and that cannot be followed to the start.
  void leave_out_parts_behind() {
    if (p_.left_behind.empty()) return;
    std::vector<Index> mentioned;
    const auto is_left = [&](Index c) { return std::binary_search(p_.left_behind.begin(), p_.left_behind.end(), c); };
    std::erase_if(p_.unknowns, is_left);
    std::erase_if(p_.equations, [&](Index e) {
      s_.mentioned(e, mentioned);
      return std::any_of(mentioned.begin(), mentioned.end(), is_left);
    });
    p_.blocks = decompose(s_, p_.equations, p_.unknowns);
    idle_.insert(idle_.end(), p_.left_behind.begin(), p_.left_behind.end());
    std::sort(idle_.begin(), idle_.end());
  }

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
    out_.cannot_assemble += " (relative residual " + general(by, 3) + "); " + most_violated(s_, equations, p_.q);
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
      take(study_rank(s_, equations, unknowns, laws_from, p_.checked, p_.q, column_), equations, kept);
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
                             general(axes.skew, 3) + "); correct its fixed or driven vectors";
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
  StartFindings& out_;
  std::vector<Index> idle_;  // unknowns that are left out
  DoubtfulParts doubtful_;
  std::vector<Index> column_;  // scratch of DenseBlock
};

}  // namespace

void divide(const System& system, Problem& problem, StartFindings& out) { PostureStudy(system, problem, out).divide(); }

DoubtfulParts study_posture(const System& system, Problem& problem, StartFindings& out) {
  return PostureStudy(system, problem, out).run();
}

}  // namespace assur
