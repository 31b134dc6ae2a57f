// The errors of known coordinates, with which the probes begin: rounding of laws and of the coordinates that follow
// from them, and errors of static coordinates.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "equations/outputs.hpp"
#include "equations/own_values.hpp"
#include "errors/error_estimate.hpp"
#include "errors/law_rounding.hpp"
#include "index.hpp"
#include "numbers.hpp"
#include "outputs/random_sign.hpp"

namespace assur {
namespace {

constexpr double kLeastGrown = 4 * kEps;  // growth of the rounding of a law up to this one does not matter

}  // namespace

// The rounding of laws may grow with the time, and does so unseen where the values of the drivers are angles: the
// measurement covers, and serves, a time in which it at most doubles.
void ErrorEstimate::find_rounding_of_laws(std::size_t mechanism, double t) {
  Mechanism& m = mechanisms_[mechanism];
  m.measured = m.before = t;
  m.serves = 0;
  round_laws(*systems_[mechanism], t, true, m.laws);
  if (begins_at_rest(m, *systems_[mechanism])) {
    for (Jet<double>& bound : m.laws) bound.rate = bound.acceleration = 0;
    return;
  }
  for (std::int64_t steps = kStepsBetween; steps > 0 && m.step != 0 && m.serves == 0; steps /= 2) {
    const double later = static_cast<double>(steps) * m.step;
    round_laws(*systems_[mechanism], t + later, false, ahead_);
    if (!has_grown(m)) m.serves = std::abs(later);
  }
  if (m.serves == 0) return;
  for (std::size_t k = 0; k < ahead_.size(); ++k) {
    Jet<double>& bound = m.laws[k];
    bound = {std::max(bound.value, ahead_[k].value), std::max(bound.rate, ahead_[k].rate),
             std::max(bound.acceleration, ahead_[k].acceleration)};
  }
}

// Bounds of the rounding of all laws, internal units. now: functions of the program may be called.
void ErrorEstimate::round_laws(const System& s, double t, bool now, std::vector<Jet<double>>& bounds) const {
  auto bound = bounds.begin();
  for (const Index i : evaluated_) {
    const DriverInput& in = s.inputs[idx(i)];
    for (std::size_t k = 0; k < in.laws.size(); ++k) {
      const double unit = kEps / 2 / (is_angle(s, in, k) ? 1 : s.unit(in.dimension));
      const Motion* const command = inputs_ != nullptr ? inputs_->command(idx(i), k) : nullptr;
      const double zero = command != nullptr && in.zero != 0 ? std::abs(command->value) : 0;  // added to the target
      *bound++ = unit * (command != nullptr ? Jet<double>{zero, 0, 0} : rounding(in.laws[k], t, now));
    }
  }
}

// True if the rates of the start are only rounding, which says nothing about those of the steps that follow.
bool ErrorEstimate::begins_at_rest(const Mechanism& m, const System& s) const {
  if (m.step != 0 || (s.scene != nullptr && s.scene->time().steps() == 0)) return false;
  double rate = 0, acceleration = 0;
  for (const Jet<double>& bound : m.laws) {
    rate = std::max(rate, kGrownTwice * bound.rate);
    acceleration = std::max(acceleration, kGrownTwice * bound.acceleration);
  }
  return m.scale[1] <= rate && m.scale[2] <= acceleration;
}

// True if the rounding of a law is clearly larger ahead.
bool ErrorEstimate::has_grown(const Mechanism& m) const {
  bool grown = false;
  for (std::size_t k = 0; k < ahead_.size(); ++k) {
    const Jet<double>&now = m.laws[k], &later = ahead_[k];
    grown |= later.value > kGrownTwice * std::max(now.value, kLeastGrown);
    grown |= later.rate > kGrownTwice * std::max(now.rate, kLeastGrown * m.scale[1]);
    grown |= later.acceleration > kGrownTwice * std::max(now.acceleration, kLeastGrown * m.scale[2]);
  }
  return grown;
}

// Static coordinates keep the residual of the start, whatever the residual of later steps is.
void ErrorEstimate::perturb_static(const double* state) {
  const std::span<const std::int32_t> stands = static_.coordinates();
  const std::size_t n = systems_.empty() ? 0 : systems_[0]->coordinates.size();
  std::vector<double> q(n), known(n * kRandom);
  for (std::size_t i = 0; i < used_; ++i) {
    for (std::size_t c = 0; c < n; ++c) {
      const std::int32_t a = layout_.address[c];
      q[c] = a >= 0 ? state[idx(a) + i] : 0;
      const bool is_known = a >= 0 && systems_[i]->coordinates[c].role == Role::driven;
      for (std::size_t k = 0; k < kRandom; ++k) known[k * n + c] = is_known ? probes_[k + 1].errors[0][idx(a) + i] : 0;
    }
    const std::vector<double> errors = static_.draw(*systems_[i], q, known, kRandom, 0);
    for (std::size_t k = 0; k <= kRandom; ++k) {
      for (std::size_t s = 0; s < stands.size(); ++s) {
        probes_[k].errors[0][idx(layout_.address[idx(stands[s])]) + i] = errors[k * stands.size() + s];
      }
    }
  }
  static_known_ = true;
}

namespace {

// The axes of the angles psi, theta and phi of a frame with this first axis.
std::array<std::array<Jet<double>, 3>, 3> euler_axes(const std::array<Jet<double>, 3>& first) {
  const Jet<double> across[2] = {-first[1], first[0]};
  const Jet<double> size = length<double>(across);
  const bool is_upright = !(size.value > 0);
  const Jet<double> one{1, 0, 0}, nothing{};
  return {{{nothing, nothing, one},
           {is_upright ? nothing : across[0] / size, is_upright ? one : across[1] / size, nothing},
           first}};
}

}  // namespace

// Rounding of laws, of the directions and frames of their angles, and of the coordinates that follow from them.
void ErrorEstimate::perturb_known(const double* const (&state)[3], const Probe& probe) {
  RandomSign sign(++seed_);
  using Errors = Jet<double>;  // of a value and its derivatives, or of an angle as a function of time
  for (std::size_t i = 0; i < used_; ++i) {
    const System& s = *systems_[i];
    const Jet<double>* bound = mechanisms_[i].laws.data();
    const auto address = [&](Index c) { return idx(layout_.address[idx(c)]) + i; };
    const auto at = [&](Index c) -> Jet<double> {
      const std::size_t a = address(c);
      return {state[0][a], state[1][a], state[2][a]};
    };
    const auto put = [&](Index c, const Errors& e) {
      const std::size_t a = address(c);
      probe.errors[0][a] = e.value;
      probe.errors[1][a] = e.rate;
      probe.errors[2][a] = e.acceleration;
    };
    const auto draw = [&](const Jet<double>& size) {
      return Errors{sign() * size.value, sign() * size.rate, sign() * size.acceleration};
    };
    // Rounding of sines and cosines: of the whole vector, because its components may cancel.
    const auto of_vector = [&](std::span<const Jet<double>> v) {
      Jet<double> square;
      for (const Jet<double>& x : v) {
        square += Jet<double>{x.value * x.value, x.rate * x.rate, x.acceleration * x.acceleration};
      }
      return 2 * kEps * Jet<double>{std::sqrt(square.value), std::sqrt(square.rate), std::sqrt(square.acceleration)};
    };
    const auto turn = [&](Index c, const Errors& angle) {
      const Jet<double> v[2] = {at(c), at(c + 1)}, size = of_vector(v);
      put(c, draw(size) - angle * v[1]);
      put(c + 1, draw(size) + angle * v[0]);
    };
    const auto turn_frame = [&](Index c, const Errors(&angles)[3]) {
      std::array<std::array<Jet<double>, 3>, 3> axes;  // columns of the frame
      for (Index k = 0; k < 9; ++k) axes[idx(k / 3)][idx(k % 3)] = at(c + k);
      std::array<Errors, 3> turned;
      const auto of = euler_axes(axes[0]);
      for (std::size_t k = 0; k < 3; ++k)
        turned[k] = angles[0] * of[0][k] + angles[1] * of[1][k] + angles[2] * of[2][k];
      for (std::size_t j = 0; j < 3; ++j) {
        const auto& axis = axes[j];
        const Jet<double> size = of_vector(axis);
        for (std::size_t k = 0; k < 3; ++k) {
          const std::size_t x = (k + 1) % 3, y = (k + 2) % 3;
          put(c + 3 * static_cast<Index>(j) + static_cast<Index>(k),
              draw(size) + turned[x] * axis[y] - turned[y] * axis[x]);
        }
      }
    };
    for (const Index n : evaluated_) {
      const DriverInput& in = s.inputs[idx(n)];
      const Index straight = in.kind == DriverInput::Kind::direction ? 0
                             : in.kind == DriverInput::Kind::scalar  ? 1
                                                                     : static_cast<Index>(s.dimension);
      for (Index k = 0; k < straight; ++k) put(in.first + k, draw(bound[k]));
      bound += straight;
      const Index angles = static_cast<Index>(in.laws.size()) - straight;
      if (angles == 1) turn(in.first + straight, draw(bound[0]));
      if (angles == 3) turn_frame(in.first + straight, {draw(bound[0]), draw(bound[1]), draw(bound[2])});
      bound += angles;
    }
    for (const Assignment& a : s.assignments) {
      const std::span<const Term> terms = s.form(a.form);
      if (layout_.address[idx(a.coordinate)] != a.coordinate * static_cast<Index>(outputs_.size())) continue;  // a copy
      Errors sum;
      Jet<double> size;
      for (const Term& t : terms) {
        const double factor = s.constants[idx(t.constant)];
        const std::size_t from = address(t.coordinate);
        sum += factor * Errors{probe.errors[0][from], probe.errors[1][from], probe.errors[2][from]};
        const Jet<double> term = at(t.coordinate);
        if (terms.size() == 1 && std::abs(factor) == 1) continue;
        size += kEps * std::abs(factor) *
                Jet<double>{std::abs(term.value), std::abs(term.rate), std::abs(term.acceleration)};
      }
      put(a.coordinate, sum + draw(size));
    }
  }
}

}  // namespace assur
