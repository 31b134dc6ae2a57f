#include "structure/start.hpp"

#include <algorithm>
#include <cstdio>
#include <numeric>
#include <set>
#include <unordered_map>

#include "structure/assembly.hpp"
#include "structure/block_names.hpp"
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

class Start {
 public:
  Start(const System& system, Problem& problem, Structure& out)
      : s_(system), p_(problem), out_(out), column_(system.coordinates.size(), -1) {}

  void run() {
    split_equations();
    p_.blocks = decompose(s_, p_.equations, p_.unknowns);
    const std::vector<Index> singular = assemble_blocks();
    const bool refused = !out_.cannot_assemble.empty() && p_.blocks.square();
    if (!refused && !(p_.blocks.square() && singular.empty())) study_doubtful_parts(singular);
    check_handedness();
  }

 private:
  // Equations among known coordinates only are checked, never solved.
  void split_equations() {
    std::vector<Index> mentioned;
    for (Index e = 0; e < static_cast<Index>(s_.equations.size()); ++e) {
      s_.mentioned(e, mentioned);
      const bool solves = std::any_of(mentioned.begin(), mentioned.end(),
                                      [&](Index c) { return s_.coordinates[idx(c)].role == Role::unknown; });
      if (solves) {
        p_.equations.push_back(e);
      } else {
        out_.checks.push_back(e);
        out_.redundant.push_back({{s_.equation_name(e)}, s_.equation_name(e)});
        if (relative_residual(e) > kConsistent) contradiction({s_.equation_name(e)}, relative_residual(e));
      }
    }
  }

  [[nodiscard]] double relative_residual(Index e) const {
    const double scale = residual_scale(s_, e, p_.q);
    const double phi = std::abs(residual<double>(s_, e, p_.q));
    return scale > 0 ? phi / scale : phi;
  }

  void contradiction(const std::vector<std::string>& names, double by) {
    if (!out_.cannot_assemble.empty()) return;
    out_.cannot_assemble = "these contradict each other: ";
    for (std::size_t i = 0; i < names.size(); ++i) out_.cannot_assemble += (i == 0 ? "'" : ", '") + names[i] + "'";
    out_.cannot_assemble += " (relative residual " + shortened(by) + ")";
  }

  // Returns the blocks whose Jacobian is rank-deficient at the assembled posture.
  std::vector<Index> assemble_blocks() {
    std::vector<Index> singular;
    for (Index b = 0; b < p_.blocks.size(); ++b) {
      const BlockAssembly a = assemble(s_, p_.blocks.equations_of(b), p_.blocks.unknowns_of(b), p_.q, column_);
      if (!a.converged) {
        if (p_.blocks.square()) refuse_block(b, a);
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
    out_.cannot_assemble = "group " + group_or_block_name(s_, p_.blocks, b) + " cannot be assembled: '" +
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
      take(study_rank(s_, equations, unknowns, p_.time, p_.q, column_), static_cast<Index>(unknowns.size()), kept);
    }
    std::sort(kept.begin(), kept.end());
    p_.equations = std::move(kept);
    p_.blocks = decompose(s_, p_.equations, p_.unknowns);
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

  // The equations of a frame driven inside a declared group hold for its mirror image as well.
  void check_handedness() {
    for (const Frame& f : s_.frames) {
      if (!out_.cannot_assemble.empty() || !out_.undetermined.empty()) return;
      double a[3][3];
      for (int j = 0; j < 3; ++j) {
        for (int k = 0; k < 3; ++k) a[j][k] = form_value<double>(s_, s_.items[idx(f.item[j])].form[k], p_.q);
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

  const System& s_;
  Problem& p_;
  Structure& out_;
  std::vector<Index> column_;  // scratch of DenseBlock
};

}  // namespace

void assemble_start(const System& system, Problem& problem, Structure& out) { Start(system, problem, out).run(); }

}  // namespace assur
