#include "drivers/drive_program.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "equations/drive.hpp"
#include "equations/law_bow.hpp"
#include "equations/own_values.hpp"
#include "index.hpp"
#include "overloaded.hpp"

namespace assur {
namespace {

// Place of the call of a function between both ends of a step, as a part of the step: no simple fraction, because laws
// that repeat with the rows are the ones to see.
constexpr double kBetween = 0.381966;

// Longer tables are not copied for machine code.
constexpr std::size_t kMostPoints = 100'000;

}  // namespace

DriveProgram::DriveProgram(const System& system, const Driven& driven) {
  for (const DriverInput& in : system.inputs) {
    first_slot_.push_back(static_cast<std::int32_t>(slot_.size()));
    slot_.resize(slot_.size() + in.laws.size(), -1);
  }
  add_slots(system, driven, true);
  angles_ = scale_.size();
  add_slots(system, driven, false);
  laws_ = scale_.size();
  const std::size_t padded = (laws_ + kAngleBlock - 1) / kAngleBlock * kAngleBlock;
  for (std::vector<double>* v : {&base_, &jets_[0], &jets_[1], &jets_[2], &sines_, &cosines_}) v->resize(padded);
  held_.resize(laws_);
  bend_.resize(laws_);
  bows_.resize(laws_);
  accepted_angles_.resize(angles_);
  slot_of_.resize(system.coordinates.size(), -1);
  for (const Index input : driven.inputs) add_input(system, idx(input));
  for (const Index i : driven.assignments) add_assignment(system, system.assignments[idx(i)]);
}

void DriveProgram::add_slots(const System& system, const Driven& driven, bool angles) {
  for (const Index input : driven.inputs) {
    const DriverInput& in = system.inputs[idx(input)];
    for (std::size_t k = 0; k < in.laws.size(); ++k) {
      if (is_angle(system, in, k) != angles) continue;
      slot_[idx(first_slot_[idx(input)]) + k] = static_cast<std::int32_t>(scale_.size());
      scale_.push_back(angles ? 1 : 1 / system.unit(in.dimension));
    }
  }
}

void DriveProgram::add_input(const System& system, std::size_t input) {
  const DriverInput& in = system.inputs[input];
  for (std::size_t k = 0; k < in.laws.size(); ++k) add_law(slot(input, static_cast<int>(k)), in.laws[k]);
  if (in.kind == DriverInput::Kind::direction) {
    add_copies(add_turn(directions_, slot(input, 0), 2), in.first, 2);
    return;
  }
  const int straight = in.kind == DriverInput::Kind::scalar ? 1 : system.dimension;
  add_copies(slot(input, 0), in.first, straight);
  if (in.count == straight) return;
  const std::int32_t angle = slot(input, straight), results = in.count - straight;
  add_copies(add_turn(system.dimension == 2 ? directions_ : frames_, angle, results), in.first + straight, results);
}

std::int32_t DriveProgram::add_turn(std::vector<Turn>& turns, std::int32_t angle, std::int32_t results) {
  const auto result = static_cast<std::int32_t>(jets_[0].size());
  turns.push_back({angle, result});
  for (auto& jet : jets_) jet.resize(jet.size() + idx(results));
  return result;
}

void DriveProgram::add_copies(std::int32_t slot, Index coordinate, std::int32_t count) {
  for (std::int32_t k = 0; k < count; ++k) {
    copies_.push_back({slot + k, coordinate + k});
    slot_of_[idx(coordinate + k)] = slot + k;
  }
}

void DriveProgram::add_law(std::int32_t slot, const Law& law) {
  const double scale = scale_[idx(slot)];
  for (const Law::Part& part : law.parts()) {
    const auto* harmonics = std::get_if<Law::Harmonics>(&part);
    const auto reducible = [](const Harmonic& term) { return std::abs(term.phase) <= kLargestAngle; };
    if (harmonics != nullptr && std::all_of(harmonics->terms.begin(), harmonics->terms.end(), reducible)) {
      base_[idx(slot)] += harmonics->offset * scale;
      for (const Harmonic& term : harmonics->terms) add_term(slot, term);
    } else if (const auto* polynomial = std::get_if<Law::Polynomial>(&part)) {
      const auto begin = static_cast<std::int32_t>(coefficients_.size());
      for (const double c : polynomial->coefficients) coefficients_.push_back(c * scale);
      polynomials_.push_back({slot, begin, static_cast<std::int32_t>(coefficients_.size())});
    } else if (const auto* table = std::get_if<Law::Spline>(&part);
               table != nullptr && table->time.size() <= kMostPoints) {
      tables_.push_back({slot, table});
    } else {
      others_.push_back({slot, &part});
    }
    add_bend(slot, part);
  }
}

void DriveProgram::add_bend(std::int32_t slot, const Law::Part& part) {
  const double scale = scale_[idx(slot)];
  Bend& bend = bend_[idx(slot)];
  if (const auto* harmonics = std::get_if<Law::Harmonics>(&part)) {
    for (const Harmonic& term : harmonics->terms) {
      const double omega = law_detail::two_pi<double>() * term.frequency, amplitude = std::abs(term.amplitude) * scale;
      bend.acceleration += amplitude * omega * omega;
      if (omega != 0) bend.reach += 2 * amplitude;
    }
    return;
  }
  const auto* polynomial = std::get_if<Law::Polynomial>(&part);
  if (polynomial != nullptr && polynomial->coefficients.size() <= 3) {
    if (polynomial->coefficients.size() == 3) bend.steady += 2 * polynomial->coefficients[2] * scale;
  } else {
    evenly_ = false;
    if (polynomial != nullptr) uneven_.push_back({slot, &part});
  }
}

// Uses the first block of these eight slots whose lane for this slot is free.
void DriveProgram::add_term(std::int32_t slot, const Harmonic& term) {
  if (term.amplitude == 0) return;
  constexpr auto kSize = static_cast<std::int32_t>(kAngleBlock);
  const std::int32_t first = slot / kSize * kSize;
  const std::size_t lane = idx(slot - first);
  auto block = std::find_if(harmonics_.begin(), harmonics_.end(),
                            [&](const HarmonicBlock& b) { return b.slot == first && b.amplitude[lane] == 0; });
  if (block == harmonics_.end()) {
    block = harmonics_.insert(block, HarmonicBlock{});
    block->slot = first;
  }
  block->frequency[lane] = term.frequency;
  block->phase[lane] = term.phase;
  block->amplitude[lane] = term.amplitude * scale_[idx(slot)];
  block->omega[lane] = law_detail::two_pi<double>() * term.frequency;
}

void DriveProgram::add_assignment(const System& system, const Assignment& assignment) {
  const auto terms = system.form(assignment.form);
  const auto factor = [&](const Term& t) { return system.constants[idx(t.constant)]; };
  const auto begin = static_cast<std::int32_t>(terms_.size());
  if (terms.size() == 1 && factor(terms[0]) == 1 && slot_of_[idx(terms[0].coordinate)] >= 0) {
    add_copies(slot_of_[idx(terms[0].coordinate)], assignment.coordinate, 1);
    return;
  }
  for (const Term& t : terms) terms_.push_back({t.coordinate, factor(t)});
  sums_.push_back({assignment.coordinate, begin, static_cast<std::int32_t>(terms_.size())});
}

bool DriveProgram::renew_assignments(const System& system, const Driven& driven) {
  auto sum = sums_.begin();
  for (const Index i : driven.assignments) {
    const Assignment& assignment = system.assignments[idx(i)];
    const auto terms = system.form(assignment.form);
    const auto factor = [&](const Term& t) { return system.constants[idx(t.constant)]; };
    if (sum == sums_.end() || sum->coordinate != assignment.coordinate) {
      if (factor(terms[0]) != 1) return false;  // it was a copy
      continue;
    }
    for (std::size_t k = 0; k < terms.size(); ++k) terms_[idx(sum->begin) + k].factor = factor(terms[k]);
    ++sum;
  }
  return true;
}

std::int32_t DriveProgram::slot(std::size_t input, int law) const {
  return slot_[idx(first_slot_[input]) + static_cast<std::size_t>(law)];
}

// The laws in blocks of W.
LawOutline DriveProgram::law_outline() const {
  LawOutline out;
  while (idx(out.lanes) < std::min(laws_, kAngleBlock)) out.lanes *= 2;
  const std::size_t w = idx(out.lanes);
  for (std::size_t first = 0; first < laws_; first += w) {
    LawOutline::Block& block = out.blocks.emplace_back();
    const auto lanes_of = [&](const double* from) { return std::vector<double>(from, from + w); };
    block.base = lanes_of(base_.data() + first);
    block.angles = static_cast<int>(std::clamp(angles_, first, first + w) - first);
    for (const HarmonicBlock& h : harmonics_) {
      if (idx(h.slot) != first) continue;
      block.harmonics.push_back({lanes_of(h.frequency), lanes_of(h.phase), lanes_of(h.amplitude), lanes_of(h.omega)});
    }
    std::vector<std::size_t> layers(w, 0);  // polynomials so far
    for (const Polynomial& p : polynomials_) {
      if (idx(p.slot) < first || idx(p.slot) >= first + w) continue;
      const std::size_t lane = idx(p.slot) - first, layer = layers[lane]++, count = idx(p.end - p.begin);
      if (layer == block.polynomials.size()) block.polynomials.emplace_back();
      LawOutline::Polynomials& of = block.polynomials[layer];
      of.resize(std::max(of.size(), count), std::vector<double>(w));
      for (std::size_t k = 0; k < count; ++k) of[k][lane] = coefficients_[idx(p.begin) + k];
    }
    std::fill(layers.begin(), layers.end(), 0);
    for (const Table& table : tables_) {
      if (idx(table.slot) < first || idx(table.slot) >= first + w) continue;
      const std::size_t lane = idx(table.slot) - first, layer = layers[lane]++;
      if (layer == block.tables.size())
        block.tables.push_back({std::vector<const Law::Spline*>(w), std::vector<double>(w)});
      block.tables[layer].of[lane] = table.of;
      block.tables[layer].unit[lane] = scale(table.slot);
    }
  }
  return out;
}

void DriveProgram::use(StepCode& code) {
  constexpr std::size_t kLeast = 100;  // instructions of a block with harmonics
  if (laws_ == 0 || kLeast * harmonics_.size() > kMostInstructions) return;
  const LawOutline outline = law_outline();
  LawStep step = law_step(outline);
  code_ = code.of(step.program, outline.lanes);
  numbers_ = std::move(step.numbers);
}

bool DriveProgram::evaluate_by_code(double t) {
  if (!code_ || held_laws_ > 0) return false;
  double too_large[kAngleBlock] = {};
  std::array<double*, kMemories> memory;  // the code reads no other
  const auto put = [&](Memory m, double* at) { memory[static_cast<std::size_t>(m)] = at; };
  put(Memory::settings, &t);
  put(Memory::factors, numbers_.data());
  put(Memory::laws, jets_[0].data());
  put(Memory::law_rates, jets_[1].data());
  put(Memory::law_accelerations, jets_[2].data());
  put(Memory::sines, sines_.data());
  put(Memory::cosines, cosines_.data());
  put(Memory::figures, too_large);
  code_->run(memory);
  knows_sines_ = std::all_of(std::begin(too_large), std::end(too_large), [](double x) { return x <= 0; });
  return true;
}

void DriveProgram::evaluate(double t) {
  if (!evaluate_by_code(t)) evaluate_by_kernels(t);
  for (Other& o : others_) {
    if (held_[idx(o.slot)] != 0) continue;
    o.to = {t, std::visit([&](const auto& part) { return law_detail::evaluate(part, t); }, *o.part)};
    add(o.slot, o.to.motion, scale_[idx(o.slot)]);
    knows_sines_ = false;
  }
}

// Harmonics, polynomials and tables. As fast as machine code from six laws on; the law program, interpreted, takes 5 to
// 11 times as long.
void DriveProgram::evaluate_by_kernels(double t) {
  knows_sines_ = false;
  const std::size_t size = base_.size();
  double *value = jets_[0].data(), *rate = jets_[1].data(), *acceleration = jets_[2].data();
  for (std::size_t i = 0; i < size; ++i) {
    value[i] = base_[i];
    rate[i] = acceleration[i] = 0;
  }
  if (!harmonics_.empty()) {
    kernels_->add_harmonics(harmonics_.data(), harmonics_.size(), t, value, rate, acceleration);
  }
  for (const Polynomial& p : polynomials_) {
    add(p.slot,
        law_detail::horner(std::span<const double>(coefficients_.data() + p.begin, coefficients_.data() + p.end), t),
        1);
  }
  for (const Table& table : tables_) {
    if (held_[idx(table.slot)] == 0) add(table.slot, law_detail::evaluate(*table.of, t), scale(table.slot));
  }
}

void DriveProgram::add(std::int32_t slot, const Motion& m, double scale) {
  jets_[0][idx(slot)] += m.value * scale;
  jets_[1][idx(slot)] += m.rate * scale;
  jets_[2][idx(slot)] += m.acceleration * scale;
}

void DriveProgram::replace(std::int32_t slot, const Motion& motion) {
  const double scale = scale_[idx(slot)];
  knows_sines_ = false;
  jets_[0][idx(slot)] = motion.value * scale;
  jets_[1][idx(slot)] = motion.rate * scale;
  jets_[2][idx(slot)] = motion.acceleration * scale;
}

void DriveProgram::keep_expansion() {
  for (std::size_t d = 0; d < 3; ++d)
    kept_[d].assign(jets_[d].begin(), jets_[d].begin() + static_cast<std::ptrdiff_t>(laws_));
}

void DriveProgram::expand(double seconds) {
  knows_sines_ = false;
  for (std::size_t i = 0; i < laws_; ++i) {
    jets_[0][i] = kept_[0][i] + seconds * (kept_[1][i] + seconds / 2 * kept_[2][i]);
    jets_[1][i] = kept_[1][i] + seconds * kept_[2][i];
    jets_[2][i] = kept_[2][i];
  }
}

void DriveProgram::move_only(std::int32_t slot) {
  for (std::size_t i = 0; i < laws_; ++i) jets_[1][i] = jets_[2][i] = 0;
  jets_[1][idx(slot)] = scale_[idx(slot)];
}

void DriveProgram::move(std::span<const double> rates) {
  std::copy(rates.begin(), rates.end(), jets_[1].begin());
  std::fill_n(jets_[2].begin(), laws_, 0.0);
}

bool DriveProgram::bends() const {
  return !evenly_ ||
         std::any_of(bend_.begin(), bend_.end(), [](const Bend& b) { return b.acceleration != 0 || b.steady != 0; });
}

bool DriveProgram::renew_bows(double from, double to) {
  constexpr double kEqualSteps = 1e-10;  // steps of a grid differ by the rounding of times
  const double length = std::abs(to - from);
  if (std::abs(length - length_of_bows_) <= kEqualSteps * length) return false;
  compute_bows(from, to);
  length_of_bows_ = evenly_ ? length : kNan;
  return true;
}

void DriveProgram::compute_bows(double from, double to) {
  const double h = to - from, part = h * h / 8;
  for (std::size_t i = 0; i < laws_; ++i) {
    bows_[i] = std::min(part * bend_[i].acceleration, bend_[i].reach) + part * std::abs(bend_[i].steady);
  }
  for (const Other& o : uneven_) {
    const auto& polynomial = std::get<Law::Polynomial>(*o.part);
    bows_[idx(o.slot)] += part * most_acceleration(polynomial.coefficients, from, to) * scale_[idx(o.slot)];
  }
  for (const Table& table : tables_) {
    if (held_[idx(table.slot)] == 0) bows_[idx(table.slot)] += bow(*table.of, from, to) * scale(table.slot);
  }
  for (Other& o : others_) {
    if (held_[idx(o.slot)] != 0) continue;
    const Overloaded bow_of_part{
        [](const Law::Polynomial&) { return 0.0; },  // never here
        [](const Law::Harmonics&) { return 0.0; },   // counted in bend_
        [&](const Law::Spline& spline) { return bow(spline, from, to); },
        [&](const Law::Function& function) { return bow_of_function(function, o, from, to); },
    };
    bows_[idx(o.slot)] += std::visit(bow_of_part, *o.part) * scale_[idx(o.slot)];
  }
}

double DriveProgram::bow_of_function(const Law::Function& law, Other& of, double from, double to) {
  const auto at = [&](Sample& sample, double t) {
    if (sample.time != t) sample = {t, law.motion(t)};
    return sample.motion;
  };
  if (from == to) return 0;
  const Motion a = at(of.from, from), b = at(of.to, to), between = law.motion(from + kBetween * (to - from));
  const double off = std::abs(between.value - (a.value + kBetween * (b.value - a.value)));
  const double most = std::max({std::abs(a.acceleration), std::abs(between.acceleration), std::abs(b.acceleration)});
  const double found = std::max(off / (4 * kBetween * (1 - kBetween)), (to - from) * (to - from) / 8 * most);
  return std::isfinite(found) ? found : 0;
}

void DriveProgram::place_as(const DriveProgram& other, double* const (&state)[3], std::size_t stride) const {
  double *const q = state[0], *const rate = state[1], *const acceleration = state[2];
  const std::vector<double>(&jets)[3] = other.jets_;
  const double *const value = jets[0].data(), *const first = jets[1].data(), *const second = jets[2].data();
  for (const Copy& c : copies_) {
    const std::size_t at = idx(c.coordinate) * stride;
    q[at] = value[c.slot];
    rate[at] = first[c.slot];
    acceleration[at] = second[c.slot];
  }
  for (const Sum& s : sums_) {
    double total = -0.0, of_rates = total, of_accelerations = total;  // -0 adds nothing, not even a sign
    for (const TermOf& t : std::span(terms_.data() + s.begin, terms_.data() + s.end)) {
      const std::size_t from = idx(t.coordinate) * stride;
      total += t.factor * q[from];
      of_rates += t.factor * rate[from];
      of_accelerations += t.factor * acceleration[from];
    }
    const std::size_t at = idx(s.coordinate) * stride;
    q[at] = total;
    rate[at] = of_rates;
    acceleration[at] = of_accelerations;
  }
}

DrivenOutline DriveProgram::outline(std::int32_t stride) const {
  DrivenOutline out;
  out.laws = static_cast<std::int32_t>(laws_);
  out.directions = directions_;
  out.frames = frames_;
  for (const Copy& c : copies_) out.copies.push_back({c.slot, c.coordinate * stride});
  for (const Sum& s : sums_) {
    DrivenOutline::Sum& to = out.sums.emplace_back();
    to.address = s.coordinate * stride;
    for (std::int32_t t = s.begin; t < s.end; ++t)
      to.terms.push_back({terms_[idx(t)].coordinate * stride, terms_[idx(t)].factor});
  }
  return out;
}

void DriveProgram::turn() {
  const auto at = [&](std::int32_t angle) {
    const std::size_t i = idx(angle);
    return cos_sin<double>({jets_[0][i], jets_[1][i], jets_[2][i]}, cosines_[i], sines_[i]);
  };
  const auto put = [&](std::int32_t slot, const Motion& m) {
    jets_[0][idx(slot)] = m.value;
    jets_[1][idx(slot)] = m.rate;
    jets_[2][idx(slot)] = m.acceleration;
  };
  for (const Turn& turn : directions_) {
    const CosSin<double> both = at(turn.angle);
    put(turn.result, both.cosine);
    put(turn.result + 1, both.sine);
  }
  for (const Turn& turn : frames_) {
    Motion r[9];
    euler_zyx(at(turn.angle), at(turn.angle + 1), at(turn.angle + 2), r);
    for (std::int32_t k = 0; k < 9; ++k) put(turn.result + k, r[k]);
  }
}

bool DriveProgram::defined() const {
  const double *const value = jets_[0].data(), *const rate = jets_[1].data(), *const acceleration = jets_[2].data();
  for (std::size_t i = 0; i < laws_; ++i) {
    if (std::isnan(value[i])) return false;
    // Rates and accelerations may be outputs, so they must be finite.
    if (!std::isfinite(rate[i]) || !std::isfinite(acceleration[i])) return false;
  }
  for (std::size_t i = 0; i < angles_; ++i) {
    if (std::isnan(cosines_[i])) return false;  // the angle is infinite
  }
  return true;
}

Code DriveProgram::why_undefined(const System& system, double t) {
  for (const DriverInput& input : system.inputs) {
    for (const Law& law : input.laws) {
      if (!law.covers(t)) return Code::out_of_range;
    }
  }
  return Code::not_finite;
}

}  // namespace assur
