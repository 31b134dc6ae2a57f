#include "simulation/drive_program.hpp"

#include <algorithm>
#include <cmath>

#include "scene/drive.hpp"

namespace assur {
namespace {

std::size_t idx(std::int32_t i) { return static_cast<std::size_t>(i); }

bool is_angle(const System& s, const DriverInput& in, int law) {
  if (in.kind == DriverInput::Kind::scalar) return false;
  return in.kind == DriverInput::Kind::direction || law >= s.dimension;
}

}  // namespace

DriveProgram::DriveProgram(const System& system, const Driven& driven) {
  for (const DriverInput& in : system.inputs) {
    first_slot_.push_back(static_cast<std::int32_t>(slot_.size()));
    slot_.resize(slot_.size() + in.laws.size(), -1);
  }
  add_slots(system, driven, true);
  angles_ = scale_.size();
  add_slots(system, driven, false);
  slots_ = scale_.size();
  const std::size_t padded = (slots_ + kAngleBlock - 1) / kAngleBlock * kAngleBlock;
  for (std::vector<double>* v : {&base_, &jets_[0], &jets_[1], &jets_[2], &sines_, &cosines_}) v->resize(padded);
  held_.resize(slots_);
  for (const Index input : driven.inputs) add_input(system, idx(input));
  for (const Index i : driven.assignments) add_assignment(system, system.assignments[idx(i)]);
}

void DriveProgram::add_slots(const System& system, const Driven& driven, bool angles) {
  for (const Index input : driven.inputs) {
    const DriverInput& in = system.inputs[idx(input)];
    for (std::size_t k = 0; k < in.laws.size(); ++k) {
      if (is_angle(system, in, static_cast<int>(k)) != angles) continue;
      slot_[idx(first_slot_[idx(input)]) + k] = static_cast<std::int32_t>(scale_.size());
      scale_.push_back(angles ? 1 : 1 / system.unit(in.dimension));
    }
  }
}

void DriveProgram::add_input(const System& system, std::size_t input) {
  const DriverInput& in = system.inputs[input];
  for (std::size_t k = 0; k < in.laws.size(); ++k) add_law(slot(input, static_cast<int>(k)), in.laws[k]);
  if (in.kind == DriverInput::Kind::direction) {
    directions_.push_back({slot(input, 0), in.first});
    return;
  }
  const int copies = in.kind == DriverInput::Kind::scalar ? 1 : system.dimension;
  for (int k = 0; k < copies; ++k) copies_.push_back({slot(input, k), in.first + k});
  if (in.count == copies) return;
  (system.dimension == 2 ? directions_ : frames_).push_back({slot(input, copies), in.first + copies});
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
    } else {
      others_.push_back({slot, &part});
    }
  }
}

// Into the first block of its eight slots where its own place is free.
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
  if (terms.size() == 1 && factor(terms[0]) == 1) {
    const Index from = terms[0].coordinate;
    if (!sums_.empty()) {
      Sum& run = sums_.back();
      if (run.count > 0 && assignment.coordinate == run.coordinate + run.count && from == run.from + run.count) {
        ++run.count;
        return;
      }
    }
    sums_.push_back({assignment.coordinate, from, 1, begin, begin});
    return;
  }
  for (const Term& t : terms) terms_.push_back({t.coordinate, factor(t)});
  sums_.push_back({assignment.coordinate, 0, 0, begin, static_cast<std::int32_t>(terms_.size())});
}

std::int32_t DriveProgram::slot(std::size_t input, int law) const {
  return slot_[idx(first_slot_[input]) + static_cast<std::size_t>(law)];
}

void DriveProgram::evaluate(double t) {
  const std::size_t size = base_.size();
  double *value = jets_[0].data(), *rate = jets_[1].data(), *acceleration = jets_[2].data();
  for (std::size_t i = 0; i < size; ++i) {
    value[i] = base_[i];
    rate[i] = acceleration[i] = 0;
  }
  kernels_->add_harmonics(harmonics_.data(), harmonics_.size(), t, value, rate, acceleration);
  const auto add = [&](std::int32_t slot, const Motion& m, double scale) {
    value[slot] += m.value * scale;
    rate[slot] += m.rate * scale;
    acceleration[slot] += m.acceleration * scale;
  };
  for (const Polynomial& p : polynomials_) {
    add(p.slot, law_detail::horner({coefficients_.data() + p.begin, coefficients_.data() + p.end}, t), 1);
  }
  for (const Other& o : others_) {
    if (held_[idx(o.slot)] != 0) continue;
    add(o.slot, std::visit([&](const auto& part) { return law_detail::evaluate(part, t); }, *o.part),
        scale_[idx(o.slot)]);
  }
}

void DriveProgram::replace(std::int32_t slot, const Motion& motion) {
  const double scale = scale_[idx(slot)];
  jets_[0][idx(slot)] = motion.value * scale;
  jets_[1][idx(slot)] = motion.rate * scale;
  jets_[2][idx(slot)] = motion.acceleration * scale;
}

void DriveProgram::place(double* const (&state)[3]) {
  kernels_->sin_cos(jets_[0].data(), angles_, sines_.data(), cosines_.data());
  const auto put = [&](Index coordinate, const Motion& m) {
    state[0][coordinate] = m.value;
    state[1][coordinate] = m.rate;
    state[2][coordinate] = m.acceleration;
  };
  const auto turned = [&](std::int32_t slot) {
    const std::size_t i = idx(slot);
    return cos_sin<double>({jets_[0][i], jets_[1][i], jets_[2][i]}, cosines_[i], sines_[i]);
  };
  for (const Copy& c : copies_) {
    put(c.coordinate, {jets_[0][idx(c.slot)], jets_[1][idx(c.slot)], jets_[2][idx(c.slot)]});
  }
  for (const Turn& turn : directions_) {
    const CosSin<double> at = turned(turn.slot);
    put(turn.first, at.cosine);
    put(turn.first + 1, at.sine);
  }
  for (const Turn& turn : frames_) {
    Motion r[9];
    euler_zyx(turned(turn.slot), turned(turn.slot + 1), turned(turn.slot + 2), r);
    for (int k = 0; k < 9; ++k) put(turn.first + k, r[k]);
  }
  for (double* x : state) {
    for (const Sum& s : sums_) {
      for (Index k = 0; k < s.count; ++k) x[s.coordinate + k] = x[s.from + k];
      if (s.count > 0) continue;
      double total = 0;
      for (std::int32_t t = s.begin; t < s.end; ++t) total += terms_[idx(t)].factor * x[terms_[idx(t)].coordinate];
      x[s.coordinate] = total;
    }
  }
}

bool DriveProgram::defined() const {
  bool ok = true;
  for (std::size_t i = 0; i < slots_; ++i) ok &= jets_[0][i] == jets_[0][i];
  for (std::size_t i = 0; i < angles_; ++i) ok &= cosines_[i] == cosines_[i];  // none for an infinite angle
  return ok;
}

}  // namespace assur
