// Known coordinates at a time: laws, frames of poses, and coordinates that drivers fix.
#pragma once

#include "equations/system.hpp"
#include "scene/jet.hpp"
#include "scene/law_evaluate.hpp"

namespace assur {

// Columns of Rz(psi) Ry(theta) Rx(phi), one after the other.
template <class T>
void euler_zyx(const CosSin<T>& psi, const CosSin<T>& theta, const CosSin<T>& phi, Jet<T> (&r)[9]) {
  const auto& [cz, sz] = psi;
  const auto& [cy, sy] = theta;
  const auto& [cx, sx] = phi;
  r[0] = cz * cy;
  r[1] = sz * cy;
  r[2] = -sy;
  r[3] = cz * sy * sx - sz * cx;
  r[4] = sz * sy * sx + cz * cx;
  r[5] = cy * sx;
  r[6] = cz * sy * cx + sz * sx;
  r[7] = sz * sy * cx - cz * sx;
  r[8] = cy * cx;
}

// Sets the listed driven coordinates in q, rate and acceleration (null: not needed). law(input, k) returns the jet of
// the k-th law of System::inputs[input] in SI units.
template <class T, class LawJet>
void drive(const System& s, const Driven& driven, LawJet&& law, T* q, T* rate, T* acceleration) {
  const auto put = [&](Index coordinate, const Jet<T>& j) {
    q[coordinate] = j.value;
    if (rate != nullptr) rate[coordinate] = j.rate;
    if (acceleration != nullptr) acceleration[coordinate] = j.acceleration;
  };
  for (const Index input : driven.inputs) {
    const auto i = static_cast<std::size_t>(input);
    const DriverInput& in = s.inputs[i];
    const T scale = T(1 / s.unit(in.dimension));  // a power of two
    const auto scaled = [&](Jet<T> j) { return Jet<T>{j.value * scale, j.rate * scale, j.acceleration * scale}; };
    switch (in.kind) {
      case DriverInput::Kind::scalar:
        put(in.first, scaled(law(i, 0)));
        break;
      case DriverInput::Kind::direction: {
        const CosSin<T> d = cos_sin<T>(law(i, 0));
        put(in.first, d.cosine);
        put(in.first + 1, d.sine);
        break;
      }
      case DriverInput::Kind::frame: {
        const int dim = s.dimension;
        for (int k = 0; k < dim; ++k) put(in.first + k, scaled(law(i, k)));
        if (in.count == dim) break;
        if (dim == 2) {
          const CosSin<T> d = cos_sin<T>(law(i, 2));
          put(in.first + 2, d.cosine);
          put(in.first + 3, d.sine);
        } else {
          Jet<T> r[9];
          euler_zyx(cos_sin<T>(law(i, 3)), cos_sin<T>(law(i, 4)), cos_sin<T>(law(i, 5)), r);
          for (int k = 0; k < 9; ++k) put(in.first + 3 + k, r[k]);
        }
        break;
      }
    }
  }
  const auto sum = [&](Index form, const T* x) {
    T total = 0;
    for (const Term& t : s.form(form)) total += T(s.constants[static_cast<std::size_t>(t.constant)]) * x[t.coordinate];
    return total;
  };
  for (const Index i : driven.assignments) {
    const Assignment& a = s.assignments[static_cast<std::size_t>(i)];
    q[a.coordinate] = sum(a.form, q);
    if (rate != nullptr) rate[a.coordinate] = sum(a.form, rate);
    if (acceleration != nullptr) acceleration[a.coordinate] = sum(a.form, acceleration);
  }
}

}  // namespace assur
