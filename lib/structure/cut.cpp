#include "structure/cut.hpp"

#include <algorithm>

#include "equations/outputs.hpp"
#include "graph/demand.hpp"
#include "index.hpp"

namespace assur {
namespace {

// A block moves if one of its inputs does.
void find_moving(const System& s, const Blocks& blocks, Cut& cut) {
  cut.moves.assign(s.coordinates.size(), 0);
  for (std::size_t c = 0; c < s.coordinates.size(); ++c) {
    cut.moves[c] = s.coordinates[c].role == Role::driven && s.coordinates[c].moving ? 1 : 0;
  }
  std::vector<Index> mentioned;
  cut.block_moves.assign(idx(blocks.size()), 0);
  for (Index b = 0; b < blocks.size(); ++b) {
    for (const Index e : blocks.equations_of(b)) {
      s.mentioned(e, mentioned);
      for (const Index c : mentioned) cut.block_moves[idx(b)] |= cut.moves[idx(c)];
    }
    for (const Index u : blocks.unknowns_of(b)) cut.moves[idx(u)] = cut.block_moves[idx(b)];
  }
}

// Goes from the last block to the first, because blocks need earlier ones.
void find_needed_blocks(const System& s, const Blocks& blocks, std::span<const Index> checks,
                        std::vector<std::int8_t> need, Cut& cut) {
  require_inputs(s, checks, 0, need);
  cut.block_needed.assign(idx(blocks.size()), 0);
  for (Index b = blocks.size() - 1; b >= 0; --b) {
    const auto u = blocks.unknowns_of(b);
    if (std::none_of(u.begin(), u.end(), [&](Index c) { return need[idx(c)] >= 0; })) continue;
    cut.block_needed[idx(b)] = 1;
    require_inputs(s, blocks.equations_of(b), 0, need);
  }
}

// Coordinates that must stay positive are also checked between two postures, which needs their derivatives.
void need_motions_of_levers(const System& s, const Blocks& blocks, const Cut& cut, std::vector<std::int8_t>& need) {
  if (s.positive.empty()) return;
  std::vector<std::uint8_t> solved(s.coordinates.size(), 0);
  for (Index b = 0; b < blocks.size(); ++b) {
    if (!cut.solved_each_step(b)) continue;
    for (const Index u : blocks.unknowns_of(b)) solved[idx(u)] = 1;
  }
  for (const Positive& p : s.positive) {
    if (solved[idx(p.coordinate)] != 0) need[idx(p.coordinate)] = 2;
  }
}

// Goes from the last group to the first. A group computes `at_least` derivatives, and as many as others need of its
// unknowns; its inputs then need as many. Unknowns that only the group itself needs do not count: the last
// back-substitution may skip them.
void find_derivatives(const System& s, const Blocks& blocks, const std::vector<Draft>& drafts, int at_least,
                      int Cut::Derivatives::*result, std::vector<std::int8_t>& need, Cut& cut) {
  std::vector<Index> group_at(s.coordinates.size(), -1);
  for (std::size_t g = 0; g < drafts.size(); ++g) {
    for (const Index b : drafts[g].blocks) {
      for (const Index u : blocks.unknowns_of(b)) group_at[idx(u)] = static_cast<Index>(g);
    }
  }
  std::vector<Index> mentioned;
  for (std::size_t g = drafts.size(); g-- > 0;) {
    int derivatives = -1;
    for (const Index b : drafts[g].blocks) {
      if (!cut.solved_each_step(b)) continue;
      derivatives = std::max(derivatives, at_least);
      for (const Index u : blocks.unknowns_of(b)) derivatives = std::max(derivatives, int{need[idx(u)]});
    }
    cut.groups[g].*result = derivatives;
    if (derivatives < 0) continue;
    for (const Index b : drafts[g].blocks) {
      if (!cut.solved_each_step(b)) continue;
      for (const Index e : blocks.equations_of(b)) {
        s.mentioned(e, mentioned);
        for (const Index c : mentioned) {
          const int n = group_at[idx(c)] == static_cast<Index>(g) ? 0 : derivatives;
          need[idx(c)] = std::max(need[idx(c)], static_cast<std::int8_t>(n));
        }
      }
    }
  }
}

}  // namespace

Cut cut_to_outputs(const System& s, const Blocks& blocks, const std::vector<Draft>& drafts,
                   std::span<const Index> checks, int predictor_derivatives) {
  Cut cut;
  cut.groups.resize(drafts.size());
  std::vector<std::int8_t> need = needed_by_outputs(s, wanted_outputs(s));
  if (!s.bounds.empty()) {  // limits are also checked between two postures, which needs their derivatives
    const std::vector<std::int8_t> of_limits = needed_by_outputs(s, limited_outputs(s));
    for (std::size_t c = 0; c < need.size(); ++c) need[c] = std::max(need[c], of_limits[c]);
  }
  for (const Draft& d : drafts) {
    if (!d.keep) continue;
    for (const Index b : d.blocks) {
      for (const Index u : blocks.unknowns_of(b)) need[idx(u)] = 2;
    }
  }
  find_moving(s, blocks, cut);
  find_needed_blocks(s, blocks, checks, need, cut);
  need_motions_of_levers(s, blocks, cut, need);
  find_derivatives(s, blocks, drafts, 0, &Cut::Derivatives::wanted, need, cut);
  find_derivatives(s, blocks, drafts, predictor_derivatives, &Cut::Derivatives::computed, need, cut);
  cut.need = std::move(need);
  return cut;
}

}  // namespace assur
