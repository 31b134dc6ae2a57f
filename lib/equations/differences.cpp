#include "equations/differences.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "decimal.hpp"
#include "equations/outputs.hpp"
#include "joints/gear.hpp"
#include "numbers.hpp"

namespace assur {
namespace {

// Distances over which differences are taken: in internal units for callbacks, relative to the time step for laws.
constexpr double kLongestOffset = 0x1p-8;
constexpr double kShortestOffset = 0x1p-30;
constexpr double kGlance = 0x1p-16;    // the one distance of a cheap check
constexpr double kLawGlance = 0x1p-9;  // the same, relative to the time step
constexpr double kLawLongest = 0x1p-2;
constexpr double kSpan = 100;            // time steps in which a motion is expected to change
constexpr double kRoundingSteps = 1024;  // every distance is at least this many roundings of the argument

constexpr double kSureUncertainties = 4;  // a derivative is wrong if its error exceeds this many uncertainties
constexpr double kBlind = 0.1;            // part of the difference: a level with more uncertainty cannot decide
// of the change at the longest distance: larger roughness means that the function has no slope
constexpr double kCalm = 0.01;
constexpr double kRounded = 16;     // roundings: smaller differences are not roughness
constexpr double kConfirms = 0.25;  // part of the difference: a level closer to the given derivative confirms it
constexpr double kFloor = 0.1;      // part of the tolerance that applies relative to the largest other derivative
constexpr double kDoubt = 0.05;     // part of the tolerance: a larger difference in a cheap check asks for a closer one
constexpr double kAskedAgain = 0.1;  // part of the tolerance: largest difference of two results for the same arguments

// Calls a function of the program at arguments where it may be undefined; an exception gives NaN.
template <class F>
void call(F&& f, double* values, std::size_t count) {
  try {
    f();
  } catch (...) {
    std::fill_n(values, count, kNan);
  }
}

// The value of the last bit that is set; infinite if none is.
double last_bit(double f) {
  if (f == 0 || !std::isfinite(f)) return kInfinity;
  int exponent = 0;
  const auto bits = static_cast<std::uint64_t>(std::ldexp(std::frexp(std::abs(f), &exponent), 53));
  return std::ldexp(1.0, exponent - 53 + std::countr_zero(bits));
}

std::string text(double x) { return general(x, 10); }

}  // namespace

Differences::Differences(std::size_t rows)
    : rows_(rows),
      slope_(kLevels * rows),
      second_(kLevels * rows),
      size_(rows),
      quantum_(rows),
      least_change_(rows),
      still_(rows),
      middle_(rows),
      before_(rows),
      after_(rows) {}

void Differences::add_level(double h) {
  if (levels_ == 0) {
    std::fill(size_.begin(), size_.end(), 0.0);
    std::fill(quantum_.begin(), quantum_.end(), kInfinity);
    std::fill(least_change_.begin(), least_change_.end(), kInfinity);
    std::fill(still_.begin(), still_.end(), std::uint8_t{0});
  }
  distance_[levels_] = h;
  for (std::size_t i = 0; i < rows_; ++i) {
    const double a = before_[i], b = after_[i];
    slope_[levels_ * rows_ + i] = (b - a) / (2 * h);
    second_[levels_ * rows_ + i] = (b - middle_[i]) - (middle_[i] - a);
    for (const double f : {a, b}) {
      if (!std::isfinite(f)) continue;
      size_[i] = std::max(size_[i], std::abs(f));
      const double change = std::abs(f - middle_[i]);
      quantum_[i] = std::min(quantum_[i], last_bit(change));
      if (change > 0) least_change_[i] = std::min(least_change_[i], change);
      if (change == 0) still_[i] = 1;
    }
  }
  ++levels_;
}

// The error of a central difference has two parts. The error of the expansion falls with the square of the distance;
// the step from the level before shows it. Noise grows as the distance falls. It shows in the step to the next level,
// in the steps of the values (a function may compute in float), and in the second differences of this and all nearer
// levels, except for the part of a curve, which falls to a sixteenth from level to level. Kinks show there as well.
//
// A function that is rough at some distances may seem exact at others. So no contradiction is reported if the roughness
// is not small beside the changes at the longest distance, or if another level is more certain than a tenth of the
// difference and agrees with the given derivative within a quarter of it.
Differences::Verdict Differences::judge(std::size_t row, double given, double tolerance, double floor,
                                        double noise) const {
  Verdict out;
  double uncertainty[kLevels];
  std::fill_n(uncertainty, kLevels, kInfinity);
  noise += 4 * kEps * size_[row];
  double steps = std::isfinite(quantum_[row]) ? quantum_[row] : 0;
  if (still_[row] != 0 && std::isfinite(least_change_[row])) steps = std::max(steps, least_change_[row]);
  std::size_t best = kLevels;
  double rough = 0, rough_at_best = 0;
  for (std::size_t k = levels_; k-- > 1;) {
    const double bent = second_[(k - 1) * rows_ + row] / (kRatio * kRatio);
    if (const double left = std::abs(second_[k * rows_ + row] - bent); left > rough) rough = left;
    if (k + 2 >= levels_) continue;
    const double here = slope(k, row);
    const double u = std::abs(here - slope(k - 1, row)) + std::abs(slope(k + 1, row) - here) +
                     (2 * rough + noise + steps) / distance_[k];
    if (!std::isfinite(u)) continue;
    uncertainty[k] = u;
    if (best == kLevels || u < uncertainty[best]) {
      best = k;
      rough_at_best = rough;
    }
  }
  if (best == kLevels) return out;
  out.found = slope(best, row);
  out.uncertainty = uncertainty[best];
  const double gap = std::abs(given - out.found);
  const double tolerated = tolerance * std::max(std::abs(given), std::abs(out.found)) + floor;
  if (std::isfinite(gap)) {
    if (rough_at_best > kCalm * std::abs(out.found) * distance_[0] + kRounded * noise) return out;
    if (gap <= kSureUncertainties * out.uncertainty + tolerated) return out;
    for (std::size_t k = 0; k < levels_; ++k) {
      if (uncertainty[k] <= kBlind * gap && std::abs(given - slope(k, row)) <= kConfirms * gap) return out;
    }
  }
  out.contradicted = true;
  out.excess = std::isfinite(gap) && tolerated > 0 ? gap / tolerated : kInfinity;
  return out;
}

// ---- callbacks

CallbackCheck::CallbackCheck(const CallbackBlock& block)
    : x(block.coordinates.size()),
      rate(block.coordinates.size()),
      moves(block.coordinates.size(), 1),
      block_(block),
      m_(block.coordinates.size()),
      r_(static_cast<std::size_t>(block.callback->equations)),
      differences_(r_),
      given_(r_ * m_),
      other_(r_ * m_),
      moved_(m_),
      direction_(m_),
      before_(r_),
      after_(r_),
      curvature_(r_) {}

void CallbackCheck::residual(const std::vector<double>& at, double* phi) const {
  call([&] { block_.callback->residual(at, {phi, r_}); }, phi, r_);
}

void CallbackCheck::jacobian(const std::vector<double>& at, double* j) const {
  call([&] { block_.callback->jacobian(at, {j, r_ * m_}); }, j, r_ * m_);
}

double CallbackCheck::largest_entry(std::size_t row) const {
  double largest = 0;
  for (std::size_t j = 0; j < m_; ++j) largest = std::max(largest, std::abs(given_[row * m_ + j]) * block_.unit[j]);
  return largest;
}

// Rounding of a residual by the rounding of its arguments.
double CallbackCheck::rounding(std::size_t row) const {
  double largest = 0;
  for (std::size_t j = 0; j < m_; ++j) largest = std::max(largest, std::abs(given_[row * m_ + j] * x[j]));
  return kEps * largest;
}

// The shortest useful distance, in internal units.
double CallbackCheck::shortest() const {
  double farthest = 0;
  for (std::size_t j = 0; j < m_; ++j) farthest = std::max(farthest, std::abs(x[j]) / block_.unit[j]);
  return std::max(kShortestOffset, kRoundingSteps * kEps * farthest);
}

// Time in which the fastest argument moves by one internal unit; infinite at rest.
double CallbackCheck::time_to_move() const {
  double fastest = 0;
  for (std::size_t j = 0; j < m_; ++j) fastest = std::max(fastest, std::abs(rate[j]) / block_.unit[j]);
  return 1 / fastest;
}

bool CallbackCheck::doubtful(bool curvature, std::uint64_t seed) {
  if (!(tolerance() < kInfinity)) return false;
  jacobian(x, given_.data());
  return doubtful_jacobian(seed) || (curvature && doubtful_curvature());
}

bool CallbackCheck::doubtful_jacobian(std::uint64_t seed) {
  const double h = std::max(kGlance, shortest());
  for (std::size_t j = 0; j < m_; ++j) {
    seed = seed * 6364136223846793005 + 1442695040888963407;  // Knuth's MMIX
    direction_[j] = moves[j] == 0 ? 0 : (seed >> 63) != 0 ? -block_.unit[j] : block_.unit[j];
  }
  for (const double side : {-h, h}) {
    for (std::size_t j = 0; j < m_; ++j) moved_[j] = x[j] + side * direction_[j];
    residual(moved_, side < 0 ? before_.data() : after_.data());
  }
  for (std::size_t i = 0; i < r_; ++i) {
    const double found = (after_[i] - before_[i]) / (2 * h);
    if (!std::isfinite(found)) continue;
    const double floor = kFloor * largest_entry(i);
    double given = 0, tolerated = 0, rounded = 2 * kEps * (std::abs(after_[i]) + std::abs(before_[i]));
    for (std::size_t j = 0; j < m_; ++j) {
      const double entry = given_[i * m_ + j];
      given += entry * direction_[j];
      tolerated += tolerance() * (std::abs(entry) * block_.unit[j] + floor);
      rounded += kEps * std::abs(entry * x[j]);
    }
    if (!(std::abs(found - given) <= kDoubt * tolerated + rounded / h)) return true;
  }
  return false;
}

// out: J(at) q'.
void CallbackCheck::turn(const std::vector<double>& at, double* out) {
  jacobian(at, other_.data());
  for (std::size_t i = 0; i < r_; ++i) {
    out[i] = 0;
    for (std::size_t j = 0; j < m_; ++j) out[i] += other_[i * m_ + j] * rate[j];
  }
}

bool CallbackCheck::doubtful_curvature() {
  const double time = time_to_move();
  if (!std::isfinite(time)) return false;
  call([&] { block_.callback->curvature(x, rate, curvature_); }, curvature_.data(), r_);
  const double h = std::max(kGlance, shortest());
  for (const double side : {-h, h}) {
    for (std::size_t j = 0; j < m_; ++j) moved_[j] = x[j] + side * time * rate[j];
    turn(moved_, side < 0 ? before_.data() : after_.data());
  }
  for (std::size_t i = 0; i < r_; ++i) {
    const double found = (after_[i] - before_[i]) / (2 * h), given = time * curvature_[i];
    if (!std::isfinite(found)) continue;
    double floor = 0;
    for (std::size_t j = 0; j < m_; ++j) floor = std::max(floor, std::abs(given_[i * m_ + j] * rate[j]));
    const double tolerated = tolerance() * (std::max(std::abs(found), std::abs(given)) + kFloor * floor);
    if (!(std::abs(found - given) <= kDoubt * tolerated + 4 * kEps * floor / h)) return true;
  }
  return false;
}

std::optional<Contradiction> CallbackCheck::find(bool curvature) {
  std::optional<Contradiction> worst;
  if (!(tolerance() < kInfinity)) return worst;
  find_in_jacobian(worst);
  if (curvature && !worst) find_in_curvature(worst);
  return worst;
}

void CallbackCheck::find_in_jacobian(std::optional<Contradiction>& worst) {
  jacobian(x, given_.data());
  const auto worse = [&](const Contradiction& found) {
    if (!worst || found.excess > worst->excess) worst = found;
  };
  residual(x, before_.data());
  residual(x, after_.data());
  for (std::size_t i = 0; i < r_; ++i) {
    const double size = std::max({std::abs(before_[i]), std::abs(after_[i]), rounding(i) / kEps, largest_entry(i)});
    const double off = std::abs(before_[i] - after_[i]);
    const double excess = std::isfinite(off) ? off / (kAskedAgain * tolerance() * size) : kInfinity;
    if (excess > 1) worse({Contradiction::Of::value, static_cast<Index>(i), 0, 0, before_[i], after_[i], 0, excess});
  }
  const double nearest = shortest();
  for (std::size_t j = 0; j < m_; ++j) {
    if (moves[j] == 0) continue;
    const double unit = block_.unit[j];
    moved_ = x;
    differences_.measure(kLongestOffset * unit,
                         std::max(kShortestOffset * unit, std::min(nearest * unit, kLongestOffset * unit)),
                         [&](double h, double* phi) {
                           moved_[j] = x[j] + h;
                           residual(moved_, phi);
                         });
    for (std::size_t i = 0; i < r_; ++i) {
      const double given = given_[i * m_ + j];
      const Differences::Verdict v =
          differences_.judge(i, given, tolerance(), tolerance() * kFloor * largest_entry(i) / unit, rounding(i));
      if (!v.contradicted) continue;
      worse({Contradiction::Of::jacobian, static_cast<Index>(i), static_cast<Index>(j), 0, given, v.found,
             v.uncertainty, v.excess});
    }
  }
}

// At rest the curvature is zero.
void CallbackCheck::find_in_curvature(std::optional<Contradiction>& worst) {
  const double time = time_to_move();
  if (!std::isfinite(time)) return;
  call([&] { block_.callback->curvature(x, rate, curvature_); }, curvature_.data(), r_);
  differences_.measure(kLongestOffset, shortest(), [&](double h, double* out) {
    for (std::size_t j = 0; j < m_; ++j) moved_[j] = x[j] + h * time * rate[j];
    turn(moved_, out);
  });
  for (std::size_t i = 0; i < r_; ++i) {
    double largest = 0;
    for (std::size_t j = 0; j < m_; ++j) largest = std::max(largest, std::abs(given_[i * m_ + j] * rate[j]));
    const Differences::Verdict v =
        differences_.judge(i, time * curvature_[i], tolerance(), tolerance() * kFloor * largest, kEps * largest);
    if (!v.contradicted || (worst && v.excess <= worst->excess)) continue;
    worst = Contradiction{Contradiction::Of::curvature,
                          static_cast<Index>(i),
                          0,
                          0,
                          curvature_[i],
                          v.found / time,
                          v.uncertainty / time,
                          v.excess};
  }
}

// ---- laws

namespace {

Motion ask(const Law::Function& law, double t) {
  Motion m;
  double undefined = 0;
  call([&] { m = law.motion(t); }, &undefined, 1);
  return undefined == 0 ? m : Motion{kNan, kNan, kNan};
}

// Errors of the value, its rate and its acceleration that are too small to matter.
Motion floor_of(const Law::Function& law, const Motion& m, double unit, double span) {
  const double of = kFloor * law.tolerance, size = std::abs(m.value) + unit;
  return {of * size, of * size / span, of * (std::abs(m.rate) + size / span) / span};
}

// A time that no grid contains.
double between(double from, double to) {
  constexpr double kGolden = 0.3819660112501051;
  return from + kGolden * (to - from);
}

}  // namespace

bool LawCheck::doubtful(const Law::Function& law, double from, double to, double unit, int derivatives) {
  if (!(law.tolerance < kInfinity)) return false;
  const double t = between(from, to), h = kLawGlance * std::abs(to - from);
  const double spacing = kEps * std::max(std::abs(from), std::abs(to));
  if (!(h > kRoundingSteps * spacing)) return false;
  const Motion m = ask(law, t), after = ask(law, t + h), before = ask(law, t - h), again = ask(law, t);
  const Motion floor = floor_of(law, m, unit, kSpan * std::abs(to - from));
  if (std::abs(again.value - m.value) > floor.value) return true;
  const auto far = [&](double given, double a, double b, double least) {
    const double found = (b - a) / (2 * h);
    if (!std::isfinite(found)) return false;
    const double tolerated = law.tolerance * std::abs(given) + least;
    const double noise = 2 * kEps * (std::abs(a) + std::abs(b)) + spacing * std::abs(given);
    return !(std::abs(found - given) <= kDoubt * tolerated + noise / h);
  };
  return (derivatives > 0 && far(m.rate, before.value, after.value, floor.rate)) ||
         (derivatives > 1 && far(m.acceleration, before.rate, after.rate, floor.acceleration));
}

std::optional<Contradiction> LawCheck::find(const Law::Function& law, double from, double to, double unit,
                                            int derivatives) {
  if (!(law.tolerance < kInfinity)) return std::nullopt;
  const double t = between(from, to);
  const double spacing = kEps * std::max(std::abs(from), std::abs(to));
  const Motion m = ask(law, t), again = ask(law, t);
  const Motion floor = floor_of(law, m, unit, kSpan * std::abs(to - from));
  if (const double off = std::abs(again.value - m.value); off > floor.value) {
    return Contradiction{Contradiction::Of::value, 0, 0, t, m.value, again.value, 0, off / floor.value};
  }
  const double longest = kLawLongest * std::abs(to - from);
  differences_.measure(longest, std::max(kShortestOffset * longest, kRoundingSteps * spacing),
                       [&](double h, double* out) {
                         const Motion at = ask(law, t + h);
                         out[0] = at.value;
                         out[1] = at.rate;
                       });
  std::optional<Contradiction> worst;
  const auto judge = [&](Contradiction::Of of, std::size_t row, double given, double least) {
    const Differences::Verdict v = differences_.judge(row, given, law.tolerance, least, spacing * std::abs(given));
    if (v.contradicted && !worst) worst = Contradiction{of, 0, 0, t, given, v.found, v.uncertainty, v.excess};
  };
  if (derivatives > 0) judge(Contradiction::Of::rate, 0, m.rate, floor.rate);
  if (derivatives > 1) judge(Contradiction::Of::acceleration, 1, m.acceleration, floor.acceleration);
  return worst;
}

// ---- findings as text

CallbackCheck check_of(const System& s, const CallbackBlock& block) {
  CallbackCheck check(block);
  for (std::size_t j = 0; j < block.coordinates.size(); ++j) {
    const auto terms = s.form(block.coordinates[j]);
    check.moves[j] = std::any_of(terms.begin(), terms.end(), [&](const Term& t) {
      const Coordinate& c = s.coordinates[static_cast<std::size_t>(t.coordinate)];
      return c.role == Role::unknown || (c.role == Role::driven && c.moving);
    });
  }
  return check;
}

double law_unit(const System& s, const DriverInput& input, std::size_t k) {
  const bool angle = input.kind == DriverInput::Kind::direction ||
                     (input.kind == DriverInput::Kind::frame && k >= static_cast<std::size_t>(s.dimension));
  return angle ? 1 : s.unit(input.dimension);
}

int wanted_derivatives(const System& s) {
  int most = s.bounds.empty() ? 0 : 2;
  for (const Output& o : wanted_outputs(s)) most = std::max(most, o.derivatives());
  return most;
}

std::string describe(const Contradiction& c, const Callback* callback) {
  const auto says = [&](const std::string& what, const std::string& of) {
    return what + " is " + text(c.given) + ", but differences of the " + of + " give " + text(c.found) + " (within " +
           general(c.uncertainty, 1) + ")";
  };
  const std::string row = "row " + std::to_string(c.row), time = " at t = " + text(c.time) + " s";
  switch (c.of) {
    case Contradiction::Of::jacobian:
      return says("jacobian[" + row + ", " + callback->coordinates[static_cast<std::size_t>(c.argument)] + "]",
                  "residual");
    case Contradiction::Of::curvature:
      return says("curvature[" + row + "]", "Jacobian");
    case Contradiction::Of::rate:
      return says("the rate" + time, "value");
    case Contradiction::Of::acceleration:
      return says("the acceleration" + time, "rate");
    case Contradiction::Of::value:
      break;
  }
  return (callback != nullptr ? "residual[" + row + "]" : "the value" + time) + " is " + text(c.given) +
         (std::isfinite(c.given) ? ", but " + text(c.found) + " when it is called again" : "");
}

std::vector<Diagnostic> contradictions(const System& s, const std::vector<double>& q, double from, double to) {
  constexpr const char* kInstead = "; correct it, or state a larger `tolerance` if this is intended";
  std::vector<Diagnostic> out;
  for (const CallbackBlock& block : s.callbacks) {
    CallbackCheck check = check_of(s, block);
    for (std::size_t j = 0; j < check.x.size(); ++j) {
      check.x[j] = form_value<double>(s, block.coordinates[j], q) * block.unit[j];
    }
    const std::optional<Contradiction> found = check.find(false);
    const bool is_out_of_mesh = found && !std::isfinite(found->given) && numbers_of(*block.callback);  // not an error
    if (found && !is_out_of_mesh)
      out.push_back(
          {"/constraints/" + s.equation_name(block.first_equation), describe(*found, block.callback) + kInstead});
  }
  LawCheck check;
  const int derivatives = wanted_derivatives(s);
  for_each_function(s, [&](std::size_t i, std::size_t k, const Law::Function& law) {
    const auto found = check.find(law, from, to, law_unit(s, s.inputs[i], k), derivatives);
    if (found) {
      out.push_back({"/drivers/" + s.drivers[static_cast<std::size_t>(s.inputs[i].driver)] + "/law",
                     describe(*found, nullptr) + kInstead});
    }
  });
  return out;
}

}  // namespace assur
