#include "motion/together.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "backends/lanes_factors.hpp"
#include "index.hpp"
#include "program/step_rules.hpp"

namespace assur {
namespace {

constexpr std::size_t up(std::size_t count, std::size_t to) { return (count + to - 1) / to; }

// Some classes have no inputs, couplings or loads.
double* at(LaneArray& numbers, std::size_t index) { return numbers.empty() ? nullptr : numbers.data() + index; }

}  // namespace

Together::Together(const Preparation& prepared, Layout& layout, Team* team)
    : structure_(*prepared.structure),
      layout_(layout),
      pack_of_(structure_.groups.size()),
      team_(team),
      threads_(team != nullptr ? idx(team->size()) : 1),
      kernels_(coupling_kernels()) {
  for (std::size_t p = 0; p < layout.packs.size(); ++p) {
    pack_of_[idx(layout.packs[p].groups[0])] = static_cast<std::int32_t>(p);
  }
  make_classes();
  for (Class& c : classes_) sort_entries(c);
  divide();
  for (Class& c : classes_) {
    for (Share& share : c.shares) fill(c, share);
  }
  make_rows();
  prediction_.resize(layout.size - layout.first_unknown);
}

// ---- preparation

std::size_t Together::shares(const GroupedSystem& structure) {
  std::vector<std::size_t> groups(structure.classes.size(), 0);
  for (const SolvedGroup& g : structure.groups) ++groups[idx(g.group_class)];
  std::size_t shares = 0;
  for (const std::size_t count : groups) shares += up(count, kTogetherLanes);
  return shares;
}

void Together::make_classes() {
  classes_.resize(structure_.classes.size());
  sources_.resize(layout_.address.size());
  for (std::size_t g = 0; g < structure_.groups.size(); ++g) {
    const SolvedGroup& group = structure_.groups[g];
    Class& c = classes_[idx(group.group_class)];
    for (std::size_t i = 0; i < group.unknowns.size(); ++i) {
      sources_[idx(group.unknowns[i])] = {group.group_class, static_cast<std::int32_t>(c.groups.size()),
                                          static_cast<std::int32_t>(i)};
    }
    c.groups.push_back(static_cast<std::int32_t>(g));
  }
  std::vector<Couplings> couplings = couplings_of(structure_);
  std::size_t unknowns = kTogetherLanes, loads = 0;  // see InputSources
  for (std::size_t k = 0; k < classes_.size(); ++k) {
    Class& c = classes_[k];
    const GroupClass& of = structure_.classes[k];
    c.solver = layout_.solvers[k].get();
    c.derivatives = of.derivatives;
    derivatives_ = std::max(derivatives_, c.derivatives);
    c.places = up(c.groups.size(), kTogetherLanes) * kTogetherLanes;
    c.couplings = std::move(couplings[k]);
    c.has_pivots = of.n <= kWithoutPivots;
    c.unknowns = unknowns;
    c.loads = loads;
    unknowns += idx(of.n) * c.places;
    loads += idx(c.couplings.rows()) * c.places;

    const Pack& single = pack(c, 0);
    c.coefficients.resize(single.coefficients.size() * c.places);
    for (std::size_t place = 0; place < c.places; ++place) {
      const LaneArray& from = pack(c, place).coefficients;
      for (std::size_t i = 0; i < from.size(); ++i) c.coefficients[i * c.places + place] = from[i];
    }
    c.lipschitz.resize(single.lipschitz.size() * c.places);
    for (std::size_t place = 0; place < c.places; ++place) {
      const LaneArray& from = pack(c, place).lipschitz;
      for (std::size_t i = 0; i < from.size(); ++i) c.lipschitz[i * c.places + place] = from[i];
    }
    c.anchor.resize(single.anchor.size() * c.places);
    c.anchor_rates.resize(c.anchor.size());
    c.anchor_time.resize(c.places);
    c.omega.resize(c.places);
    c.balls_used.resize(c.places);
    c.balls_used_before = c.balls_used;
    for (std::size_t place = 0; place < c.groups.size(); ++place) {
      pack(c, place).ball_used = std::span(c.balls_used).subspan(place, 1);
    }
    c.work.resize(work_of_together_step(of) * c.places);
    c.figures.resize(kGroupFigures * c.places);
    c.of_couplings.resize(c.couplings.entries.size() * c.places);
    for (LaneArray* const inputs : {&c.inputs[0], &c.inputs[1], &c.inputs[2], &c.known_rates, &c.sources}) {
      inputs->resize(idx(of.inputs) * c.places);
    }
  }
  for (LaneArray* const all : {&own_, &change_, &unknowns_[0], &unknowns_[1], &unknowns_[2]}) {
    all->resize(unknowns + kTogetherLanes);
  }
  for (const Class& c : classes_) {
    for (std::size_t k = 0; k < idx(c.couplings.rows()); ++k) columns_[k].resize(own_.size());
  }
  loads_.resize(loads);
}

const SolvedGroup& Together::group(const Class& c, std::size_t place) const {
  return structure_.groups[idx(c.groups[place < c.groups.size() ? place : 0])];
}
Pack& Together::pack(const Class& c, std::size_t place) const {
  return layout_.packs[idx(pack_of_[idx(c.groups[place < c.groups.size() ? place : 0])])];
}
Together::Source Together::source(const Class& c, std::size_t place, std::int32_t input) const {
  return sources_[idx(group(c, place).inputs[idx(input)])];
}
// In the arrays of unknowns.
std::int32_t Together::address(const Source& source) const {
  const Class& of = classes_[idx(source.of_class)];
  return static_cast<std::int32_t>(of.unknowns + idx(source.unknown) * of.places + idx(source.place));
}

// Entries of a row that read the same group everywhere become one part. Their gains follow.
void Together::sort_entries(Class& c) {
  std::vector<Couplings::Coupling>& entries = c.couplings.entries;
  std::vector<std::vector<Source>> of_parts;  // of the current row: the source of each group
  for (std::size_t e = 0; e < entries.size(); ++e) {
    if (e == 0 || entries[e].row != entries[e - 1].row) of_parts.clear();
    std::vector<Source> reads;
    for (std::size_t place = 0; place < c.groups.size(); ++place) reads.push_back(source(c, place, entries[e].input));
    const auto fits = [&](const std::vector<Source>& part) {
      for (std::size_t g = 0; g < reads.size(); ++g) {
        const bool both = reads[g].of_class >= 0 && part[g].of_class >= 0;
        if (both && (reads[g].of_class != part[g].of_class || reads[g].place != part[g].place)) return false;
      }
      return true;
    };
    const auto part = std::find_if(of_parts.begin(), of_parts.end(), fits);
    entries[e].part = static_cast<std::int32_t>(part - of_parts.begin());
    if (part == of_parts.end()) {
      of_parts.push_back(std::move(reads));
    } else {
      for (std::size_t g = 0; g < reads.size(); ++g) {
        if (reads[g].of_class >= 0) (*part)[g] = reads[g];
      }
    }
  }
  const auto part_of = [](const Couplings::Coupling& e) { return std::pair(e.row, e.part); };
  std::stable_sort(entries.begin(), entries.end(),
                   [&](const auto& a, const auto& b) { return part_of(a) < part_of(b); });
  for (std::size_t begin = 0, end = 0; begin < entries.size(); begin = end) {
    std::int32_t columns = 0;
    for (; end < entries.size() && part_of(entries[end]) == part_of(entries[begin]); ++end) {
      for (std::size_t place = 0; place < c.groups.size(); ++place) {
        if (const Source s = source(c, place, entries[end].input); s.of_class >= 0) {
          columns = std::max(columns, classes_[idx(s.of_class)].couplings.rows());
        }
      }
    }
    for (std::int32_t of = 0; of < columns; ++of) {
      c.gains.push_back({entries[begin].row, of, static_cast<std::int32_t>(begin), static_cast<std::int32_t>(end)});
    }
  }
  c.first_gain = gains_.size();
  gains_.resize(gains_.size() + c.gains.size() * c.places);
}

// Each thread gets consecutive places of all classes.
void Together::divide() {
  const std::size_t all = shares(structure_);
  std::size_t next = 0;  // kTogetherLanes places at a time
  for (Class& c : classes_) {
    for (std::size_t rank = 0; rank < threads_; ++rank) {
      const auto begin = [&](std::size_t r) {
        return std::clamp(up(r * all, threads_), next, next + c.places / kTogetherLanes) - next;
      };
      const std::size_t first = begin(rank) * kTogetherLanes, end = begin(rank + 1) * kTogetherLanes;
      Share& share = c.shares.emplace_back();
      share.first = first;
      share.lanes = end - first;
    }
    next += c.places / kTogetherLanes;
  }
}

TogetherClass Together::outline(const Class& c) const {
  return {c.solver->group_class(), c.solver->blocks().reads(0), c.couplings, c.elimination};
}

void Together::fill(Class& c, Share& share) {
  if (share.lanes == 0) return;
  find_sources(c, share);
  const auto put = [&](std::size_t memory, LaneArray& numbers, std::size_t begin = 0) {
    share.memory[memory] = at(numbers, begin + share.first);
  };
  const auto of = [](Memory m) { return static_cast<std::size_t>(m); };
  put(of(Memory::coefficients), c.coefficients);
  put(of(Memory::inputs), c.inputs[0]);
  put(of(Memory::input_rates), c.inputs[1]);
  put(of(Memory::input_accelerations), c.inputs[2]);
  put(of(Memory::anchor), c.anchor);
  put(of(Memory::omega), c.omega);
  put(of(Memory::lipschitz), c.lipschitz);
  put(of(Memory::anchor_rates), c.anchor_rates);
  put(of(Memory::anchor_time), c.anchor_time);
  put(of(Memory::ball_used), c.balls_used);
  put(of(Memory::work), c.work);
  put(of(Memory::figures), c.figures);
  put(of(Memory::couplings), c.of_couplings);
  put(of(Memory::sources), c.sources);
  put(of(Memory::loads), loads_, c.loads);
  put(of(Memory::own), own_, c.unknowns);
  put(of(Memory::change), change_, c.unknowns);
  put(of(Memory::unknowns), unknowns_[0], c.unknowns);
  put(of(Memory::rates), unknowns_[1], c.unknowns);
  put(of(Memory::accelerations), unknowns_[2], c.unknowns);
  for (std::size_t k = 0; k < idx(c.couplings.rows()); ++k) put(kColumns + k, columns_[k], c.unknowns);
  share.memory[of(Memory::settings)] = settings_.data();
}

// What a share reads of the state and of other groups.
void Together::find_sources(const Class& c, Share& share) const {
  const auto add = [&](std::size_t to, std::int32_t from) {
    const auto at = static_cast<std::int32_t>(to);
    if (!share.known.empty() && share.known.back().to + share.known.back().count == at) {
      Run& last = share.known.back();
      const std::int32_t step = from - (last.from + (last.count - 1) * last.step);
      if (step == last.step || (last.count == 1 && step == 1)) {
        last.step = step;
        ++last.count;
        return;
      }
    }
    share.known.push_back({at, from, 1, 0});
  };
  const GroupClass& of = c.solver->group_class();
  std::vector<std::int32_t> computed;
  for (std::int32_t i = 0; i < of.inputs; ++i) {
    for (std::size_t place = share.first; place < share.first + share.lanes; ++place) {
      const Source from = source(c, place, i);
      const bool is_computed = from.of_class >= 0;
      computed.push_back(is_computed ? address(from) : InputSources::kNone);
      if (!is_computed && of.input_moves[idx(i)] != 0) add(idx(i) * c.places + place, pack(c, place).inputs[idx(i)]);
    }
  }
  share.sources = InputSources(std::move(computed), share.lanes);
}

void Together::start(double* const (&state)[3]) {
  for (Class& c : classes_) {
    if (c.solver->group_class().n > kWithoutPivots) choose_pivots(c, state[0]);
    if (c.has_pivots && !c.has_passes) make_passes(c);
  }
  take(state[0]);
  forget();
}

// Those that serve the first groups of the class, as many as can be compared.
void Together::choose_pivots(Class& c, const double* state) {
  constexpr std::size_t kMost = 32;  // see markowitz_order()
  const std::size_t groups = std::min(c.groups.size(), kMost);
  const Pattern& pattern = c.solver->group_class().pattern;
  std::vector<double> jacobians(idx(pattern.nnz()) * groups);
  for (std::size_t place = 0; place < groups; ++place) {
    const LaneArray& of = c.solver->jacobian(pack(c, place), state);
    for (std::size_t k = 0; k < of.size(); ++k) jacobians[k * groups + place] = of[k];
  }
  const auto all = static_cast<std::uint32_t>((std::uint64_t{1} << groups) - 1);
  c.has_pivots = false;
  if (!std::all_of(jacobians.begin(), jacobians.end(), [](double x) { return std::isfinite(x); })) return;
  for (const lanes::PivotRule& rule : lanes::kRules) {
    const lanes::Order order = lanes::markowitz_order(pattern, jacobians, static_cast<int>(groups), all, rule);
    if (!order.complete(pattern.n) || order.served != all) continue;
    lanes::Elimination elimination = lanes::write_program(pattern, order);
    c.has_pivots = true;
    if (elimination == c.elimination) return;
    c.elimination = std::move(elimination);
    c.has_passes = false;
    return;
  }
}

void Together::make_passes(Class& c) {
  c.has_passes = true;
  c.is_coded = code_ != nullptr;
  for (Share& share : c.shares) {
    const TogetherShape shape{c.places, static_cast<int>(share.lanes)};
    for (std::size_t k = 0; k < kTogetherPasses && share.lanes > 0; ++k) {
      const auto pass = static_cast<TogetherPass>(k);
      const StepProgram program = together_program(pass, outline(c), shape);
      share.passes[k] = code_ != nullptr ? code_->of(program, shape.lanes_of(pass)) : nullptr;
      if (share.passes[k] != nullptr) continue;
      share.passes[k] = make_interpreter(program, shape.lanes_of(pass));
      c.is_coded = false;
    }
  }
}

std::size_t Together::coded_groups() const {
  std::size_t groups = 0;
  for (const Class& c : classes_) groups += c.is_coded ? c.groups.size() : 0;
  return groups;
}

void Together::make_rows() {
  std::vector<std::size_t> next(classes_.size(), 0);  // place of the next group of each class
  for (const SolvedGroup& group : structure_.groups) {
    const Class& c = classes_[idx(group.group_class)];
    const std::size_t place = next[idx(group.group_class)]++;
    for (std::int32_t k = 0; k < c.couplings.rows(); ++k) {
      LoadLinks row{static_cast<std::int32_t>(c.loads + idx(k) * c.places + place),
                    static_cast<std::int32_t>(links_.size()), 0};
      for (std::size_t j = 0; j < c.gains.size(); ++j) {
        if (c.gains[j].row != k) continue;
        Source from;
        for (std::int32_t e = c.gains[j].begin; e < c.gains[j].end && from.of_class < 0; ++e) {
          from = source(c, place, c.couplings.entries[idx(e)].input);
        }
        if (from.of_class < 0 || c.gains[j].of >= classes_[idx(from.of_class)].couplings.rows()) continue;
        const Class& other = classes_[idx(from.of_class)];
        links_.push_back(
            {static_cast<std::int32_t>(c.first_gain + j * c.places + place),
             static_cast<std::int32_t>(other.loads + idx(c.gains[j].of) * other.places + idx(from.place))});
      }
      row.end = static_cast<std::int32_t>(links_.size());
      add_row(row);
    }
  }
  for (const Class& c : classes_) {
    for (std::int32_t k = 0; k < c.couplings.rows(); ++k) {
      const std::size_t row = c.loads + idx(k) * c.places;
      for (std::size_t place = c.groups.size(); place < c.places; ++place) {
        idle_.push_back({static_cast<std::int32_t>(row + place), static_cast<std::int32_t>(row)});
      }
    }
  }
}

// Adds a row, or prolongs the chain of the last one.
void Together::add_row(const LoadLinks& row) {
  if (!rows_.empty() && row.end - row.begin == 1) {
    LoadLinks& before = rows_.back();
    const Link &link = links_[idx(row.begin)], &first = links_[idx(before.begin)];
    const std::int32_t last = before.at + before.chain - 1;
    if (before.end - before.begin == 1 && row.at == last + 1 && link.load == last &&
        link.gain == first.gain + before.chain) {
      ++before.chain;
      return;
    }
  }
  rows_.push_back(row);
}

// ---- one step

bool Together::solve(double* const (&state)[3], const Attempt& attempt, Counters& counters, StepErrors& errors) {
  for (const Class& c : classes_) {
    if (!c.has_pivots) return false;
  }
  if (!up_to_date_) take(state[0]);
  int corrections = 0;
  if (!converge(state, attempt, corrections)) return false;
  derive();
  if (largest(GroupFigure::failed) > 0) return false;
  Counters more;
  std::copy_n(state[0] + layout_.first_unknown, prediction_.size(), prediction_.begin());
  write(state);
  if (!keep_on_branch(state, attempt, more)) {
    undo(attempt.number);
    for (Pack& pack : layout_.packs) pack.undo(attempt.number);
    std::copy(prediction_.begin(), prediction_.end(), state[0] + layout_.first_unknown);
    forget();
    return false;
  }
  counters += more;
  count(corrections, counters);
  double position = largest(GroupFigure::position);
  if (position > std::max({errors.position, kConverged, attempt.known_residual})) {
    position = 0;
    for (const Pack& pack : layout_.packs) {
      position = std::max(position, layout_.solvers[idx(pack.group_class)]->residual_of(pack, state[0]));
    }
  }
  errors.position = std::max(errors.position, position);
  if (derivatives_ > 0) errors.velocity = std::max(errors.velocity, largest(GroupFigure::velocity));
  if (derivatives_ > 1) errors.acceleration = std::max(errors.acceleration, largest(GroupFigure::acceleration));
  return true;
}

// Each thread calls the works, one after the other, for its share of every class; all threads meet between two works.
template <class... Works>
void Together::pass(const Works&... works) {
  const auto part = [&](std::size_t rank) {
    bool first = true;
    const auto one = [&](const auto& work) {
      if (!std::exchange(first, false) && team_ != nullptr) team_->barrier();
      for (Class& c : classes_) {
        if (c.shares[rank].lanes > 0) work(c, c.shares[rank]);
      }
    };
    (one(works), ...);
  };
  if (team_ != nullptr) {
    team_->run([&](int rank) { part(idx(rank)); });
  } else {
    part(0);
  }
}

// Reads the prediction, and the coordinates that no group computes.
void Together::read(Class& c, const Share& share, double* const (&state)[3]) {
  kernels_.copy(share.known, state[0], c.inputs[0].data());
  if (c.derivatives > 0) {
    kernels_.copy(share.known, state[1], c.known_rates.data());
    kernels_.copy(share.known, state[1], c.inputs[1].data());
  }
  if (c.derivatives > 1) kernels_.copy(share.known, state[2], c.inputs[2].data());
  const std::size_t n = idx(c.solver->group_class().n), end = std::min(share.first + share.lanes, c.groups.size());
  const double* const from = state[0] + pack(c, 0).unknowns;
  double* const to = unknowns_[0].data() + c.unknowns;
  kernels_.part(from + share.first * n, n, end - share.first, c.places, to + share.first);
  for (std::size_t idle = end; idle < share.first + share.lanes; ++idle) {
    for (std::size_t j = 0; j < n; ++j) to[j * c.places + idle] = from[j];
  }
}

bool Together::converge(double* const (&state)[3], const Attempt& attempt, int& corrections) {
  const auto set = [&](GroupSetting s, double to) { settings_[slot_of(s).index] = to; };
  set(GroupSetting::converged_at, attempt.converged);
  set(GroupSetting::time, attempt.time);
  pass([&](Class& c, Share& share) { read(c, share, state); },
       [&](Class& c, Share& share) {
         kernels_.gather(share.sources, unknowns_[0].data(), c.places, at(c.inputs[0], share.first));
         share.run(TogetherPass::begin);
       });
  while (largest(GroupFigure::failed) <= 0) {
    if (largest(kOpen) <= 0) return true;
    if (corrections == attempt.most_iterations) return false;
    pass([&](Class& c, Share& share) { couple(c, share, own_, true); });
    complete_loads();
    set(GroupSetting::corrections, ++corrections);
    pass(
        [&](Class& c, Share& share) {
          complete(c, share, change_);
          kernels_.add(change_.data() + c.unknowns + share.first, idx(c.solver->group_class().n), c.places, share.lanes,
                       unknowns_[0].data() + c.unknowns + share.first);
        },
        [&](Class& c, Share& share) {
          if (corrections == 1) {
            kernels_.gather(share.sources, change_.data(), c.places, at(c.sources, share.first));
            share.run(TogetherPass::approach);
          }
          kernels_.gather(share.sources, unknowns_[0].data(), c.places, at(c.inputs[0], share.first));
          share.run(TogetherPass::linearise);
        });
  }
  return false;
}

void Together::derive() {
  if (derivatives_ > 0) {
    pass(
        [&](Class& c, Share& share) {
          if (c.derivatives < 1) return;
          share.memory[static_cast<std::size_t>(Memory::input_rates)] = at(c.known_rates, share.first);
          share.run(TogetherPass::rates);
        },
        [&](Class& c, Share& share) {
          if (c.derivatives > 0) couple(c, share, own_, true);
        });
    complete_loads();
    pass(
        [&](Class& c, Share& share) {
          if (c.derivatives > 0) complete(c, share, unknowns_[1]);
        },
        [&](Class& c, Share& share) {
          if (c.derivatives < 1) return;
          kernels_.gather(share.sources, unknowns_[1].data(), c.places, at(c.inputs[1], share.first));
          share.memory[static_cast<std::size_t>(Memory::input_rates)] = at(c.inputs[1], share.first);
          share.run(TogetherPass::accelerations);
        });
  }
  if (derivatives_ > 1) {
    pass([&](Class& c, Share& share) {
      if (c.derivatives > 1) couple(c, share, own_, false);
    });
    complete_loads();
    pass(
        [&](Class& c, Share& share) {
          if (c.derivatives > 1) complete(c, share, unknowns_[2]);
        },
        [&](Class& c, Share& share) {
          if (c.derivatives > 1) couple(c, share, unknowns_[2], false);
        });
  }
  pass([&](Class&, Share& share) { share.run(TogetherPass::finish); });
}

// Computes the loads of given changes of other groups, and the gains.
void Together::couple(const Class& c, const Share& share, const LaneArray& changes, bool with_gains) {
  const auto sum = [&](std::int32_t begin, std::int32_t end, const LaneArray& numbers, double* to) {
    kernels_.couple(share.sources, std::span(c.couplings.entries).subspan(idx(begin), idx(end - begin)),
                    c.of_couplings.data() + idx(begin) * c.places + share.first, c.places, numbers.data(),
                    to + share.first);
  };
  const std::vector<Couplings::Coupling>& entries = c.couplings.entries;
  for (std::int32_t begin = 0, end = 0; begin < std::ssize(entries); begin = end) {
    const std::int32_t row = entries[idx(begin)].row;
    while (end < std::ssize(entries) && entries[idx(end)].row == row) ++end;
    sum(begin, end, changes, loads_.data() + c.loads + idx(row) * c.places);
  }
  if (!with_gains) return;
  double* to = gains_.data() + c.first_gain;
  for (const Gain& g : c.gains) {
    sum(g.begin, g.end, columns_[idx(g.of)], to);
    to += c.places;
  }
}

// The changes of a share with all loads.
void Together::complete(const Class& c, const Share& share, LaneArray& to) {
  const std::size_t first = c.unknowns + share.first;
  const double* columns[kMostCoupledRows];
  for (std::size_t k = 0; k < idx(c.couplings.rows()); ++k) columns[k] = columns_[k].data() + first;
  kernels_.complete(own_.data() + first, columns, at(loads_, c.loads + share.first), idx(c.solver->group_class().n),
                    idx(c.couplings.rows()), c.places, share.lanes, to.data() + first);
}

// The recurrence through the levels.
void Together::complete_loads() {
  double* const loads = loads_.data();
  const double* const gains = gains_.data();
  for (const LoadLinks& row : rows_) {
    if (row.end - row.begin == 1) {
      const Link& link = links_[idx(row.begin)];
      kernels_.chain(gains + link.gain, loads[link.load], row.chain, loads + row.at);
      continue;
    }
    double sum = loads[row.at];
    for (std::int32_t l = row.begin; l < row.end; ++l) sum += gains[links_[idx(l)].gain] * loads[links_[idx(l)].load];
    loads[row.at] = sum;
  }
  for (const Copy& copy : idle_) loads[copy.to] = loads[copy.from];
}

double Together::largest(GroupFigure f) const {
  double out = 0;
  for (const Class& c : classes_) {
    out = std::max(out, kernels_.largest(c.figures.data() + static_cast<std::size_t>(f) * c.places, c.places));
  }
  return out;
}

// Writes the solution to the state.
void Together::write(double* const (&state)[3]) {
  pass([&](Class& c, Share& share) {
    const std::size_t n = idx(c.solver->group_class().n), end = std::min(share.first + share.lanes, c.groups.size());
    const std::size_t to = pack(c, 0).unknowns + share.first * n;  // the groups of a class follow each other
    for (std::size_t d = 0; d <= idx(c.derivatives); ++d) {
      kernels_.join(unknowns_[d].data() + c.unknowns + share.first, n, end - share.first, c.places, state[d] + to);
    }
  });
}

bool Together::keep_on_branch(double* const (&state)[3], const Attempt& attempt, Counters& counters) {
  balls_of_ = attempt.number;
  for (Class& c : classes_) c.balls_used_before = c.balls_used;
  for (Class& c : classes_) {
    const auto row = [&](GroupFigure f) { return c.figures.data() + static_cast<std::size_t>(f) * c.places; };
    const double *const needs_anchor = row(GroupFigure::needs_anchor), *const failed = row(GroupFigure::failed);
    std::copy_n(row(GroupFigure::ball_used), c.places, c.balls_used.begin());
    if (kernels_.largest(needs_anchor, c.places) <= 0) continue;
    for (std::size_t eight = 0; eight < c.places; eight += kTogetherLanes) {
      if (kernels_.largest(needs_anchor + eight, kTogetherLanes) <= 0) continue;
      const auto begin = static_cast<std::ptrdiff_t>(eight);
      std::copy_n(c.balls_used_before.begin() + begin, kTogetherLanes, c.balls_used.begin() + begin);
      renew_anchors(c, eight);
      for (std::size_t place = eight; place < std::min(eight + kTogetherLanes, c.groups.size()); ++place) {
        if (needs_anchor[place] <= 0) continue;
        Pack& of = pack(c, place);
        if (failed[place] <= 0) {
          of.keep_anchor(attempt.number);
          give_guard(c, place);
          ++counters.branch_checks;
          continue;
        }
        if (!c.solver->renew_anchor(of, state, attempt, counters).ok()) return false;
        take_guard(c, place);
        for (std::size_t idle = c.groups.size(); place == 0 && idle < c.places; ++idle) {
          take_guard(c, idle);
          c.balls_used[idle] = c.balls_used[0];
        }
      }
    }
  }
  return true;
}

// Of eight places, where that is necessary.
void Together::renew_anchors(Class& c, std::size_t eight) {
  for (Share& share : c.shares) {
    if (eight < share.first || eight >= share.first + share.lanes) continue;
    std::array<double*, kMemories> memory = share.memory;
    for (double*& at : memory) {
      if (at != nullptr && at != settings_.data()) at += eight - share.first;
    }
    share.passes[static_cast<std::size_t>(TogetherPass::anchors)]->run(memory);
  }
}

void Together::undo(std::int64_t attempt) {
  if (balls_of_ != attempt) return;
  balls_of_ = 0;
  for (Class& c : classes_) std::copy(c.balls_used_before.begin(), c.balls_used_before.end(), c.balls_used.begin());
}

void Together::count(int corrections, Counters& counters) const {
  for (const Class& c : classes_) {
    const auto groups = static_cast<std::int64_t>(c.groups.size());
    const std::int64_t unknowns = groups * c.solver->group_class().n;
    const std::int64_t right_sides = corrections + c.derivatives + (corrections + 1) * c.couplings.rows();
    counters.group_solutions += groups;
    counters.newton_iterations += groups * corrections;
    counters.evaluated_equations += unknowns * (corrections + 1);
    counters.factorizations += groups * (corrections + 1);
    counters.factorized_unknowns += unknowns * (corrections + 1);
    counters.solved_unknowns += unknowns * right_sides;
  }
  counters.most_iterations = std::max<std::int64_t>(counters.most_iterations, corrections);
}

// Copies the guards of all packs of the layout, and the inputs that no group computes.
void Together::take(const double* state) {
  for (Class& c : classes_) {
    for (std::size_t place = 0; place < c.places; ++place) {
      take_guard(c, place);
      const std::vector<std::int32_t>& inputs = pack(c, place).inputs;
      for (std::size_t i = 0; i < inputs.size(); ++i) {
        if (source(c, place, static_cast<std::int32_t>(i)).of_class < 0) {
          c.inputs[0][i * c.places + place] = state[idx(inputs[i])];
        }
      }
    }
  }
  up_to_date_ = true;
}

// Calls work(array of a group, array of the class) for what new anchors change.
template <class Work>
void Together::each_of_guard(Class& c, Pack& of, const Work& work) {
  work(of.anchor, c.anchor);
  work(of.anchor_rates, c.anchor_rates);
  work(of.anchor_time, c.anchor_time);
  work(of.omega, c.omega);
}
void Together::take_guard(Class& c, std::size_t place) {
  each_of_guard(c, pack(c, place), [&](const LaneArray& from, LaneArray& to) {
    for (std::size_t i = 0; i < from.size(); ++i) to[i * c.places + place] = from[i];
  });
}
void Together::give_guard(Class& c, std::size_t place) {
  each_of_guard(c, pack(c, place), [&](LaneArray& to, const LaneArray& from) {
    for (std::size_t i = 0; i < to.size(); ++i) to[i] = from[i * c.places + place];
  });
}

}  // namespace assur
