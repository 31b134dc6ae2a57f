// Sines, cosines and harmonics in lanes, compared with quad, for every instruction set of this machine.
#include "outputs/angle_kernels.hpp"
#include "numbers.hpp"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "references/quad.hpp"
#include "scene/law_evaluate.hpp"

namespace assur {
namespace {

using references::Quad;
using Exact = boost::multiprecision::cpp_bin_float_100;  // quad has too few digits next to a zero
constexpr double kTiny = 0x1p-30;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

template <class Test>
void in_every_instruction_set(const Test& test) {
  for (std::int64_t left = hwy::SupportedTargets(); left != 0; left &= left - 1) {
    SCOPED_TRACE(hwy::TargetName(left & -left));
    hwy::SetSupportedTargetsForTest(left & -left);
    test(angle_kernels());
    hwy::SetSupportedTargetsForTest(0);
  }
}

struct SinesAndCosines {
  std::vector<double> sines, cosines;

  SinesAndCosines(const AngleKernels& kernels, std::vector<double> angles) {
    const std::size_t count = angles.size(), padded = (count + kAngleBlock - 1) / kAngleBlock * kAngleBlock;
    angles.resize(padded);
    sines.resize(padded);
    cosines.resize(padded);
    kernels.sin_cos(angles.data(), count, sines.data(), cosines.data());
  }
};

// Small angles, angles over the whole range, and neighbours of multiples of pi/2, where sine or cosine nearly vanishes.
std::vector<double> reducible_angles() {
  std::vector<double> angles = {0.0, -0.0, 1e-300, kLargestAngle, -kLargestAngle};
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> exponent(-30, 20), near(-4, 4), multiple(0, kLargestAngle / 1.6);
  for (int i = 0; i < 4000; ++i) {
    const double sign = i % 2 == 0 ? 1 : -1;
    angles.push_back(sign * std::exp2(exponent(random)));
    angles.push_back(near(random));
    const double n = i < 1000 ? std::floor(i / 4.0) : std::floor(multiple(random));
    angles.push_back(sign * n * (std::numbers::pi / 2) * (1 + (i % 3 - 1) * kEps));
  }
  return angles;
}

double unit_in_the_last_place(double x) { return std::nextafter(std::abs(x), kInfinity) - std::abs(x); }

TEST(AngleKernels, SinesAndCosinesAreWithinOneUnit) {
  const std::vector<double> angles = reducible_angles();
  std::vector<Exact> sine, cosine;
  for (const double a : angles) {
    sine.push_back(sin(Exact(a)));
    cosine.push_back(cos(Exact(a)));
  }
  in_every_instruction_set([&](const AngleKernels& kernels) {
    const SinesAndCosines at(kernels, angles);
    double worst = 0;
    for (std::size_t i = 0; i < angles.size(); ++i) {
      const auto units = [](double x, const Exact& exact) {
        return static_cast<double>(abs(Exact(x) - exact)) / unit_in_the_last_place(static_cast<double>(exact));
      };
      const double s = units(at.sines[i], sine[i]), c = units(at.cosines[i], cosine[i]);
      ASSERT_LE(s, abs(sine[i]) < kTiny ? 2 : 1) << "sin " << angles[i];
      ASSERT_LE(c, abs(cosine[i]) < kTiny ? 2 : 1) << "cos " << angles[i];
      worst = std::max({worst, s, c});
    }
    EXPECT_GT(worst, 0.4);  // the errors are really measured: the final rounding alone is up to half a unit
  });
}

TEST(AngleKernels, LargeAnglesAgreeWithTheCLibrary) {
  const std::vector<double> angles = {1e7, -3e9, 1e22, -1e300, 0.5};
  in_every_instruction_set([&](const AngleKernels& kernels) {
    const SinesAndCosines at(kernels, angles);
    for (std::size_t i = 0; i + 1 < angles.size(); ++i) {
      EXPECT_EQ(at.sines[i], std::sin(angles[i]));
      EXPECT_EQ(at.cosines[i], std::cos(angles[i]));
    }
    const SinesAndCosines none(kernels, {kInfinity, 1, -kInfinity, kNone});
    for (const std::size_t i : {0u, 2u, 3u}) {
      EXPECT_TRUE(std::isnan(none.sines[i]));
      EXPECT_TRUE(std::isnan(none.cosines[i]));
    }
    EXPECT_EQ(none.sines[1], SinesAndCosines(kernels, {1}).sines[0]);
  });
}

// Tolerances as for one law in scene/law_quad_test.cpp, plus the rounding of the phase: doubles from 2^20 on have a
// spacing of 2^-32.
TEST(AngleKernels, HarmonicsKeepTheirPhaseAfterManyTurns) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> exponent(-3, 12), phase(-7, 7);
  for (int i = 0; i < 100; ++i) {
    const double t = std::pow(10, exponent(random));
    HarmonicBlock block;
    std::vector<Jet<Quad>> exact;
    for (std::size_t k = 0; k < kAngleBlock; ++k) {
      const Harmonic term{k == 5 ? 0 : 1.5, std::pow(10, exponent(random) / 4), phase(random)};
      block.amplitude[k] = term.amplitude;
      block.frequency[k] = term.frequency;
      block.phase[k] = term.phase;
      block.omega[k] = law_detail::two_pi<double>() * term.frequency;
      exact.push_back(evaluate(Law::harmonics({term}, 0.25), Quad(t)));
    }
    in_every_instruction_set([&](const AngleKernels& kernels) {
      std::vector<double> value(kAngleBlock, 0.25), rate(kAngleBlock), acceleration(kAngleBlock);
      kernels.add_harmonics(&block, 1, t, value.data(), rate.data(), acceleration.data());
      for (std::size_t k = 0; k < kAngleBlock; ++k) {
        const double w = block.omega[k], a = 2 * (1 + std::abs(block.phase[k]) / 7);
        EXPECT_NEAR(value[k], static_cast<double>(exact[k].value), 4 * kEps * a);
        EXPECT_NEAR(rate[k], static_cast<double>(exact[k].rate), 8 * kEps * a * w);
        EXPECT_NEAR(acceleration[k], static_cast<double>(exact[k].acceleration), 12 * kEps * a * w * w);
      }
    });
  }
}

}  // namespace
}  // namespace assur
