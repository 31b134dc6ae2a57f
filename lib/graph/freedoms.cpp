#include "graph/freedoms.hpp"

#include <cmath>
#include <utility>

#include "index.hpp"

namespace assur {
namespace {

using Kind = DriverInput::Kind;

}  // namespace

int freedoms_of(const System& s, const DriverInput& in) {
  if (in.kind != Kind::frame) return 1;
  return in.count == s.dimension ? s.dimension : s.dimension == 3 ? 6 : 3;
}

Freedoms::Freedoms(const System& system, std::vector<Index> inputs) : s_(system) {
  for (const Index i : inputs) {
    const DriverInput& in = s_.inputs[idx(i)];
    if (in.kind == Kind::scalar) ways_.push_back({i, 0, false});
    if (in.kind == Kind::direction) ways_.push_back({i, 2, true});
    if (in.kind != Kind::frame) continue;
    for (int k = 0; k < s_.dimension; ++k) ways_.push_back({i, k, false});
    if (in.count == s_.dimension) continue;
    for (int k = s_.dimension == 3 ? 0 : 2; k < 3; ++k) ways_.push_back({i, k, true});
  }
}

std::vector<double> Freedoms::rates(std::size_t freedom, std::span<const double> q) const {
  std::vector<double> rate(q.size(), 0.0);
  const Way& way = ways_[freedom];
  const DriverInput& in = s_.inputs[idx(way.input)];
  const std::size_t first = idx(in.first);
  if (!way.turns) {
    rate[first + static_cast<std::size_t>(way.axis)] = 1;
  } else {
    // Columns of a frame turn about the axis; in the plane, a cosine and a sine form one column.
    const std::size_t dim = idx(s_.dimension), begin = in.kind == Kind::frame ? first + dim : first;
    const bool plane = in.count <= 4;
    const std::size_t size = plane ? 2 : 3, j = plane ? 0 : idx(static_cast<Index>(way.axis + 1) % 3),
                      k = plane ? 1 : idx(static_cast<Index>(way.axis + 2) % 3);
    for (std::size_t c = begin; c < first + idx(in.count); c += size) {
      rate[c + k] = q[c + j];
      rate[c + j] = -q[c + k];
    }
  }
  for (const Assignment& a : s_.assignments) {
    double sum = 0;
    for (const Term& t : s_.form(a.form)) sum += s_.constants[idx(t.constant)] * rate[idx(t.coordinate)];
    rate[idx(a.coordinate)] = sum;
  }
  return rate;
}

void Freedoms::move(std::span<const double> amounts, std::vector<double>& q) const {
  for (std::size_t f = 0; f < ways_.size(); ++f) {
    const Way& way = ways_[f];
    const DriverInput& in = s_.inputs[idx(way.input)];
    const std::size_t first = idx(in.first);
    if (!way.turns) {
      q[first + static_cast<std::size_t>(way.axis)] += amounts[f];
      continue;
    }
    const double cosine = std::cos(amounts[f]), sine = std::sin(amounts[f]);
    const std::size_t dim = idx(s_.dimension), begin = in.kind == Kind::frame ? first + dim : first;
    const bool plane = in.count <= 4;
    const std::size_t size = plane ? 2 : 3, j = plane ? 0 : idx(static_cast<Index>(way.axis + 1) % 3),
                      k = plane ? 1 : idx(static_cast<Index>(way.axis + 2) % 3);
    for (std::size_t c = begin; c < first + idx(in.count); c += size) {
      const double x = q[c + j], y = q[c + k];
      q[c + j] = cosine * x - sine * y;
      q[c + k] = sine * x + cosine * y;
    }
  }
  for (const Assignment& a : s_.assignments) q[idx(a.coordinate)] = form_value<double>(s_, a.form, q);
}

}  // namespace assur
