#include "motion/limit_watch.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "decimal.hpp"
#include "index.hpp"
#include "numbers.hpp"

namespace assur {
namespace {

// Rounding of a quantity, relative to its bound, and at least to 1 rad or the typical length: a motion may rest at its
// limit.
constexpr double kRounding = 256 * kEps;
// A bow that is smaller than this part of the bound, or of 1 rad or the typical length, hides nothing: the polynomial
// of degree 5 is then closer to the motion by orders of magnitude.
constexpr double kHidden = 0x1p-14;
constexpr double kNarrow = 0x1p-26;  // error of the place of an extremum, relative to the step
constexpr int kMostProbes = 200;     // one of three halves a bracket, so that 156 reach kResolvedTime
constexpr std::size_t kJet = 3;      // columns of one quantity
constexpr std::size_t kMostSamples = std::tuple_size_v<decltype(Quintic::Extrema::at)> + 2;  // of one step

// Halves a polynomial of degree 4 in Bernstein form; `d` becomes its first half.
std::array<double, 5> halve(std::array<double, 5>& d) {
  std::array<double, 5> right{};
  for (std::size_t i = 0; i < 5; ++i) {
    right[4 - i] = d[4];
    for (std::size_t k = 4; k > i; --k) d[k] = (d[k] + d[k - 1]) / 2;
  }
  return right;
}

// A polynomial has at most as many roots in its interval as its Bernstein coefficients change their sign. Zero counts
// as positive, so that a root between two halves belongs to one of them.
void find_roots(std::array<double, 5> d, double begin, double width, Quintic::Extrema& roots) {
  const auto changes = [](double a, double b) { return (a < 0) != (b < 0); };
  if (std::adjacent_find(d.begin(), d.end(), changes) == d.end() || roots.count == roots.at.size()) return;
  if (width <= kNarrow) {
    roots.at[roots.count++] = begin + width / 2;
    return;
  }
  const std::array<double, 5> right = halve(d);
  find_roots(d, begin, width / 2, roots);
  find_roots(right, begin + width / 2, width / 2, roots);
}

}  // namespace

Quintic::Quintic(const Jet<double>& begin, const Jet<double>& end) {
  const double sum = begin.rate + end.rate + begin.acceleration + end.acceleration;
  if (!std::isfinite(sum)) {
    for (std::size_t i = 0; i < c_.size(); ++i) {
      c_[i] = begin.value + static_cast<double>(i) / 5 * (end.value - begin.value);
    }
    return;
  }
  c_[0] = begin.value;
  c_[1] = begin.value + begin.rate / 5;
  c_[2] = begin.value + 2 * begin.rate / 5 + begin.acceleration / 20;
  c_[3] = end.value - 2 * end.rate / 5 + end.acceleration / 20;
  c_[4] = end.value - end.rate / 5;
  c_[5] = end.value;
}

double Quintic::at(double s) const {
  std::array<double, 6> c = c_;
  for (std::size_t last = 5; last > 0; --last) {
    for (std::size_t i = 0; i < last; ++i) c[i] += s * (c[i + 1] - c[i]);
  }
  return c[0];
}

Quintic::Extrema Quintic::extrema() const {
  std::array<double, 5> slope{};
  for (std::size_t i = 0; i < slope.size(); ++i) slope[i] = c_[i + 1] - c_[i];
  Extrema found{};
  find_roots(slope, 0, 1, found);
  return found;
}

std::vector<Index> limited_quantities(const System& system) {
  std::vector<Index> out;
  for (const Bound& b : system.bounds) {
    if (std::find(out.begin(), out.end(), b.measure) == out.end()) out.push_back(b.measure);
  }
  return out;
}

LimitWatch::LimitWatch(const System& system, std::span<const std::int32_t> address)
    : system_(system), outputs_(system, address, limited_outputs(system)), turns_({&outputs_, 1}) {
  const std::vector<Output> outputs = limited_outputs(system);
  for (std::size_t i = 0; i < system.bounds.size(); ++i) {
    const Bound& b = system.bounds[i];
    const auto is_it = [&](const Output& o) { return o.name == measure(i).name; };
    const auto column = static_cast<std::size_t>(std::find_if(outputs.begin(), outputs.end(), is_it) - outputs.begin());
    const double typical = unit_of(measure(i)) == "rad" ? 1 : system.unit(measure(i).dimension);
    const double size = std::max(std::abs(b.value), typical);
    sides_.push_back({kJet * column, b.is_max ? 1.0 : -1.0, kRounding * size, kHidden * size});
  }
  bows_.resize(sides_.size());
  const std::vector<Index> quantities = limited_quantities(system);
  for (const Bound& b : system.bounds) {
    limits_.push_back(
        static_cast<std::int32_t>(std::find(quantities.begin(), quantities.end(), b.measure) - quantities.begin()));
  }
  angles_ = outputs_.angles();
  no_turns_.resize(angles_.size());
  divisors_.resize(outputs_.measures());
  for (auto* row : {&now_, &next_, &probe_}) row->resize(kJet * outputs.size());
  values_.resize(outputs.size());
  found_.reserve(sides_.size() * (kMostSamples - 1));
}

// Reads a row. Angles get the turns that bring them closest to those of the row `near`.
void LimitWatch::read(Posture q, std::vector<double>& row, std::span<const double> near) {
  outputs_.evaluate(q, row.data(), no_turns_.data(), divisors_.data());
  for (std::size_t i = 0; i < angles_.size() && !near.empty(); ++i) {
    row[angles_[i]] += kTurn * whole_turns(row[angles_[i]], near[angles_[i]]);
  }
  outputs_.add_up(row.data());
}

void LimitWatch::start(Posture q, double time, std::span<const double> known) {
  std::vector<double> begin(now_.size());
  read(q, begin, {});
  for (std::size_t i = 0; i < known.size(); ++i) begin[kJet * i] = known[i];
  for (std::size_t i = 0; i < sides_.size() && known.empty(); ++i) {
    double& value = begin[sides_[i].column];
    const Bound& b = system_.bounds[i];
    if (std::find(angles_.begin(), angles_.end(), sides_[i].column) == angles_.end()) continue;
    if (b.input >= 0) {
      const DriverInput& in = system_.inputs[idx(b.input)];
      const double law = in.laws[0](time).value - in.zero;
      if (std::isfinite(law)) value += kTurn * whole_turns(value, law);
      continue;
    }
    // Adds whole turns only if both bounds are less than one turn apart; otherwise the number of turns is ambiguous.
    const double turns = std::ceil(excess(i, value) / kTurn);
    const double moved = value - sides_[i].sign * kTurn * turns;
    const auto is_other = [&](std::size_t k) { return k != i && sides_[k].column == sides_[i].column; };
    bool has_two = false, fits = turns > 0;
    for (std::size_t k = 0; k < sides_.size(); ++k) {
      if (!is_other(k)) continue;
      const double apart = -(excess(i, value) + excess(k, value));
      has_two = true;
      fits = fits && apart < kTurn && excess(k, moved) <= 0;
    }
    if (has_two && fits) value = moved;
  }
  read(q, next_, begin);
  next_time_ = time;
  accept();
}

std::vector<std::size_t> LimitWatch::violated() const {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < sides_.size(); ++i) {
    if (!(excess(i, now_[sides_[i].column]) <= 0)) found.push_back(i);
  }
  return found;
}

Quintic LimitWatch::way(std::size_t bound) const {
  const double h = next_time_ - now_time_;
  const auto jet = [&](const std::vector<double>& row) {
    const double* const at = row.data() + sides_[bound].column;
    return Jet<double>{at[0], h * at[1], h * h * at[2]};
  };
  return {jet(now_), jet(next_)};
}

bool LimitWatch::may_change(Posture q, double time) {
  read(q, next_, now_);
  next_time_ = time;
  for (std::size_t i = 0; i < sides_.size(); ++i) {
    const Quintic way_of_it = way(i);
    const auto c = way_of_it.coefficients();
    const bool is_outside = excess(i, c[0]) > 0;
    if (std::any_of(c.begin(), c.end(), [&](double x) { return (excess(i, x) > 0) != is_outside; })) return true;
  }
  return false;
}

void LimitWatch::measure(Posture q, std::span<double* const> probes, const double* resting, std::size_t lane) {
  std::fill(bows_.begin(), bows_.end(), 0.0);
  for (const double* const probe : probes) {
    outputs_.differentiate(q, {probe + lane, resting + lane, resting + lane}, nullptr, probe_.data());
    for (std::size_t i = 0; i < sides_.size(); ++i) {
      const double slope = std::abs(probe_[sides_[i].column]);
      if (std::isfinite(slope)) bows_[i] += slope;  // a quantity at a kink is judged by its polynomial alone
    }
  }
}

bool LimitWatch::hides_change(double times) const {
  for (std::size_t i = 0; i < sides_.size(); ++i) {
    const double bow = times * bows_[i];
    if (!(bow > sides_[i].hidden)) continue;
    const Quintic polynomial = way(i);
    const auto c = polynomial.coefficients();
    const auto [least, most] = std::minmax_element(c.begin(), c.end());
    const double one = excess(i, *least), other = excess(i, *most);
    if (std::max(one, other) > -bow && std::min(one, other) <= bow) return true;
  }
  return false;
}

std::span<const LimitWatch::Change> LimitWatch::changes(const std::function<const double*(double)>& solve) {
  const double h = next_time_ - now_time_;
  found_.clear();
  for (std::size_t i = 0; i < sides_.size(); ++i) {
    const std::size_t column = sides_[i].column;
    const Quintic polynomial = way(i);
    const Quintic::Extrema extrema = polynomial.extrema();
    struct Sample {
      double time, excess;
    };
    std::array<Sample, kMostSamples> at{};
    at[0] = {now_time_, excess(i, now_[column])};
    for (std::size_t k = 0; k < extrema.count; ++k) {
      at[k + 1] = {now_time_ + h * extrema.at[k], excess(i, polynomial.at(extrema.at[k]))};
    }
    at[extrema.count + 1] = {next_time_, excess(i, next_[column])};
    const std::span<Sample> samples = std::span(at).first(extrema.count + 2);
    const auto changes = [](const Sample& a, const Sample& b) { return (a.excess > 0) != (b.excess > 0); };
    if (std::adjacent_find(samples.begin(), samples.end(), changes) == samples.end()) continue;
    // The polynomial is monotonic between the samples; the postures decide where it turns back.
    for (std::size_t k = 1; k + 1 < samples.size(); ++k) {
      if (!changes(samples[k - 1], samples[k]) && !changes(samples[k], samples[k + 1])) continue;
      const double* const q = solve(samples[k].time);
      if (q == nullptr) continue;
      read({q, q, q}, probe_, next_);
      samples[k].excess = excess(i, probe_[column]);
    }
    for (std::size_t k = 0; k + 1 < samples.size(); ++k) {
      if (!changes(samples[k], samples[k + 1])) continue;
      bracket(i, samples[k].time, samples[k].excess, samples[k + 1].time, samples[k + 1].excess, solve);
    }
  }
  const double sign = h < 0 ? -1 : 1;
  const auto is_earlier = [&](const Change& a, const Change& b) { return sign * a.from < sign * b.from; };
  for (auto c = found_.begin(); c != found_.end(); ++c) {  // std::stable_sort allocates
    std::rotate(std::upper_bound(found_.begin(), c, *c, is_earlier), c, c + 1);
  }
  const auto end = std::find_if(found_.begin(), found_.end(), [&](const Change& c) { return ends(c); });
  if (end != found_.end()) found_.erase(end + 1, found_.end());
  return found_;
}

// Regula falsi that halves the weight of an end that stays twice (Illinois); bisection if the bracket shrinks too
// slowly. Each probe keeps half the final width away from both ends, so that the bracket closes from both sides.
void LimitWatch::bracket(std::size_t bound, double from, double excess_from, double until, double excess_until,
                         const std::function<const double*(double)>& solve) {
  const bool leaves = excess_until > 0;
  // A change needs an excess of more than rounding; it happens where the bound itself is passed.
  const double rounding = sides_[bound].rounding;
  excess_from += rounding;
  excess_until += rounding;
  if ((excess_from > 0) == (excess_until > 0)) {
    const double at = leaves ? from : until;
    return found_.push_back({bound, leaves, at, at});
  }
  const double width = kResolvedTime * std::max(std::abs(from), std::abs(until));
  double weight_from = excess_from, weight_until = excess_until;
  double wide = std::abs(until - from);
  int stays = 0;  // 1: `until` stayed at the last probe, -1: `from`
  for (int probes = 0; std::abs(until - from) > width && probes < kMostProbes; ++probes) {
    const double way = until - from;
    double part = weight_from / (weight_from - weight_until);
    if (probes % 3 == 2) {
      if (std::abs(way) > wide / 2) part = 0.5;
      wide = std::abs(way);
    }
    const double margin = std::min(width / 2 / std::abs(way), 0.5);
    const double t = from + way * std::clamp(part, margin, 1 - margin);
    const double* const q = t == from || t == until ? nullptr : solve(t);
    if (q == nullptr) break;
    read({q, q, q}, probe_, next_);
    const double here = excess(bound, probe_[sides_[bound].column]) + rounding;
    if ((here > 0) == leaves) {
      until = t;
      weight_until = here;
      if (std::exchange(stays, -1) == -1) weight_from /= 2;
    } else {
      from = t;
      weight_from = here;
      if (std::exchange(stays, 1) == 1) weight_until /= 2;
    }
  }
  found_.push_back({bound, leaves, from, until});
}

void LimitWatch::accept() {
  std::swap(now_, next_);
  now_time_ = next_time_;
  for (std::size_t i = 0; i < values_.size(); ++i) values_[i] = now_[kJet * i];
}

Event LimitWatch::event(const Change& change) const {
  const Bound& b = system_.bounds[change.bound];
  const std::string unit = unit_of(measure(change.bound));
  return {change.from,
          change.until,
          measure(change.bound).name,
          kind(change),
          b.value,
          std::string(b.is_max ? "the largest" : "the smallest") + " allowed value is " + general(b.value, 10) +
              (unit == "1" ? "" : " " + unit),
          unit};
}

std::string LimitWatch::describe(std::size_t bound) const {
  const Bound& b = system_.bounds[bound];
  const std::string unit = unit_of(measure(bound)) == "1" ? "" : " " + unit_of(measure(bound));
  return measure(bound).name + " is " + general(now_[sides_[bound].column], 10) + unit + ", " +
         (b.is_max ? "above its largest" : "below its smallest") + " allowed value " + general(b.value, 10) + unit;
}

}  // namespace assur
