#include "runs/tile.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "equations/residual_scale.hpp"
#include "index.hpp"
#include "numbers.hpp"
#include "program/step_rules.hpp"

namespace assur {
namespace {

// False if a solver still has the pivots with which it began.
bool has_worked(const Effort& e) { return e.redone + e.renewed + e.refined + e.unplanned + e.in_double > 0; }

// Status of a pack, whose groups are the lanes.
Status in_lane(const Status& of_group) {
  return of_group.ok() ? of_group : Status{of_group.code, Place::lane(of_group.where.index), of_group.figure};
}

}  // namespace

Tile::Tile(const Preparation& prepared, const StepSettings& settings)
    : structure_(prepared.structure),
      settings_(settings),
      lanes_(prepared.plan.lanes),
      code_(prepared.code),
      layout_(lay_out_side_by_side(prepared, lanes_)),
      together_(angles_together(*structure_->system, *structure_)),
      columns_(column_names(*structure_->system)),
      outputs_(idx(lanes_), OutputProgram(*structure_->system, layout_.address)),
      output_steps_(outputs_, prepared.code),
      rows_(columns_.size() * idx(lanes_)),
      divisors_(outputs_[0].measures() * idx(lanes_)),
      turns_(outputs_),
      estimate_(*structure_, layout_, outputs_, prepared.plan.accuracy) {
  state_.resize(layout_.first_unknown, layout_.size, prepared.plan.run.predictor);
  const System& system = *structure_->system;
  limit_events_.resize(idx(lanes_));
  conditions_.reserve(idx(lanes_));
  for (std::size_t lane = 0; lane < idx(lanes_); ++lane) {
    conditions_.emplace_back(*structure_, layout_, lane);
  }
  conditions_[0].bind(system, false);
  bow_times_.resize(idx(lanes_));
  turns_.use(output_steps_);
  estimate_.use(output_steps_);
  drive_.resize(idx(lanes_));
  bound_to_.resize(idx(lanes_));
  wanted_.resize(idx(lanes_));

  std::vector<std::uint8_t> read(layout_.size, 0), needed(system.coordinates.size(), 0);
  for (const Pack& pack : layout_.packs) {
    for (const std::int32_t a : pack.inputs) read[idx(a)] = 1;
  }
  outputs_[0].mark(read);
  conditions_[0].mark(read);
  for (std::size_t c = 0; c < needed.size(); ++c) {
    const auto own = static_cast<std::int32_t>(c) * lanes_;  // address, unless it is a copy
    needed[c] = layout_.address[c] == own ? read[idx(own)] : std::uint8_t{0};
  }
  driven_ = driven_behind(system, std::move(needed));
  for (const Index i : driven_.inputs) {
    const DriverInput& in = system.inputs[idx(i)];
    for (Index k = 0; k < in.count; ++k) driven_coordinates_.push_back(in.first + k);
  }
  while (at_rest_ < layout_.packs.size() && layout_.packs[at_rest_].unknowns < layout_.first_unknown) ++at_rest_;
  for (const Index i : driven_.assignments) driven_coordinates_.push_back(system.assignments[idx(i)].coordinate);
}

// When the variants are bound, to be called with their times.
void Tile::find_whole_step() {
  if (!code_) return;
  const bool alike = same_assignments_ && drives_at_once(now_);
  std::unique_ptr<WholeStep>& whole = alike ? alike_ : apart_;
  if (!std::exchange(alike ? tried_alike_ : tried_apart_, true)) {
    whole = WholeStep::make(layout_, alike ? &*drive_[0] : nullptr, state_, *code_, at_rest_, lanes_);
  }
  whole_ = whole.get();
  if (whole_ == nullptr) return;
  whole_->forget();
  whole_->take_drivers();
}

void Tile::keep_pivots(const Variant& of) {
  const Variant* const one = &of;
  if (!start({&one, 1}, false).ok()) return;
  for (Pack& pack : layout_.packs) {
    if (pack.solver) pack.pivots = pack.solver->clone();
  }
  clear_figures();
}

Status Tile::start(std::span<const Variant* const> variants, bool alike) {
  variants_.assign(variants.begin(), variants.end());
  bind(alike);
  state_.clear();
  begin_bows();
  const std::size_t w = idx(lanes_);
  for (std::size_t lane = 0; lane < w; ++lane) {
    const Variant& v = *variants_[lane < variants_.size() ? lane : 0];
    for (std::size_t c = 0; c < layout_.address.size(); ++c) {
      if (layout_.address[c] >= 0) state_.at(0)[idx(layout_.address[c]) + lane] = v.posture[c];
    }
  }
  now_.clear();
  for (const Variant* v : variants_) now_.push_back(v->time);
  find_whole_step();
  converged_ = kConverged;
  const std::vector<double> times = now_;
  const Status s = solve(times, Attempt::Branch::start);
  if (!s.ok()) return s;
  for (std::size_t lane = 0; lane < variants_.size(); ++lane) {
    conditions_[lane].begin({state_.at(0) + lane, state_.at(1) + lane, state_.at(2) + lane});
  }
  turns_.start(state_.at(0));
  accept(times);
  return begin_limits();
}

void Tile::begin_bows() {
  const auto bends = [](const std::optional<DriveProgram>& program) { return program && program->bends(); };
  const std::size_t laws = drive_[0]->laws();
  const bool any = std::any_of(drive_.begin(), drive_.begin() + static_cast<std::ptrdiff_t>(variants_.size()), bends);
  may_bend_ = may_bend_ || any;
  if (any && known_[0].empty()) {
    bows_.resize(layout_, laws, idx(lanes_));
    for (LaneArray& v : known_) v.assign(layout_.size, 0.0);
  }
  for (MotionConditions& m : conditions_) m.clear();
  bows_.clear();
  bends_ = false;
  const std::vector<double> none(laws, 0.0);
  for (std::size_t lane = 0; lane < idx(lanes_); ++lane) {
    if (drive_[lane]) drive_[lane]->forget_bows();
    bows_.take(none, lane);
  }
}

void Tile::bind(bool alike) {
  effort_ = effort();
  for (const auto& s : layout_.solvers) s->restart(alike);
  for (std::size_t g = 0; g < layout_.packs.size(); ++g) {
    Pack& pack = layout_.packs[g];
    if (!pack.pivots || !pack.solver || has_worked(pack.solver->effort())) pack.solver.reset();
    pack.factored = false;
    pack.used = static_cast<std::int32_t>(variants_.size());
    layout_.solvers[idx(pack.group_class)]->bind(pack, [&](std::size_t lane) {
      return std::tie(*variants_[lane < variants_.size() ? lane : 0]->system, structure_->groups[g]);
    });
  }
  auto news = OutputSteps::News::none;
  for (std::size_t lane = 0; lane < variants_.size(); ++lane) {
    news = std::max(news, bind_programs(lane));
    conditions_[lane].bind(*variants_[lane]->system, variants_[lane]->reselect != nullptr);
    conditions_[lane].check_inputs(driven_.inputs);
  }
  output_steps_.bind(variants_.size(), news);
  std::vector<const System*> systems;
  for (const Variant* v : variants_) systems.push_back(v->system.get());
  estimate_.restart(systems, driven_.inputs);
  same_laws_ = same_laws();
  same_assignments_ = same_laws_ && same_assignments();
}

// Returns what is new in the outputs.
OutputSteps::News Tile::bind_programs(std::size_t lane) {
  const Variant& v = *variants_[lane];
  const bool is_known = v.changes && bound_to_[lane] == v.system.get();
  bound_to_[lane] = v.system.get();
  using News = OutputSteps::News;
  News news = !is_known ? News::all : v.changes->outputs ? News::numbers : News::none;
  if (!is_known) wanted_[lane] = wanted_outputs(*v.system);
  if (news == News::all || (news == News::numbers && !outputs_[lane].renew(*v.system))) {
    outputs_[lane].bind(*v.system, layout_.address, wanted_[lane]);
    news = News::all;
  }
  if (!is_known || v.changes->laws ||
      (v.changes->assignments && !drive_[lane]->renew_assignments(*v.system, driven_))) {
    drive_[lane].emplace(*v.system, driven_);
  }
  return news;
}

// True if the drivers of all lanes have the same laws: then one evaluation serves all lanes at the same time.
bool Tile::same_laws() const {
  const System& first = *variants_[0]->system;
  return std::all_of(variants_.begin(), variants_.end(), [&](const Variant* v) {
    const System& s = *v->system;
    return &s == &first || (s.length_exponent == first.length_exponent &&
                            std::all_of(driven_.inputs.begin(), driven_.inputs.end(),
                                        [&](Index i) { return s.inputs[idx(i)].laws == first.inputs[idx(i)].laws; }));
  });
}

// True if coordinates that depend on the drivers do so in the same way in all lanes.
bool Tile::same_assignments() const {
  const System& first = *variants_[0]->system;
  return std::all_of(variants_.begin(), variants_.end(), [&](const Variant* v) {
    const System& s = *v->system;
    return &s == &first || std::all_of(driven_.assignments.begin(), driven_.assignments.end(), [&](Index i) {
      const auto terms = s.form(s.assignments[idx(i)].form), others = first.form(first.assignments[idx(i)].form);
      return std::equal(terms.begin(), terms.end(), others.begin(), others.end(), [&](const Term& a, const Term& b) {
        return a.coordinate == b.coordinate && s.constants[idx(a.constant)] == first.constants[idx(b.constant)] &&
               s.coordinates[idx(a.coordinate)].moving;
      });
    });
  });
}

// True if the laws have the same values in all lanes.
bool Tile::drives_at_once(std::span<const double> times) const {
  return same_laws_ && std::all_of(times.begin(), times.end(), [&](double t) { return t == times[0]; });
}

Status Tile::drive(std::span<const double> times) {
  const bool at_once = drives_at_once(times);
  const std::size_t w = idx(lanes_), driven = driven_lanes_ = at_once ? 1 : times.size();
  for (std::size_t lane = 0; lane < driven; ++lane) {
    if (const Status s = drive_lane(lane, times[lane]); !s.ok()) return s;
  }
  for (int d = 0; d < 3 && driven < w; ++d) {  // idle lanes repeat lane 0
    for (const Index c : driven_coordinates_) {
      double* const row = state_.at(d) + idx(c) * w;
      std::fill(row + driven, row + w, row[0]);
    }
  }
  for (std::size_t lane = 1; lane < times.size() && at_once && !same_assignments_; ++lane) {
    drive_[lane]->place_as(*drive_[0], {state_.at(0) + lane, state_.at(1) + lane, state_.at(2) + lane}, w);
  }
  return {};
}

Status Tile::drive_lane(std::size_t lane, double time) {
  double* const q[3] = {state_.at(0) + lane, state_.at(1) + lane, state_.at(2) + lane};
  DriveProgram& program = *drive_[lane];
  program.evaluate(time);
  program.place(q, idx(lanes_));
  const Place where = Place::lane(static_cast<std::int32_t>(lane));
  if (!program.defined()) return {DriveProgram::why_undefined(*variants_[lane]->system, time), where, time};
  return {};
}

Status Tile::step(std::span<const double> times) {
  bows_.begin_step();
  predict(times);
  Status s = solve(times, Attempt::Branch::inside);
  if (s.ok() && conditions_[0].limits() != nullptr) s = check_limits(times);
  if (!s.ok()) {
    state_.restore();
    return s;
  }
  accept(times);
  counters_.steps += static_cast<std::int64_t>(variants_.size());
  return s;
}

// The code of a whole step predicts for itself.
void Tile::predict(std::span<const double> times) {
  state_.begin_prediction(times[0], prediction_);
  const bool is_whole = whole_ != nullptr && (whole_ == apart_.get() || drives_at_once(times));
  is_predicted_ = !is_whole || settings_.iterations > 0 || times[0] == now_[0];
  if (is_predicted_) combine();
}

// One attempt. A rejected attempt does not change the packs.
Status Tile::solve(std::span<const double> times, Attempt::Branch branch) {
  ++attempts_;
  StepErrors errors;
  const Status s = solve_all(times, branch, errors);
  if (!s.ok()) {
    for (Pack& pack : layout_.packs) pack.undo(attempts_);
    return s;
  }
  left_ = errors.worst();
  errors.add_to(error_);
  return s;
}

Status Tile::solve_all(std::span<const double> times, Attempt::Branch branch, StepErrors& errors) {
  bool whole = !std::exchange(is_predicted_, true);
  const bool drives = whole && whole_ == alike_.get();
  if (drives) {
    drive_[0]->evaluate(times[0]);
    driven_lanes_ = 1;
  } else if (const Status s = drive(times); !s.ok()) {
    return s;
  }
  const bool inside = branch == Attempt::Branch::inside;
  if (inside) {
    if (const Status s = check_bows(times); !s.ok()) return s;
  }
  double* const q[3] = {state_.at(0), state_.at(1), state_.at(2)};
  const double converged = inside ? converged_ : kConverged;
  const Attempt attempt = usual_attempt(times[0], branch, converged);
  if (whole && !whole_->run(q, prediction_, attempt)) {
    whole = false;
    combine();
    if (drives) {
      if (const Status s = drive(times); !s.ok()) return s;
    }
  }
  const auto seconds = [&](std::size_t lane) { return inside ? times[lane] - now_[lane] : 0; };
  for (std::size_t lane = 0; lane < driven_lanes_; ++lane) {
    if (const Status s = check_levers(MotionConditions::Levers::known, lane, seconds(lane)); !s.ok()) return s;
  }
  std::size_t failed = 0;
  const Status solved = whole ? in_lane(whole_->finish(q, attempt, counters_, errors, failed))
                              : solve_packs(times, branch, converged, errors);
  if (!solved.ok()) return solved;
  for (std::size_t lane = 0; lane < variants_.size(); ++lane) {
    if (const Status s = check_levers(MotionConditions::Levers::unknown, lane, seconds(lane)); !s.ok()) return s;
  }
  if (const Status s = check_redundant(times, branch, errors); !s.ok()) return s;
  if (const Status s = check_sets(); !s.ok()) return s;
  return inside ? follow_angles(times[0] - now_[0]) : Status{};
}

// A lane fails whose drivers turn, or may bend between its postures, by more than a step may.
Status Tile::check_bows(std::span<const double> times) {
  bool is_new = false;
  for (std::size_t lane = 0; lane < driven_lanes_ && may_bend_; ++lane) {
    is_new = drive_[lane]->renew_bows(now_[lane], times[lane]) || is_new;
  }
  if (is_new) bends_ = false;
  for (std::size_t lane = 0; lane < variants_.size() && is_new; ++lane) {
    bends_ = bows_.take(drive_[lane < driven_lanes_ ? lane : 0]->bows(), lane) || bends_;
  }
  for (std::size_t lane = 0; lane < driven_lanes_; ++lane) {
    const DriveProgram& before = *drive_[lane < lanes_accepted_ ? lane : 0];
    const double part = drive_[lane]->turned(before.accepted_angles(), together_, structure_->system->teeth);
    if (part > 1) return {Code::branch_unknown, Place::lane(static_cast<std::int32_t>(lane)), part};
  }
  if (!bends_) return {};
  if (!bows_.serve(counters_.branch_checks)) measure_bows(times);
  for (std::size_t lane = 0; lane < variants_.size(); ++lane) {
    const double part = bows_.part(lane);
    if (part > 1) return {Code::branch_unknown, Place::lane(static_cast<std::int32_t>(lane)), part};
  }
  return {};
}

// Leaves the known coordinates at `times`.
void Tile::measure_bows(std::span<const double> times) {
  const std::size_t w = idx(lanes_), known = layout_.first_unknown;
  const double* const q[3] = {state_.accepted(0), state_.accepted(1), state_.accepted(2)};
  std::copy_n(q[0], known, known_[0].begin());
  for (std::size_t lane = 0; lane < variants_.size(); ++lane) drive_[lane]->evaluate(now_[lane]);
  const auto lean = [&](std::size_t lane, double* probe, std::span<const double> rates) {
    if (lane >= variants_.size()) return;
    drive_[lane]->move(rates);
    drive_[lane]->place({known_[0].data() + lane, known_[1].data() + lane, known_[2].data() + lane}, w);
    for (const Index c : driven_coordinates_) {
      double* const row = probe + idx(c) * w;
      row[lane] = known_[1][idx(c) * w + lane];
      if (lane == 0) std::fill(row + variants_.size(), row + w, row[0]);  // idle lanes repeat lane 0
    }
  };
  bows_.measure(q[0], counters_.branch_checks, lean, [&](const auto& work) {
    for (std::size_t p = 0; p < layout_.packs.size(); ++p) work(p, *layout_.solvers[idx(layout_.packs[p].group_class)]);
  });
  for (Pack& pack : layout_.packs) pack.factored = false;
  for (std::size_t lane = 0; lane < variants_.size(); ++lane) {
    conditions_[lane].measure({q[0] + lane, q[1] + lane, q[2] + lane}, bows_, known_[0]);
  }
  turns_.measure(q[0], bows_.probes(), known_[0]);
  (void)drive(times);
}

bool Tile::polish() {
  if (settings_.iterations > 0 || converged_ == estimate_.best()) return false;
  converged_ = estimate_.best();
  state_.restore();
  if (!solve(now_, Attempt::Branch::inside).ok()) {
    state_.restore();
    return false;
  }
  state_.replace();
  if (at_rest_ > 0) state_.spread_known();
  for (MotionConditions& m : conditions()) m.accept(0, true);
  turns_.accept(0);
  has_outputs_ = false;
  return true;
}

// time: of the first lane; steps have the same length in every lane
Attempt Tile::usual_attempt(double time, Attempt::Branch branch, double converged) const {
  Attempt usual;
  usual.branch = branch;
  usual.converged = converged;
  if (error_.position > 0) usual.known_residual = error_.position;
  usual.number = attempts_;
  usual.time = time;
  usual.most_iterations = settings_.most_iterations;
  usual.makes_code = true;
  return usual;
}

Status Tile::solve_packs(std::span<const double> times, Attempt::Branch branch, double converged, StepErrors& errors) {
  double* const q[3] = {state_.at(0), state_.at(1), state_.at(2)};
  const bool moves = times[0] != now_[0];
  Attempt attempt = usual_attempt(times[0], branch, converged);
  for (Pack& pack : std::span(layout_.packs).subspan(moves ? at_rest_ : 0)) {
    attempt.iterations = pack.level > 0 && branch == Attempt::Branch::inside ? settings_.iterations : 0;
    GroupSolver& solver = *layout_.solvers[idx(pack.group_class)];
    if (const Status s = solver.solve(pack, q, attempt, counters_, errors); !s.ok()) return in_lane(s);
  }
  return {};
}

bool Tile::errors_are_due() {
  const double* const q[3] = {state_.at(0), state_.at(1), state_.at(2)};
  evaluate_outputs();
  return estimate_.due(counters_.branch_checks, now_, q, left_, divisors_.data());
}

void Tile::measure_errors(std::span<const double> times, std::span<const double* const> rows) {
  const double* const q[3] = {state_.at(0), state_.at(1), state_.at(2)};
  const bool redundant = !structure_->watch_class.equations.empty();
  for (std::size_t lane = 0; lane < variants_.size() && redundant; ++lane) {
    estimate_.contradict(lane, conditions_[lane].contradiction(state_.at(0) + lane));
  }
  estimate_.measure(times, q, rows, divisors_.data(), [&](const auto& work) {
    for (std::size_t p = 0; p < layout_.packs.size(); ++p) work(p, *layout_.solvers[idx(layout_.packs[p].group_class)]);
  });
}

void Tile::keep_errors() {
  estimate_.keep();
  if (!estimate_.close_to_doubt()) converged_ = kConverged;
}

Status Tile::accuracy(int lane) const {
  if (!estimate_.in_doubt(idx(lane))) return {};
  const auto group = static_cast<std::int32_t>(estimate_.worst_of(idx(lane)).pack);
  return {Code::inaccurate, layout_.packs.empty() ? Place{} : Place::group(group), estimate_.now(idx(lane)).worst()};
}

Status Tile::check_levers(MotionConditions::Levers which, std::size_t lane, double seconds) const {
  if (!conditions_[lane].has(which)) return {};
  Status s = conditions_[lane].check_levers(
      which, {state_.accepted(0) + lane, state_.accepted(1) + lane, state_.accepted(2) + lane},
      {state_.at(0) + lane, state_.at(1) + lane, state_.at(2) + lane}, seconds, bows_.times(lane));
  if (!s.ok()) s.where = Place::lane(static_cast<std::int32_t>(lane));
  return s;
}

Status Tile::check_redundant(std::span<const double> times, Attempt::Branch branch, StepErrors& errors) {
  if (structure_->watch_class.equations.empty()) return {};
  std::size_t worst = 0;
  bool is_solved = true;
  Status s = check_watched(
      conditions(), state_.at(0), branch == Attempt::Branch::inside ? converged_ : kConverged,
      settings_.iterations == 0,
      [&] {
        const Status corrected = solve_packs(times, branch, 0, errors);
        is_solved = corrected.ok();
        return corrected;
      },
      counters_, errors, worst);
  if (!s.ok() && is_solved) s.where = Place::lane(static_cast<std::int32_t>(worst));
  return s;
}

// A lane must go on alone if another set of the redundant equations would be better.
Status Tile::check_sets() {
  if (structure_->watch_class.equations.empty()) return {};
  for (std::size_t lane = 0; lane < variants_.size(); ++lane) {
    const double largest = conditions_[lane].largest_coefficient(state_.at(0) + lane, counters_.branch_checks);
    if (!(largest <= 2 * kPoorSet)) return {Code::singular, Place::lane(static_cast<std::int32_t>(lane)), largest};
  }
  return {};
}

// Not ok if an angle of some lane turned so far that its sense of rotation is unknown.
Status Tile::follow_angles(double seconds) {
  const auto turned_unseen = [&](std::size_t lane) {
    return Status{Code::branch_unknown, Place::lane(static_cast<std::int32_t>(lane)), seconds};
  };
  if (!turns_.empty()) {
    for (std::size_t lane = 0; lane < variants_.size(); ++lane) bow_times_[lane] = bows_.times(lane);
    const AngleTurns::Followed found = turns_.follow(state_.at(0), seconds, bow_times_, variants_.size());
    if (found.turned != AngleTurns::Turned::known) return turned_unseen(found.lane);
  }
  for (std::size_t lane = 0; lane < variants_.size() && conditions_[lane].is_followed(); ++lane) {
    const AngleTurns::Turned turned = conditions_[lane].follow_angles(state_.at(0) + lane, seconds, bows_.times(lane));
    if (turned != AngleTurns::Turned::known) return turned_unseen(lane);
  }
  return {};
}

void Tile::accept(std::span<const double> times) {
  state_.accept(times[0]);
  lanes_accepted_ = driven_lanes_;
  for (std::size_t lane = 0; lane < driven_lanes_; ++lane) drive_[lane]->accept();
  for (MotionConditions& m : conditions()) m.accept(times[0] - now_[0]);
  turns_.accept(times[0] - now_[0]);
  has_outputs_ = false;
  now_.assign(times.begin(), times.end());
}

// Not ok if a variant begins outside a limit that ends motions.
Status Tile::begin_limits() {
  for (std::size_t lane = 0; lane < variants_.size(); ++lane) {
    limit_events_[lane].clear();
    for (const LimitWatch::Change& outside : conditions_[lane].begin_limits(
             {state_.at(0) + lane, state_.at(1) + lane, state_.at(2) + lane}, now_[lane], variants_[lane]->limited)) {
      const LimitWatch& limits = *conditions_[lane].limits();
      if (limits.ends(outside)) return {Code::limit_reached, Place::lane(static_cast<std::int32_t>(lane)), 0};
      limit_events_[lane].push_back(limits.event(outside));
    }
  }
  return {};
}

// A lane whose motion ends, or whose limits the ends of the step do not show, must go on alone.
Status Tile::check_limits(std::span<const double> times) {
  const auto may_change = [&](std::size_t lane) {
    return conditions_[lane].limits()->may_change({state_.at(0) + lane, state_.at(1) + lane, state_.at(2) + lane},
                                                  times[lane]);
  };
  std::vector<std::size_t> lanes;
  for (std::size_t lane = 0; lane < variants_.size(); ++lane) {
    if (may_change(lane)) lanes.push_back(lane);
    if (conditions_[lane].limits()->hides_change(bows_.times(lane))) {
      for (Pack& pack : layout_.packs) pack.undo(attempts_);
      return {Code::branch_unknown, Place::lane(static_cast<std::int32_t>(lane)), 0};
    }
  }
  if (lanes.empty()) return {};
  const auto undo = [&] {
    for (Pack& pack : layout_.packs) pack.undo(attempts_);
  };
  undo();
  std::vector<double> probe(times.size());
  std::vector<std::vector<Event>> found(variants_.size());
  for (const std::size_t lane : lanes) {
    const auto changes = conditions_[lane].limits()->changes([&](double t) -> const double* {
      for (std::size_t i = 0; i < probe.size(); ++i) probe[i] = i == lane ? t : now_[i] + (t - now_[lane]);
      state_.predict(probe[0]);
      ++attempts_;
      StepErrors ignored;
      const Status s = solve_all(probe, Attempt::Branch::anywhere, ignored);
      undo();
      return s.ok() ? state_.at(0) + lane : nullptr;
    });
    for (const LimitWatch::Change& c : changes) {
      if (conditions_[lane].limits()->ends(c))
        return {Code::limit_reached, Place::lane(static_cast<std::int32_t>(lane)), 0};
      found[lane].push_back(conditions_[lane].limits()->event(c));
    }
  }
  state_.predict(times[0]);
  if (const Status s = solve(times, Attempt::Branch::inside); !s.ok()) return s;
  for (std::size_t lane = 0; lane < variants_.size(); ++lane) {
    (void)may_change(lane);
    limit_events_[lane].insert(limit_events_[lane].end(), found[lane].begin(), found[lane].end());
  }
  return {};
}

void Tile::take_events(int lane, std::vector<Event>& to) {
  std::vector<Event>& events = limit_events_[idx(lane)];
  to.insert(to.end(), events.begin(), events.end());
  events.clear();
}

void Tile::evaluate_outputs() {
  if (has_outputs_) return;
  output_steps_.evaluate({state_.at(0), state_.at(1), state_.at(2)}, rows_.data(), turns_.turns(), divisors_.data());
  has_outputs_ = true;
}

void Tile::fill_row(int lane, double* row) {
  evaluate_outputs();
  for (std::size_t c = 0; c < columns_.size(); ++c) row[c] = rows_[c * idx(lanes_) + idx(lane)];
  outputs_[idx(lane)].add_up(row);
}

std::vector<double> Tile::posture(int lane) const {
  std::vector<double> all = variants_[idx(lane)]->posture;
  for (std::size_t c = 0; c < all.size(); ++c) {
    if (layout_.address[c] >= 0) all[c] = state_.at(0)[layout_.address[c] + lane];
  }
  return all;
}

void Tile::clear_figures() {
  counters_ = {};
  error_ = {};
  effort_ = {};
  estimate_.restart({}, {});
  for (Pack& pack : layout_.packs) pack.solver.reset();
  for (const auto& s : layout_.solvers) s->restart();
}

std::vector<double> Tile::uniqueness(int lane) const {
  std::vector<double> radius(layout_.address.size(), kInfinity);
  for (std::size_t g = 0; g < layout_.packs.size(); ++g) {
    const Pack& pack = layout_.packs[g];
    const GroupClass& c = layout_.solvers[idx(pack.group_class)]->group_class();
    for (std::size_t i = 0; i < idx(c.n); ++i) {
      const double omega = pack.omega[idx(c.unknown_block[i]) * idx(lanes_) + idx(lane)];
      radius[idx(structure_->groups[g].unknowns[i])] = c.quadratic() ? kBall / omega : 0;
    }
  }
  return radius;
}

Effort Tile::effort() const {
  Effort sum = effort_;
  for (const auto& s : layout_.solvers) sum += s->effort();
  for (const Pack& pack : layout_.packs) {
    if (pack.solver) sum += pack.solver->effort();
  }
  return sum;
}

}  // namespace assur
