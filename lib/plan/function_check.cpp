#include "plan/function_check.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "decimal.hpp"
#include "equations/outputs.hpp"
#include "joints/gear.hpp"
#include "numbers.hpp"

namespace assur {
namespace {

constexpr int kLevels = 20;               // distances, each half of the one before; a choice: down to 2^-28
constexpr double kLongest = 0x1p-8;       // relative to the unit of an argument; a choice
constexpr double kLongestOfLaw = 0x1p-2;  // relative to a step: less than kBetween, so that it stays in the step
// Every distance is at least this many roundings of the argument, so that they change slopes by 1e-3 at most.
constexpr double kRoundingSteps = 1024;
// A derivative is wrong if its error exceeds this many uncertainties. Of 10,000 right ones in function_check_test.cpp,
// 1 would accuse five, and 4 accuses none.
constexpr double kSure = 4;
constexpr double kFloor = 0.1;             // see kDerivativeTolerance
constexpr double kSpanOfSteps = 100;       // likewise: time steps
constexpr std::int64_t kStepsToCheck = 8;  // of the time grid; a choice
constexpr double kBetween = 0.381966;      // part of a step: 2 minus the golden ratio, a time that no grid contains

struct Slope {
  double value = kNan, uncertainty = kInfinity;
};

// The value of the last bit that is set; infinite if none is.
double last_bit(double x) {
  if (x == 0 || !std::isfinite(x)) return kInfinity;
  int exponent = 0;
  const auto bits = static_cast<std::uint64_t>(std::ldexp(std::frexp(std::abs(x), &exponent), 53));
  return std::ldexp(1.0, exponent - 53 + std::countr_zero(bits));
}

// Slopes of `rows` functions of one variable. at(h, values): all rows at a signed distance h; NaN: not defined there.
//
// Central differences at five neighbouring distances give four extrapolations (Richardson), whose range is the
// uncertainty, together with the second difference of the middle distance: it falls with the distance, unless there is
// a kink or noise. A function that computes in float shows it by the last bits of its changes. The most certain four
// are taken.
template <class At>
std::vector<Slope> slopes(std::size_t rows, double longest, double shortest, const At& at) {
  std::vector<double> middle(rows), before(rows), after(rows);
  std::vector<double> slope(kLevels * rows, kNan), bend(kLevels * rows, kNan);
  std::vector<double> last_bits(rows, kInfinity);
  at(0.0, middle.data());
  int levels = 0;
  for (double h = longest; h >= shortest && levels < kLevels; h /= 2, ++levels) {
    at(h, after.data());
    at(-h, before.data());
    for (std::size_t i = 0; i < rows; ++i) {
      const std::size_t k = i * kLevels + static_cast<std::size_t>(levels);
      slope[k] = (after[i] - before[i]) / (2 * h);
      bend[k] = std::abs((after[i] - middle[i]) - (middle[i] - before[i])) / (2 * h);
      for (const double change : {after[i] - middle[i], before[i] - middle[i]})
        last_bits[i] = std::min(last_bits[i], last_bit(change));
    }
  }
  std::vector<Slope> out(rows);
  for (std::size_t i = 0; i < rows; ++i) {
    const double *const s = slope.data() + i * kLevels, *const b = bend.data() + i * kLevels;
    double h = longest;
    for (int k = 0; k + 5 <= levels; ++k, h /= 2) {
      double least = kInfinity, most = -kInfinity;
      for (int l = k; l < k + 4; ++l) {
        const double extrapolated = (4 * s[l + 1] - s[l]) / 3;
        if (std::isnan(extrapolated)) least = -kInfinity;
        least = std::min(least, extrapolated);
        most = std::max(most, extrapolated);
      }
      const double uncertainty = most - least + b[k + 2] + (last_bits[i] < kInfinity ? last_bits[i] / h : 0);
      if (uncertainty < out[i].uncertainty) out[i] = {(least + most) / 2, uncertainty};
    }
  }
  return out;
}

// How far a given derivative is wrong, relative to what is tolerated: at least 1. Empty: it is not.
std::optional<double> excess(double given, const Slope& found, double tolerance, double floor) {
  if (!(found.uncertainty < kInfinity)) return {};
  const double gap = std::abs(given - found.value);
  const double tolerated = tolerance * std::max(std::abs(given), std::abs(found.value)) + floor;
  if (gap <= kSure * found.uncertainty + tolerated) return {};
  return std::isfinite(gap) && tolerated > 0 ? gap / tolerated : kInfinity;
}

std::string text(double x) { return general(x, 10); }

// "jacobian[row 0, P.x] is 2.002, but differences of the residual give 2 (within 1e-9)"
std::string says(const std::string& what, double given, const std::string& of, const Slope& found) {
  return what + " is " + text(given) + ", but differences of the " + of + " give " + text(found.value) + " (within " +
         general(found.uncertainty, 1) + ")";
}
std::string says_again(const std::string& what, double first, double again) {
  return what + " is " + text(first) +
         (std::isfinite(first) ? ", but " + text(again) + " when it is called again" : std::string());
}

// Calls a function of the program at arguments where it may be undefined; an exception gives NaN.
template <class F>
void call(const F& f, double* values, std::size_t count) {
  try {
    f();
  } catch (...) {
    std::fill_n(values, count, kNan);
  }
}

// Checks one callback at a posture.
class FunctionCheck {
 public:
  // moves: 0 for an argument that is constant, whose derivatives are not used
  FunctionCheck(const Callback& of, std::vector<double> at, std::vector<double> units,
                const std::vector<std::uint8_t>& moves)
      : of_(of),
        m_(at.size()),
        r_(static_cast<std::size_t>(of.equations)),
        x_(std::move(at)),
        units_(std::move(units)),
        moves_(moves),
        given_(r_ * m_) {
    call([&] { of_.jacobian(x_, given_); }, given_.data(), given_.size());
  }

  // The largest error; "" if there is none.
  [[nodiscard]] std::string find(bool curvature) {
    if (!(of_.tolerance < kInfinity)) return "";
    check_residual();
    for (std::size_t j = 0; j < m_; ++j) {
      if (moves_[j] != 0) check_column(j);
    }
    if (curvature && of_.curvature && worst_.empty()) check_curvature();
    return worst_;
  }

 private:
  void residual(const std::vector<double>& at, double* phi) const {
    call([&] { of_.residual(at, {phi, r_}); }, phi, r_);
  }
  [[nodiscard]] double largest_entry(std::size_t row) const {
    double largest = 0;
    for (std::size_t j = 0; j < m_; ++j) largest = std::max(largest, std::abs(given_[row * m_ + j]) * units_[j]);
    return largest;
  }
  // In units of the argument.
  [[nodiscard]] double shortest(std::size_t j) const { return kRoundingSteps * kEps * std::abs(x_[j]) / units_[j]; }
  void add(std::optional<double> by, const auto& say) {
    if (!by || *by <= worst_by_) return;
    worst_by_ = *by;
    worst_ = say();
  }

  void check_residual() {
    std::vector<double> first(r_), again(r_);
    residual(x_, first.data());
    residual(x_, again.data());
    for (std::size_t i = 0; i < r_; ++i) {
      const double size = std::max({std::abs(first[i]), std::abs(again[i]), largest_entry(i)});
      const double off = std::abs(first[i] - again[i]), tolerated = kFloor * of_.tolerance * size;
      if (off <= tolerated) continue;
      add(std::isfinite(off) ? off / tolerated : kInfinity,
          [&] { return says_again("residual[row " + std::to_string(i) + "]", first[i], again[i]); });
    }
  }

  void check_column(std::size_t j) {
    std::vector<double> moved = x_;
    const double unit = units_[j];
    const auto found = slopes(r_, kLongest * unit, shortest(j) * unit, [&](double h, double* phi) {
      moved[j] = x_[j] + h;
      residual(moved, phi);
    });
    for (std::size_t i = 0; i < r_; ++i) {
      const double given = given_[i * m_ + j];
      add(excess(given, found[i], of_.tolerance, kFloor * of_.tolerance * largest_entry(i) / unit), [&] {
        return says("jacobian[row " + std::to_string(i) + ", " + of_.coordinates[j] + "]", given, "residual", found[i]);
      });
    }
  }

  // Along one direction that mixes all arguments.
  void check_curvature() {
    std::vector<double> rate(m_), moved = x_, j(given_.size()), given(r_);
    double least = 0;
    for (std::size_t k = 0; k < m_; ++k) {
      rate[k] = moves_[k] == 0 ? 0 : units_[k] * std::cos(1.0 + 2 * static_cast<double>(k));
      least = std::max(least, shortest(k));
    }
    call([&] { of_.curvature(x_, rate, given); }, given.data(), r_);
    const auto found = slopes(r_, kLongest, least, [&](double h, double* out) {
      for (std::size_t k = 0; k < m_; ++k) moved[k] = x_[k] + h * rate[k];
      call([&] { of_.jacobian(moved, j); }, j.data(), j.size());
      for (std::size_t i = 0; i < r_; ++i) {
        out[i] = 0;
        for (std::size_t k = 0; k < m_; ++k) out[i] += j[i * m_ + k] * rate[k];
      }
    });
    for (std::size_t i = 0; i < r_; ++i) {
      add(excess(given[i], found[i], of_.tolerance, kFloor * of_.tolerance * largest_entry(i)),
          [&] { return says("curvature[row " + std::to_string(i) + "]", given[i], "Jacobian", found[i]); });
    }
  }

  const Callback& of_;
  std::size_t m_, r_;
  std::vector<double> x_, units_;
  const std::vector<std::uint8_t>& moves_;
  std::vector<double> given_;  // r x m
  double worst_by_ = 0;
  std::string worst_;
};

Motion ask(const Law::Function& law, double t) {
  Motion m;
  double undefined = 0;
  call([&] { m = law.motion(t); }, &undefined, 1);
  return undefined == 0 ? m : Motion{kNan, kNan, kNan};
}

// The first error of a law between two times; "" if there is none. unit: SI value of an internal unit of the law;
// derivatives: number of derivatives to check.
std::string find_in_law(const Law::Function& law, double from, double to, double unit, int derivatives) {
  if (!(law.tolerance < kInfinity)) return "";
  const double t = from + kBetween * (to - from), longest = kLongestOfLaw * std::abs(to - from);
  const Motion m = ask(law, t), again = ask(law, t);
  if (!std::isfinite(m.value)) return "";  // not defined here
  const double of = kFloor * law.tolerance, span = kSpanOfSteps * std::abs(to - from), size = std::abs(m.value) + unit;
  const std::string time = " at t = " + text(t) + " s";
  if (std::abs(again.value - m.value) > of * size) return says_again("the value" + time, m.value, again.value);
  const auto found =
      slopes(2, longest, kRoundingSteps * kEps * std::max(std::abs(from), std::abs(to)), [&](double h, double* out) {
        const Motion at = ask(law, t + h);
        out[0] = at.value;
        out[1] = at.rate;
      });
  if (derivatives > 0 && excess(m.rate, found[0], law.tolerance, of * size / span)) {
    return says("the rate" + time, m.rate, "value", found[0]);
  }
  if (derivatives > 1 &&
      excess(m.acceleration, found[1], law.tolerance, of * (std::abs(m.rate) + size / span) / span)) {
    return says("the acceleration" + time, m.acceleration, "rate", found[1]);
  }
  return "";
}

// SI value of an internal unit of a driver's k-th law.
double unit_of(const System& s, const DriverInput& input, std::size_t k) {
  const bool is_angle = input.kind == DriverInput::Kind::direction ||
                        (input.kind == DriverInput::Kind::frame && k >= static_cast<std::size_t>(s.dimension));
  return is_angle ? 1 : s.unit(input.dimension);
}

// Highest derivative that an output shows.
int wanted_derivatives(const System& s) {
  int most = s.bounds.empty() ? 0 : 2;
  for (const Output& o : wanted_outputs(s)) most = std::max(most, o.derivatives());
  return most;
}

std::string find_in_block(const System& s, const CallbackBlock& block, const std::vector<double>& q, bool curvature) {
  std::vector<double> x;
  std::vector<std::uint8_t> moves;
  for (std::size_t j = 0; j < block.coordinates.size(); ++j) {
    x.push_back(form_value<double>(s, block.coordinates[j], q) * block.unit[j]);
    const auto terms = s.form(block.coordinates[j]);
    moves.push_back(std::any_of(terms.begin(), terms.end(), [&](const Term& t) {
      const Coordinate& c = s.coordinates[static_cast<std::size_t>(t.coordinate)];
      return c.role == Role::unknown || (c.role == Role::driven && c.moving);
    }));
  }
  return FunctionCheck(*block.callback, std::move(x), block.unit, moves).find(curvature);
}

void require_each(std::size_t entries, const std::string& name, std::size_t arguments) {
  if (entries == arguments) return;
  throw Error(Error::Kind::input, "`" + name + "` has " + std::to_string(entries) +
                                      " entries; it must have one for each of " + std::to_string(arguments) +
                                      " arguments");
}

}  // namespace

std::vector<Diagnostic> check_derivatives(const Callback& callback, std::span<const double> at,
                                          std::span<const double> units) {
  const std::size_t m = callback.coordinates.size();
  if (callback.equations < 1) throw Error(Error::Kind::input, "`equations` of a callback must be at least 1");
  require_each(at.size(), "at", m);
  if (!units.empty()) require_each(units.size(), "units", m);
  std::vector<double> unit(units.begin(), units.end());
  unit.resize(m, 1.0);
  const std::vector<std::uint8_t> moves(m, 1);
  const std::string wrong = FunctionCheck(callback, {at.begin(), at.end()}, std::move(unit), moves).find(true);
  return wrong.empty() ? std::vector<Diagnostic>{} : std::vector<Diagnostic>{{"", wrong}};
}

std::vector<Diagnostic> check_derivatives(const Law& law, double from, double to) {
  std::vector<Diagnostic> out;
  for (const Law::Part& part : law.parts()) {
    const auto* const function = std::get_if<Law::Function>(&part);
    if (function == nullptr) continue;
    if (std::string wrong = find_in_law(*function, from, to, 1, 2); !wrong.empty())
      out.push_back({"", std::move(wrong)});
  }
  return out;
}

std::vector<Diagnostic> find_wrong_functions(const System& s, const std::vector<double>& q, const TimeGrid& time,
                                             const std::vector<std::string>& controlled) {
  constexpr const char* kInstead = "; correct it, or state a larger `tolerance` if this is intended";
  const int derivatives = wanted_derivatives(s);
  std::vector<Diagnostic> out;
  for (const CallbackBlock& block : s.callbacks) {
    if (numbers_of(*block.callback)) continue;  // a gear, which is ours
    const std::string wrong = find_in_block(s, block, q, derivatives == 2);
    if (!wrong.empty()) out.push_back({"/constraints/" + s.equation_name(block.first_equation), wrong + kInstead});
  }
  for_each_function(s, [&](std::size_t i, std::size_t k, const Law::Function& law) {
    const std::string& driver = s.drivers[static_cast<std::size_t>(s.inputs[i].driver)];
    const bool is_set = std::find(controlled.begin(), controlled.end(), driver) != controlled.end();
    std::string wrong;
    for (std::int64_t n = 0; n < (is_set ? 1 : kStepsToCheck) && wrong.empty(); ++n) {
      const std::int64_t step = n * std::max<std::int64_t>(time.steps() - 1, 0) / (kStepsToCheck - 1);
      const double from = time.time(step);
      wrong = find_in_law(law, from, from + time.step, unit_of(s, s.inputs[i], k), derivatives);
    }
    if (!wrong.empty()) out.push_back({"/drivers/" + driver + "/law", wrong + kInstead});
  });
  return out;
}

}  // namespace assur
