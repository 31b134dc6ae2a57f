#include "path/together.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "index.hpp"
#include "program/step_rules.hpp"

namespace assur {
namespace {

constexpr std::size_t kZeros = kMostLanes;  // numbers at the beginning of each array of a Coupling

// The larger one; NaN if one is NaN.
void raise(double& to, double by) {
  if (!(by <= to)) to = by;
}

}  // namespace

Together::Together(const Prepared& prepared, Layout& layout, Team* team)
    : structure_(*prepared.structure),
      layout_(layout),
      pack_of_(structure_.groups.size()),
      team_(team),
      shares_(team != nullptr ? idx(team->size()) : 1),
      chain_(chain_of_loads()) {
  for (std::size_t p = 0; p < layout.packs.size(); ++p) {
    pack_of_[idx(layout.packs[p].groups[0])] = static_cast<std::int32_t>(p);
  }
  make_steps(prepared);
  std::size_t pack = 0, packs = Together::packs(prepared);
  for (Class& c : classes_) fill_packs(c, pack, packs);
  for (Class& c : classes_) find_parts(c);
  make_rows();
  prediction_.resize(layout.size - layout.first_unknown);
}

// ---- preparation

std::size_t Together::packs(const Prepared& prepared) {
  const Structure& s = *prepared.structure;
  std::vector<std::size_t> groups(s.classes.size(), 0);
  for (const Group& g : s.groups) ++groups[idx(g.group_class)];
  std::size_t packs = 0;
  for (std::size_t c = 0; c < groups.size(); ++c) {
    const std::size_t lanes = idx(prepared.plan.choices[c].solver.lanes);
    packs += (groups[c] + lanes - 1) / lanes;
  }
  return packs;
}

void Together::make_steps(const Prepared& prepared) {
  classes_.resize(structure_.classes.size());
  sources_.resize(layout_.address.size());
  for (std::size_t g = 0; g < structure_.groups.size(); ++g) {
    const Group& group = structure_.groups[g];
    Class& c = classes_[idx(group.group_class)];
    for (std::size_t i = 0; i < group.unknowns.size(); ++i) {
      sources_[idx(group.unknowns[i])] = {group.group_class, static_cast<std::int32_t>(c.groups.size()),
                                          static_cast<std::int32_t>(i)};
    }
    c.groups.push_back(static_cast<std::int32_t>(g));
  }
  std::size_t unknowns = kZeros, loads = kZeros;
  for (std::size_t k = 0; k < classes_.size(); ++k) {
    Class& c = classes_[k];
    const GroupClass& of = structure_.classes[k];
    std::vector<std::uint8_t> computed(idx(of.inputs), 0);
    for (const std::int32_t g : c.groups) {
      const std::vector<std::int32_t>& inputs = structure_.groups[idx(g)].inputs;
      for (std::size_t i = 0; i < inputs.size(); ++i) {
        if (sources_[idx(inputs[i])].of_class >= 0) computed[i] = 1;
      }
    }
    c.lanes = prepared.plan.choices[k].solver.lanes;
    c.derivatives = of.derivatives;
    derivatives_ = std::max(derivatives_, c.derivatives);
    c.solver = layout_.solvers[k].get();
    for (std::size_t rank = 0; rank < shares_.size(); ++rank) {
      c.steps.push_back(c.solver->together_step(computed, c.lanes));
    }
    const std::size_t w = idx(c.lanes), groups = (c.groups.size() + w - 1) / w * w;
    c.places = {unknowns, loads, 0, groups};
    unknowns += idx(of.n) * groups;
    loads += idx(c.step().rows()) * groups;
  }
  coupling_.own.resize(unknowns);
  coupling_.change.resize(unknowns);
  for (LaneArray& column : coupling_.columns) column.resize(unknowns);
  coupling_.loads.resize(loads);
}

std::int32_t Together::address(const Source& source) const {
  if (source.of_class < 0) return 0;
  const TogetherStep::Places& at = classes_[idx(source.of_class)].places;
  return static_cast<std::int32_t>(at.unknowns + idx(source.unknown) * at.groups + idx(source.place));
}

// The source of an entry of a class in one of its groups.
Together::Source Together::source(const Class& c, std::int32_t group, std::size_t entry) const {
  return sources_[idx(structure_.groups[idx(group)].inputs[idx(c.step().entries()[entry].input)])];
}

// Each thread gets consecutive packs of all classes. pack_number: that of the first pack of the class.
void Together::fill_packs(Class& c, std::size_t& pack_number, std::size_t packs) {
  const std::size_t w = idx(c.lanes);
  c.balls_used.assign(c.places.groups, 0.0);
  c.balls_used_before = c.balls_used;
  for (std::size_t place = 0; place < c.groups.size(); ++place) {
    layout_.packs[idx(pack_of_[idx(c.groups[place])])].ball_used = std::span(c.balls_used).subspan(place, 1);
  }
  for (std::size_t first = 0; first < c.groups.size(); first += w) {
    TogetherPack& to = c.steps[pack_number++ * c.steps.size() / packs]->packs().emplace_back();
    Pack& pack = to.pack;
    to.place = first;
    pack.group_class = structure_.groups[idx(c.groups[first])].group_class;
    pack.used = static_cast<std::int32_t>(std::min(w, c.groups.size() - first));
    pack.groups.assign(c.groups.begin() + static_cast<std::ptrdiff_t>(first),
                       c.groups.begin() + static_cast<std::ptrdiff_t>(first) + pack.used);
    const Pack& single = layout_.packs[idx(pack_of_[idx(pack.groups[0])])];
    pack.coefficients.resize(single.coefficients.size() * w);
    pack.anchor.resize(single.anchor.size() * w);
    pack.omega.resize(w);
    pack.ball_used = std::span(c.balls_used).subspan(first, w);
    const std::size_t n = idx(structure_.classes[idx(pack.group_class)].n), inputs = single.inputs.size();
    to.unknowns.addresses.resize(n * w);
    pack.inputs.resize(inputs * w);
    to.known.addresses.resize(inputs * w);
    for (std::size_t lane = 0; lane < w; ++lane) {
      const std::int32_t g = pack.groups[lane < pack.groups.size() ? lane : 0];
      const Pack& one = layout_.packs[idx(pack_of_[idx(g)])];
      for (std::size_t i = 0; i < one.coefficients.size(); ++i) pack.coefficients[i * w + lane] = one.coefficients[i];
      for (std::size_t i = 0; i < n; ++i) {
        to.unknowns.addresses[i * w + lane] = static_cast<std::int32_t>(one.unknowns + i);
      }
      for (std::size_t i = 0; i < inputs; ++i) {
        const bool computed = sources_[idx(structure_.groups[idx(g)].inputs[i])].of_class >= 0;
        pack.inputs[i * w + lane] = one.inputs[i];
        to.known.addresses[i * w + lane] = computed ? 0 : one.inputs[i];  // the coordinate `one` has no rates
        to.driven = to.driven || (!computed && structure_.classes[idx(pack.group_class)].input_moves[i] != 0);
      }
    }
    to.unknowns.rows = address_rows(to.unknowns.addresses, w);
    pack.input_rows = address_rows(pack.inputs, w);
    to.known.rows = address_rows(to.known.addresses, w);
  }
}

// Entries of a row that read the same group in every lane become one part.
void Together::find_parts(Class& c) {
  const std::span<TogetherStep::Entry> entries = c.step().entries();
  std::vector<std::int32_t> columns;
  std::vector<std::vector<Source>> of_parts;  // of the current row: the source of each group
  for (std::size_t e = 0; e < entries.size(); ++e) {
    if (e == 0 || entries[e].row != entries[e - 1].row) of_parts.clear();
    std::vector<Source> reads;
    for (const std::int32_t g : c.groups) reads.push_back(source(c, g, e));
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
  std::stable_sort(entries.begin(), entries.end(),
                   [](const auto& a, const auto& b) { return std::pair(a.row, a.part) < std::pair(b.row, b.part); });
  for (std::size_t e = 0; e < entries.size(); ++e) {
    const bool begins = e == 0 || entries[e].row != entries[e - 1].row || entries[e].part != entries[e - 1].part;
    if (begins) columns.push_back(0);
    for (const std::int32_t g : c.groups) {
      if (const Source s = source(c, g, e); s.of_class >= 0) {
        columns.back() = std::max(columns.back(), classes_[idx(s.of_class)].step().rows());
      }
    }
  }
  const std::size_t w = idx(c.lanes);
  c.places.gains = coupling_.gains.size();
  for (const auto& step : c.steps) {
    std::copy(entries.begin(), entries.end(), step->entries().begin());
    for (TogetherPack& pack : step->packs()) {
      for (std::size_t e = 0; e < entries.size(); ++e) {
        for (std::size_t lane = 0; lane < w; ++lane) {
          const std::size_t l = lane < pack.pack.groups.size() ? lane : 0;
          pack.sources.addresses.push_back(address(source(c, pack.pack.groups[l], e)));
        }
      }
      pack.sources.rows = address_rows(pack.sources.addresses, w);
    }
    step->place(c.places, columns);
  }
  coupling_.gains.resize(coupling_.gains.size() + c.step().gains().size() * c.places.groups);
}

void Together::make_rows() {
  std::vector<std::size_t> next(classes_.size(), 0);  // place of the next group of each class
  for (const Group& group : structure_.groups) {
    const Class& c = classes_[idx(group.group_class)];
    const std::size_t place = next[idx(group.group_class)]++;
    const std::span<const TogetherStep::Gain> gains = c.step().gains();
    for (std::int32_t k = 0; k < c.step().rows(); ++k) {
      Row row{static_cast<std::int32_t>(c.places.loads + idx(k) * c.places.groups + place),
              static_cast<std::int32_t>(links_.size()), 0};
      for (std::size_t j = 0; j < gains.size(); ++j) {
        if (gains[j].row != k) continue;
        Source from;
        for (std::int32_t e = gains[j].begin; e < gains[j].end && from.of_class < 0; ++e) {
          from = source(c, c.groups[place], idx(e));
        }
        if (from.of_class < 0 || gains[j].of >= classes_[idx(from.of_class)].step().rows()) continue;
        const TogetherStep::Places& of = classes_[idx(from.of_class)].places;
        links_.push_back({static_cast<std::int32_t>(c.places.gains + j * c.places.groups + place),
                          static_cast<std::int32_t>(of.loads + idx(gains[j].of) * of.groups + idx(from.place))});
      }
      row.end = static_cast<std::int32_t>(links_.size());
      add_row(row);
    }
  }
  for (const Class& c : classes_) {
    const std::size_t w = idx(c.lanes), last = c.places.groups - w;
    for (std::int32_t k = 0; k < c.step().rows(); ++k) {
      const std::size_t row = c.places.loads + idx(k) * c.places.groups;
      for (std::size_t place = c.groups.size(); place < c.places.groups; ++place) {
        idle_.push_back({static_cast<std::int32_t>(row + place), static_cast<std::int32_t>(row + last)});
      }
    }
  }
}

// Adds a row, or prolongs the chain of the last one.
void Together::add_row(const Row& row) {
  if (!rows_.empty() && row.end - row.begin == 1) {
    Row& before = rows_.back();
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
  if (!up_to_date_) take(state[0]);
  std::copy_n(state[0] + layout_.first_unknown, prediction_.size(), prediction_.begin());
  TogetherFigures figures{std::max(errors.position, 0.0), std::max(errors.velocity, 0.0),
                          std::max(errors.acceleration, 0.0)};
  int iterations = 0;
  Counters more;
  bool solved = converge(state, attempt, iterations, figures);
  if (solved) {
    derive(state, figures);
    solved = std::isfinite(figures.position + figures.velocity + figures.acceleration) &&
             keep_on_branch(state, attempt, more);
  }
  if (!solved) {
    undo(attempt.number);
    for (Pack& pack : layout_.packs) pack.undo(attempt.number);
    std::copy(prediction_.begin(), prediction_.end(), state[0] + layout_.first_unknown);
    forget();
    return false;
  }
  counters += more;
  count(iterations, counters);
  if (figures.position > std::max({errors.position, kConverged, attempt.converged})) {
    figures.position = std::max(errors.position, 0.0);
    for (Class& c : classes_) {
      for (const std::int32_t g : c.groups) {
        figures.position =
            std::max(figures.position, c.solver->residual_of(layout_.packs[idx(pack_of_[idx(g)])], state[0]));
      }
    }
  }
  errors.position = std::max(errors.position, figures.position);
  if (derivatives_ > 0) errors.velocity = std::max(errors.velocity, figures.velocity);
  if (derivatives_ > 1) errors.acceleration = std::max(errors.acceleration, figures.acceleration);
  return true;
}

// Each thread calls the works, one after the other, for its packs of every class; all threads meet between two works.
template <class... Works>
void Together::pass(const Works&... works) {
  const auto part = [&](int rank) {
    bool first = true;
    const auto one = [&](const auto& work) {
      if (!std::exchange(first, false) && team_ != nullptr) team_->barrier();
      for (Class& c : classes_) work(*c.steps[idx(rank)], shares_[idx(rank)]);
    };
    (one(works), ...);
  };
  if (team_ != nullptr) {
    team_->run(part);
  } else {
    part(0);
  }
}

bool Together::converge(double* const (&state)[3], const Attempt& attempt, int& iterations, TogetherFigures& figures) {
  using Progress = TogetherStep::Progress;
  const double before = figures.position;
  for (;; ++iterations) {
    for (Share& share : shares_) share = {{before, 0, 0}, Progress::solved};
    pass([&](TogetherStep& step, Share& share) {
      if (share.progress == Progress::failed) return;
      share.progress =
          std::min(share.progress, step.linearise(state[0], iterations, attempt.converged, coupling_, share.figures));
    });
    Progress progress = Progress::solved;
    for (const Share& share : shares_) progress = std::min(progress, share.progress);
    if (progress == Progress::failed) return false;
    if (progress == Progress::solved) {
      for (const Share& share : shares_) raise(figures.position, share.figures.position);
      return true;
    }
    if (iterations == attempt.most_iterations) return false;
    pass([&](TogetherStep& step, Share&) { step.couple(coupling_, true); });
    complete_loads();
    pass([&](TogetherStep& step, Share&) { step.correct(state[0], coupling_); });
  }
}

void Together::derive(double* const (&state)[3], TogetherFigures& figures) {
  if (derivatives_ < 1) return;
  for (Share& share : shares_) share.figures = figures;
  const auto finite = [&] {
    for (const Share& share : shares_) {
      raise(figures.velocity, share.figures.velocity);
      raise(figures.acceleration, share.figures.acceleration);
    }
    return std::isfinite(figures.velocity + figures.acceleration);
  };
  pass([&](TogetherStep& step, Share&) { step.own_rates(state, coupling_); },
       [&](TogetherStep& step, Share&) { step.couple(coupling_, true); });
  complete_loads();
  pass([&](TogetherStep& step, Share&) { step.finish_rates(state, coupling_); },
       [&](TogetherStep& step, Share& share) { step.own_accelerations(state, coupling_, share.figures); });
  if (!finite() || derivatives_ < 2) return;
  pass([&](TogetherStep& step, Share&) { step.couple(coupling_, false); });
  complete_loads();
  pass([&](TogetherStep& step, Share&) { step.finish_accelerations(state, coupling_); },
       [&](TogetherStep& step, Share& share) { step.measure_accelerations(coupling_, share.figures); });
  (void)finite();
}

// The recurrence through the levels.
void Together::complete_loads() {
  double* const loads = coupling_.loads.data();
  const double* const gains = coupling_.gains.data();
  for (const Row& row : rows_) {
    if (row.end - row.begin == 1) {
      const Link& link = links_[idx(row.begin)];
      chain_(gains + link.gain, loads[link.load], row.chain, loads + row.at);
      continue;
    }
    double sum = loads[row.at];
    for (std::int32_t l = row.begin; l < row.end; ++l) sum += gains[links_[idx(l)].gain] * loads[links_[idx(l)].load];
    loads[row.at] = sum;
  }
  for (const Copy& copy : idle_) loads[copy.to] = loads[copy.from];
}

bool Together::keep_on_branch(double* const (&state)[3], const Attempt& attempt, Counters& counters) {
  balls_of_ = attempt.number;
  for (Class& c : classes_) c.balls_used_before = c.balls_used;
  for (Class& c : classes_) {
    const std::size_t w = idx(c.lanes);
    for (const auto& step : c.steps) {
      for (std::size_t p = 0; p < step->packs().size(); ++p) {
        TogetherPack& pack = step->packs()[p];
        const double* used = step->balls_used().data() + p * w;
        if (step->balls_last()[p] != 0) {
          std::copy_n(used, w, pack.pack.ball_used.begin());
          continue;
        }
        for (std::size_t lane = 0; lane < idx(pack.pack.used); ++lane) {
          if (BranchGuard::stays_inside(used[lane], pack.pack.ball_used[lane])) continue;
          Pack& single = layout_.packs[idx(pack_of_[idx(pack.pack.groups[lane])])];
          if (!c.solver->renew_anchor(single, state, attempt, counters).ok()) return false;
          take_lane(pack, lane, w);
          for (std::size_t idle = idx(pack.pack.used); lane == 0 && idle < w; ++idle) take_lane(pack, idle, w);
        }
        for (std::size_t idle = idx(pack.pack.used); idle < w; ++idle) {
          pack.pack.ball_used[idle] = pack.pack.ball_used[0];
        }
      }
    }
  }
  return true;
}

void Together::undo(std::int64_t attempt) {
  if (balls_of_ != attempt) return;
  balls_of_ = 0;
  for (Class& c : classes_) std::copy(c.balls_used_before.begin(), c.balls_used_before.end(), c.balls_used.begin());
}

void Together::count(int iterations, Counters& counters) const {
  for (const Class& c : classes_) {
    const auto groups = static_cast<std::int64_t>(c.groups.size());
    const std::int64_t unknowns = groups * c.solver->program().n;
    const std::int64_t right_sides = iterations + c.derivatives + (iterations + 1) * c.step().rows();
    counters.group_solutions += groups;
    counters.newton_iterations += groups * iterations;
    counters.evaluated_equations += unknowns * (iterations + 1);
    counters.factorizations += groups * (iterations + 1);
    counters.factorized_unknowns += unknowns * (iterations + 1);
    counters.solved_unknowns += unknowns * right_sides;
  }
  counters.most_iterations = std::max<std::int64_t>(counters.most_iterations, iterations);
}

// Copies the guards of all packs of the layout.
void Together::take(const double* state) {
  for (Class& c : classes_) {
    const std::size_t w = idx(c.lanes);
    for (const auto& step : c.steps) {
      for (TogetherPack& to : step->packs()) {
        to.pack.swaps.resize(layout_.packs[idx(pack_of_[idx(to.pack.groups[0])])].swaps.size() * w);
        for (std::size_t lane = 0; lane < w; ++lane) take_lane(to, lane, w);
      }
      step->begin(state);
    }
  }
  up_to_date_ = true;
}

// Idle lanes repeat the first lane of their pack.
void Together::take_lane(TogetherPack& to, std::size_t lane, std::size_t lanes) {
  const Pack& from = layout_.packs[idx(pack_of_[idx(to.pack.groups[lane < to.pack.groups.size() ? lane : 0])])];
  for (std::size_t i = 0; i < from.swaps.size(); ++i) to.pack.swaps[i * lanes + lane] = from.swaps[i];
  for (std::size_t i = 0; i < from.anchor.size(); ++i) to.pack.anchor[i * lanes + lane] = from.anchor[i];
  to.pack.omega[lane] = from.omega[0];
}

}  // namespace assur
