#include "joints/gear.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "numbers.hpp"
#include "scene/jet.hpp"

namespace assur {
namespace {

constexpr double kSameRatio = 1e-9;  // fractions up to kMostTeeth differ by 1e-6 at least
using Arguments = std::array<Jet<double>, kMostGearArguments>;

struct Equation {
  GearNumbers numbers;

  // The arguments of an angle: from, to, axis.
  template <class T>
  static Jet<T> angle(std::span<const Jet<T>> d_of, bool in_space) {
    const auto d = [&](std::size_t k) -> const Jet<T>& { return d_of[k]; };
    if (!in_space) return atan2(d(0) * d(3) - d(1) * d(2), d(0) * d(2) + d(1) * d(3));
    const auto across = [&](std::size_t i, std::size_t j) { return d(i) * d(3 + j) - d(j) * d(3 + i); };
    return atan2(d(6) * across(1, 2) + d(7) * across(2, 0) + d(8) * across(0, 1),
                 d(0) * d(3) + d(1) * d(4) + d(2) * d(5));
  }

  template <class T>
  [[nodiscard]] Jet<T> operator()(std::span<const Jet<T>> x) const {
    Jet<T> total{};
    std::size_t first = 0;
    for (const GearNumbers::Side& side : numbers.sides) {
      const std::span<const Jet<T>> own = x.subspan(first, side.arguments());
      total = total + T(side.factor) * (side.is_angle ? angle<T>(own, side.dimension == 3) : own[0]);
      first += own.size();
    }
    if (!numbers.is_periodic) return total;
    const CosSin<T> phase = cos_sin(total);
    if (phase.cosine.value < kLeastCosineInMesh || std::abs(total.value) > kLargestPhase)
      return Jet<T>{T(kNan), T(kNan), T(kNan)};
    return phase.sine;
  }
};

// A named type, so that numbers_of() recognises it.
struct Residual {
  Equation equation;

  void operator()(std::span<const double> x, std::span<double> phi) const {
    Arguments jets{};
    for (std::size_t i = 0; i < x.size(); ++i) jets[i].value = x[i];
    phi[0] = equation(std::span<const Jet<double>>(jets)).value;
  }
};

}  // namespace

std::optional<std::pair<int, int>> whole_ratio(double ratio) {
  // Convergents of the continued fraction, which are the best approximations.
  double rest = std::abs(ratio);
  std::int64_t n = 1, n_before = 0, m = 0, m_before = 1;
  for (int i = 0; i < 32 && std::isfinite(rest); ++i) {
    const double whole = std::floor(rest);
    if (whole > kMostTeeth) break;
    const auto digit = static_cast<std::int64_t>(whole);
    n_before = std::exchange(n, digit * n + n_before);
    m_before = std::exchange(m, digit * m + m_before);
    if (n > kMostTeeth || m > kMostTeeth) break;
    if (n > 0 && std::abs(static_cast<double>(n) / static_cast<double>(m) - std::abs(ratio)) <= kSameRatio) {
      return std::pair(static_cast<int>(ratio < 0 ? -n : n), static_cast<int>(m));
    }
    rest = 1 / (rest - whole);
  }
  return {};
}

std::optional<GearNumbers> numbers_of(const Callback& callback) {
  const auto* residual = callback.residual.target<Residual>();
  return residual != nullptr ? std::optional(residual->equation.numbers) : std::nullopt;
}

Callback gear_of(const GearNumbers& numbers) {
  const Equation equation{numbers};
  Callback c;
  c.equations = 1;
  c.teeth = numbers.teeth;
  c.tolerance = kInfinity;
  c.residual = Residual{equation};
  c.jacobian = [equation](std::span<const double> x, std::span<double> jacobian) {
    Arguments jets{};
    for (std::size_t i = 0; i < x.size(); ++i) jets[i].value = x[i];
    for (std::size_t i = 0; i < x.size(); ++i) {  // the derivative by one argument is a rate
      jets[i].rate = 1;
      jacobian[i] = equation(std::span<const Jet<double>>(jets)).rate;
      jets[i].rate = 0;
    }
  };
  c.curvature = [equation](std::span<const double> x, std::span<const double> rate, std::span<double> curvature) {
    Arguments jets{};
    for (std::size_t i = 0; i < x.size(); ++i) jets[i] = {x[i], rate[i], 0};
    curvature[0] = equation(std::span<const Jet<double>>(jets)).acceleration;
  };
  return c;
}

Callback gear_equation(const GearSide& a, const GearSide& b, double ratio) {
  GearNumbers numbers;
  std::vector<std::string> coordinates;
  const auto add = [&](const GearSide& side, double factor) {
    const bool in_space = !side.axis.empty();
    if (side.is_angle) {
      for (const std::string* name : {&side.from, &side.to, &side.axis}) {
        if (name->empty()) continue;
        for (const char* part : {".x", ".y", ".z"}) {
          if (part[1] != 'z' || in_space) coordinates.push_back(*name + part);
        }
      }
    } else {
      coordinates.push_back(side.displacement);
    }
    numbers.sides.push_back({side.is_angle, in_space ? 3 : 2, factor});
  };
  numbers.is_periodic = a.is_angle || b.is_angle;
  if (a.is_angle && b.is_angle) {
    const auto [n, m] = whole_ratio(ratio).value_or(std::pair(1, 1));
    add(a, -n), add(b, m);
    numbers.teeth = std::max(std::abs(n), m);
  } else if (a.is_angle) {
    add(a, -1), add(b, 1 / ratio);
  } else {
    add(a, -ratio), add(b, 1);
  }
  Callback c = gear_of(numbers);
  c.coordinates = std::move(coordinates);
  c.tolerance = kDerivativeTolerance;
  return c;
}

}  // namespace assur
