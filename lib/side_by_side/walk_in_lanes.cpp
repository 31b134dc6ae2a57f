#include "side_by_side/walk_in_lanes.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "index.hpp"
#include "structure/classes.hpp"

namespace assur {
namespace {

constexpr double kShortest = 0x1p-6;  // step; one mechanism alone takes steps of its own
constexpr Stride kFirst{.length = 1, .patience = 2};

Law line(double from, double change) { return Law::polynomial({from, change}); }

// Adds an input that goes from 1 to 0. Each equation is less this times what is open in it.
void add_openness(System& s) {
  const auto z = static_cast<Index>(s.coordinates.size());
  s.coordinates.push_back({-1, 0, 0, Role::driven, true});
  s.guess.push_back(0);
  DriverInput input;
  input.first = z;
  input.count = 1;
  input.laws = {Law()};
  s.inputs.push_back(std::move(input));
  for (Equation& e : s.equations) {
    if (e.linear >= 0) {
      const auto old = s.form(e.linear);
      const std::vector<Term> terms(old.begin(), old.end());
      s.terms.insert(s.terms.end(), terms.begin(), terms.end());
    }
    s.terms.push_back({z, static_cast<Index>(s.constants.size())});
    s.constants.push_back(0);
    s.form_start.push_back(static_cast<Index>(s.terms.size()));
    e.linear = s.forms() - 1;
  }
}

std::shared_ptr<const Structure> structure_of(std::shared_ptr<const System> system,
                                              const std::vector<WalkedPart>& parts) {
  const std::vector<std::uint8_t> moves(system->coordinates.size(), 1);
  auto out = std::make_shared<Structure>();
  ClassTable table(*system, moves);
  for (const WalkedPart& part : parts) {
    GroupContent content;
    content.unknowns = part.unknowns;
    content.equations = part.equations;
    content.unknown_block.assign(part.unknowns.size(), 0);
    content.equation_block.assign(part.equations.size(), 0);
    Group& group = out->groups.emplace_back();
    group.of = static_cast<Index>(part.unknowns.size());
    group.level = out->levels++;
    table.classify(content, group);
  }
  out->classes = table.take();
  out->system = std::move(system);
  return out;
}

Prepared prepared_for(std::shared_ptr<const Structure> structure, int lanes) {
  Prepared out;
  out.table = backends();
  out.plan.lanes = lanes;
  out.plan.run.predictor = {Predictor::Kind::hermite, 5};
  for (Index c = 0; c < std::ssize(structure->classes); ++c) {
    Plan::Choice choice;
    choice.group_class = c;
    choice.shape.n = structure->classes[idx(c)].n;
    choice.shape.nnz = structure->pattern(c).nnz();
    choice.shape.rhs = 3;
    choice.solver.backend = "lanes";
    out.plan.choices.push_back(std::move(choice));
  }
  out.structure = std::move(structure);
  return out;
}

}  // namespace

WalkInLanes::WalkInLanes(const System& system, const std::vector<WalkedPart>& parts, int lanes)
    : system_(std::make_shared<System>(system)), numbers_(system.constants.size()), lanes_(idx(lanes)) {
  // Nothing is measured on the way, and limits count at its end.
  system_->outputs.clear();
  system_->items.clear();
  system_->measures.clear();
  system_->bounds.clear();
  add_openness(*system_);
  structure_ = structure_of(system_, parts);
}

void WalkInLanes::add(const System& numbers, const Way& way, std::span<const double> q) {
  Lane& lane = lanes_[members_++];
  if (!lane.system) {
    lane.system = std::make_shared<System>(*system_);
    lane.variant.system = lane.system;
    lane.variant.changes = Variant::Changes{false, true, true};
  }
  System& s = *lane.system;
  std::copy(numbers.constants.begin(), numbers.constants.end(), s.constants.begin());
  const bool closes = !way.open.empty();
  for (std::size_t e = 0; e < s.equations.size(); ++e) s.constants[numbers_ + e] = closes ? -way.open[e] : 0;
  s.inputs.back().laws[0] = closes ? line(1, -1) : Law();
  for (std::size_t i = 0; i < way.from.size(); ++i) {
    for (std::size_t k = 0; k < way.from[i].size(); ++k) s.inputs[i].laws[k] = line(way.from[i][k], way.change[i][k]);
  }
  lane.arrived = false;
  lane.variant.posture.assign(q.begin(), q.end());
  lane.variant.posture.push_back(closes ? 1 : 0);
}

// Moves the mechanisms in the tile to s = 1. Not ok: they cannot take the shortest step together.
Status WalkInLanes::follow(std::vector<std::size_t>& in_tile) {
  std::vector<const Variant*> variants;
  for (const std::size_t i : in_tile) {
    lanes_[i].variant.time = at_;
    variants.push_back(&lanes_[i].variant);
  }
  if (const Status s = tile_->start(variants); !s.ok()) return s;
  Status s;
  while (at_ < 1 && s.ok()) {
    const double to = std::min(at_ + stride_.length, 1.0);
    s = tile_->step(std::vector<double>(in_tile.size(), to));
    if (s.ok()) {
      at_ = to;
      stride_.arrive();
    } else if (stride_.length > kShortest) {
      s = {};
      stride_.set(stride_.length / 2);
    }
  }
  for (std::size_t lane = 0; lane < in_tile.size(); ++lane) {
    lanes_[in_tile[lane]].variant.posture = tile_->posture(static_cast<int>(lane));
  }
  return s;
}

void WalkInLanes::run() {
  if (members_ == 0) return;
  if (!tile_) {
    tile_.emplace(prepared_for(structure_, static_cast<int>(lanes_.size())), StepLimits{});
    tile_->keep_pivots(lanes_[0].variant);
  }
  std::vector<std::size_t> in_tile(members_);
  std::iota(in_tile.begin(), in_tile.end(), 0);
  at_ = 0;
  stride_ = kFirst;
  while (!in_tile.empty()) {
    const Status s = follow(in_tile);
    if (s.ok()) break;
    if (!s.where.is(Place::Kind::lane)) return;
    in_tile.erase(in_tile.begin() + s.where.index);
  }
  for (const std::size_t i : in_tile) lanes_[i].arrived = true;
}

}  // namespace assur
