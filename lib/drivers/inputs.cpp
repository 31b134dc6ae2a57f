#include "drivers/inputs.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>

#include "equations/law_bow.hpp"
#include "numbers.hpp"
#include "scene/jet.hpp"
#include "scene/names.hpp"

namespace assur {
namespace {

// Quintic through value, rate and acceleration at both ends.
Motion blend(const Motion& a, const Motion& b, double start, double end, double t) {
  if (t == end) return b;
  if (t == start) return a;
  const double d = end - start;
  const Jet<double> s{(t - start) / d, 1 / d, 0}, r = 1.0 - s;
  const Jet<double> s3 = s * s * s, r3 = r * r * r;
  const Jet<double> one_b = s3 * (10.0 + s * (6.0 * s - 15.0)), one_a = r3 * (10.0 + r * (6.0 * r - 15.0));
  const Jet<double> rate_a = r3 * s * (4.0 - 3.0 * r), rate_b = s3 * r * (4.0 - 3.0 * s);
  return a.value * one_a + b.value * one_b + (d * a.rate) * rate_a - (d * b.rate) * rate_b +
         (d * d / 2 * a.acceleration) * (r3 * s * s) + (d * d / 2 * b.acceleration) * (s3 * r * r);
}

constexpr int kLooks = 16;           // samples of a lever along its way
constexpr double kHidden = 0x1p-20;  // a smaller bow hides nothing; typical lengths are 1
constexpr int kBisections = 40;      // in the search for its minimum

bool reaches_zero(const Motion& from, const Motion& to, double seconds) {
  const double h = std::abs(seconds);
  const double way =
      h * (std::abs(from.rate) + std::abs(to.rate)) + h * h * (std::abs(from.acceleration) + std::abs(to.acceleration));
  if (std::min(from.value, to.value) > way) return false;
  const double nothing = 8 * kEps;  // typical lengths are 1
  const auto at = [&](double part) { return blend(from, to, 0, seconds, part * seconds); };
  const auto falls = [&](const Motion& m) { return m.rate * seconds < 0; };
  Motion before = from;
  for (int i = 1; i <= kLooks; ++i) {
    double low = (i - 1.0) / kLooks, high = static_cast<double>(i) / kLooks;
    const Motion here = at(high);
    if (!(here.value > nothing)) return true;
    if (falls(before) && !falls(here)) {
      for (int k = 0; k < kBisections; ++k) {
        const double middle = (low + high) / 2;
        (falls(at(middle)) ? low : high) = middle;
      }
      if (!(std::min(at(low).value, at(high).value) > nothing)) return true;
    }
    before = here;
  }
  return false;
}

}  // namespace

const Lever* vanished(std::span<const Lever> levers, const double* const (&from)[3], const double* const (&to)[3],
                      double seconds) {
  for (const Lever& l : levers) {
    const std::int32_t c = l.address;
    if (!(to[0][c] > 0)) return &l;
    if (seconds == 0) continue;
    if (reaches_zero({from[0][c], from[1][c], from[2][c]}, {to[0][c], to[1][c], to[2][c]}, seconds)) return &l;
  }
  return nullptr;
}

const Lever* may_vanish(std::span<const Lever> levers, const double* from, const double* to, double times) {
  for (const Lever& l : levers) {
    const double bow = times * l.bow;
    if (bow > kHidden && !(std::min(from[l.address], to[l.address]) > bow)) return &l;
  }
  return nullptr;
}

Inputs::Inputs(const System& system, const std::vector<std::string>& controlled)
    : system_(system), program_(system, {}) {
  for (std::size_t i = 0; i < system.inputs.size(); ++i) {
    const DriverInput& in = system.inputs[i];
    const std::string& name = system.drivers[in.driver];
    if (std::find(controlled.begin(), controlled.end(), name) == controlled.end()) continue;
    if (in.kind != DriverInput::Kind::frame) {
      add_control(name, i, 0);
      continue;
    }
    for (std::size_t k = 0; k < in.laws.size(); ++k) {
      add_control(name + "." + pose_part(k, system.dimension), i, static_cast<int>(k));
    }
  }
  std::string all;
  for (const Control& c : controls_) all += c.name + '\n';
  names_ = std::hash<std::string>()(all);
  compile(all_driven(system));
}

void Inputs::add_control(std::string name, std::size_t input, int law) {
  Control& c = controls_.emplace_back();
  c.name = std::move(name);
  c.input = input;
  c.law = law;
}

void Inputs::compile(const Driven& driven) {
  program_ = DriveProgram(system_, driven);
  for (Control& c : controls_) c.slot = program_.slot(c.input, c.law);
  evaluated_ = driven.inputs;
}

// All laws and targets at time t.
void Inputs::follow_laws(double t) {
  for (const Control& c : controls_) {
    if (c.slot >= 0) program_.hold(c.slot, c.set);
  }
  program_.evaluate(t);
  for (const Control& c : controls_) {
    if (c.slot >= 0 && c.set) program_.replace(c.slot, blend(c.from, c.to, c.start, c.end, t));
  }
}

void Inputs::expand_about(double t) {
  follow_laws(t);
  program_.keep_expansion();
  expanded_about_ = t;
}

void Inputs::evaluate(double t) {
  if (std::isnan(expanded_about_)) {
    follow_laws(t);
  } else {
    program_.expand(t - expanded_about_);
  }
}

Status Inputs::place(double t, double* const (&state)[3]) {
  program_.place(state);
  return program_.defined() ? Status{} : why_undefined(t);
}

// The driver whose law has no value.
Status Inputs::why_undefined(double t) const {
  const Code code = DriveProgram::why_undefined(system_, t);
  for (std::size_t i = 0; i < system_.inputs.size(); ++i) {
    const DriverInput& in = system_.inputs[i];
    for (std::size_t k = 0; k < in.laws.size(); ++k) {
      const std::int32_t slot = program_.slot(i, static_cast<int>(k));
      const bool fails = slot >= 0 && (code == Code::out_of_range ? !in.laws[k].covers(t) : !program_.finite(slot));
      if (fails) return {code, Place::driver(in.driver), t};
    }
  }
  return {code, {}, t};
}

bool Inputs::renew_bows(double from, double to) {
  if (!program_.renew_bows(from, to)) return false;
  for (const Control& c : controls_) {
    if (c.slot >= 0 && c.set) program_.set_bow(c.slot, bow_of_quintic(c.from, c.to, c.end - c.start, to - from));
  }
  return true;
}

void Inputs::lean(std::span<const double> rates, double* const (&state)[3]) {
  program_.move(rates);
  program_.place(state);
}

void Inputs::differentiate(std::size_t control, double* const (&state)[3]) {
  const std::int32_t slot = controls_[control].slot;
  if (slot < 0) return;  // nothing that is computed depends on it
  program_.move_only(slot);
  program_.place(state);
}

bool Inputs::follows_law(std::size_t input, std::size_t law) const {
  return program_.slot(input, static_cast<int>(law)) >= 0 &&
         std::none_of(controls_.begin(), controls_.end(), [&](const Control& c) {
           return c.input == input && static_cast<std::size_t>(c.law) == law && (c.set || c.pending);
         });
}

const Motion* Inputs::command(std::size_t input, std::size_t law) const {
  for (const Control& c : controls_) {
    if (c.input == input && static_cast<std::size_t>(c.law) == law && c.set) return &c.to;
  }
  return nullptr;
}

void Inputs::set(std::size_t driver, std::size_t names, const Motion& motion) {
  if (driver >= controls_.size() || names != names_) {
    throw Error(Error::Kind::input,
                "this is no handle of a controlled driver of this mechanism; ask Simulator::driver() for it");
  }
  Control& c = controls_[driver];
  c.next = motion;
  c.next.value += system_.inputs[c.input].zero;
  c.pending = true;
}

std::size_t Inputs::index(std::string_view driver) const {
  for (std::size_t i = 0; i < controls_.size(); ++i) {
    if (controls_[i].name == driver) return i;
  }
  std::vector<std::string_view> known;
  for (const Control& c : controls_) known.push_back(c.name);
  throw Error(Error::Kind::input,
              in_quotes(driver) + " is not a controlled driver" +
                  (known.empty() ? "; name it in PrepareOptions::controlled" : known_instead(driver, known)));
}

std::int32_t Inputs::not_finite(double& value) const {
  for (std::size_t i = 0; i < controls_.size(); ++i) {
    const Control& c = controls_[i];
    if (!c.pending) continue;
    for (const double v : {c.next.value, c.next.rate, c.next.acceleration}) {
      if (std::isfinite(v)) continue;
      value = v;
      return static_cast<std::int32_t>(i);
    }
  }
  return -1;
}

void Inputs::drop_pending() {
  for (Control& c : controls_) c.pending = false;
}

void Inputs::begin_step(double now, double next) {
  for (Control& c : controls_) {
    c.was_set = c.set;
    c.was_pending = c.pending;
    if (!c.set && c.pending) c.from = motion_by_law(c, now);
  }
  for (Control& c : controls_) {
    if (!c.set && !c.pending) continue;
    c.to = c.pending ? c.next : Motion{c.from.value, 0, 0};  // without a new target it comes to rest at its value
    c.set = true;
    c.pending = false;
    c.start = now;
    c.end = next;
    program_.forget_bows();
  }
}

void Inputs::end_step(double now, bool goes_on) {
  for (Control& c : controls_) {
    if (!c.set) continue;
    if (goes_on && !c.pending) {
      c.next = c.to;
      c.pending = true;
    }
    c.from = c.to = blend(c.from, c.to, c.start, c.end, now);
    c.start = c.end = now;
  }
}

bool Inputs::stop(double now) {
  end_step(now, false);
  drop_pending();
  bool stopped = false;
  for (Control& c : controls_) {
    if (c.set) stopped = comes_to_rest(c) || stopped;
  }
  return stopped;
}

bool Inputs::comes_to_rest(Control& c) {
  const bool moved = c.from.rate != 0 || c.from.acceleration != 0;
  c.from = c.to = {c.from.value, 0, 0};
  return moved;
}

void Inputs::reset() {
  for (Control& c : controls_) c.set = c.pending = false;
}

void Inputs::undo_step(Controls& controls, double now) {
  for (Control& c : controls) {
    c.set = c.was_set;
    c.pending = false;
    c.to = c.from;
    c.start = c.end = now;
  }
}

void Inputs::withhold_targets(Controls& controls) {
  for (Control& c : controls) c.was_pending = std::exchange(c.pending, false);
}

void Inputs::set_controls(const Controls& other) {
  for (std::size_t i = 0; i < controls_.size(); ++i) {
    const std::int32_t slot = controls_[i].slot;  // simulators may differ in the drivers that they evaluate
    controls_[i] = other[i];
    controls_[i].slot = slot;
  }
  program_.forget_bows();
}

bool Inputs::ask_again_from_rest(double now) {
  bool moved = false;
  for (Control& c : controls_) {
    if (!c.set && c.was_pending) c.from = motion_by_law(c, now);
    if (c.set || c.was_pending) moved = moved || c.from.rate != 0 || c.from.acceleration != 0;
  }
  if (!moved) return false;
  for (Control& c : controls_) {
    c.pending = c.was_pending;
    c.set = c.set || c.pending;  // also if the driver has followed its law so far
    if (c.set) (void)comes_to_rest(c);
  }
  return true;
}

}  // namespace assur
