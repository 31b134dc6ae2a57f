// Backends on a GPU are loaded at run time. These tests run without a GPU, with one, and with a library that replaces
// those of NVIDIA, which ASSUR_STAND_IN gives a fault (cuda_stand_in.cpp, tests/CMakeLists.txt).
#include "backends/cusolver.hpp"

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <iostream>
#include <thread>

#include "assur/backend.hpp"
#include "backends/matrices.hpp"

namespace assur::test {
namespace {

// The mode of the stand-in; "computer": it is not used.
std::string mode() {
  const char* const text = std::getenv("ASSUR_STAND_IN");
  return text ? text : "computer";
}

const Backend& cusolver() { return find_backend(backends(), "cusolver"); }

Shape shape_of_groups(std::int32_t n, std::int32_t groups) {
  Shape shape;
  shape.n = n;
  shape.groups = groups;
  return shape;
}

TEST(Cusolver, RunsOrSaysWhatIsMissing) {
  const std::string why_not = cusolver().why_not({}, {});
  std::cout << "mode " << mode() << ": " << (why_not.empty() ? cusolver().version() : why_not) << '\n';
  if (mode() == "old_driver") {
    EXPECT_EQ(why_not,
              "the NVIDIA driver is too old: it supports CUDA 11.4, and the libraries are those of 13.0; update the "
              "driver, or install an older CUDA");
  } else if (mode() == "no_device") {
    EXPECT_EQ(why_not,
              "the NVIDIA driver offers no device (no CUDA-capable device is detected); nvidia-smi lists devices, and "
              "CUDA_VISIBLE_DEVICES may hide them");
  } else if (mode() != "computer") {
    EXPECT_EQ(why_not, "");
    EXPECT_EQ(cusolver().version(), "CUDA 13.0, cuSOLVER 12.0.1, Stand-in");
  } else if (dlopen("libcuda.so.1", RTLD_LAZY | RTLD_LOCAL) == nullptr) {
    EXPECT_EQ(
        why_not,
        "no NVIDIA driver (libcuda.so.1) was found: cusolver needs an NVIDIA GPU, its driver, and the libraries of "
        "CUDA 11, 12 or 13");
  }
  EXPECT_EQ(cusolver().make({}, Precision::binary64) == nullptr, !why_not.empty());
  EXPECT_EQ(cusolver().version().empty(), !why_not.empty());
}

TEST(Magma, RunsOrSaysWhatIsMissing) {
  const Backend& magma = find_backend(backends(), "magma");
  const std::string why_not = magma.why_not({}, {});
  std::cout << "mode " << mode() << ": " << (why_not.empty() ? magma.version() : why_not) << '\n';
  if (mode() == "no_device") {
    EXPECT_EQ(why_not, "MAGMA finds no GPU that it can use (magma_init ends with status -101)");
  } else if (mode() == "computer" && dlopen("libmagma.so", RTLD_LAZY | RTLD_LOCAL) == nullptr &&
             dlopen("libmagma.so.2", RTLD_LAZY | RTLD_LOCAL) == nullptr) {
    EXPECT_EQ(why_not,
              "no libmagma.so was found: install MAGMA 2 and put the folder of its library into LD_LIBRARY_PATH");
  } else if (mode() != "computer") {
    EXPECT_EQ(why_not, "");
    EXPECT_EQ(magma.version(), "2.7.1");
  }
  EXPECT_EQ(magma.make({}, Precision::binary64) == nullptr, !why_not.empty());
}

class OnDevice : public testing::Test {
 protected:
  void SetUp() override {
    if (const std::string why_not = cusolver().why_not({}, {}); !why_not.empty()) GTEST_SKIP() << why_not;
  }
};
using CusolverOnDevice = OnDevice;

TEST_F(CusolverOnDevice, UsesOneThread) {
  EXPECT_EQ(cusolver().why_not({}, ThreadBudget{2}), "it runs on one thread");
  EXPECT_EQ(cusolver().why_not(shape_of_groups(16385, 1), {}),
            "dense factors of 16385 unknowns are too large; the limit is 16384");
}

TEST_F(CusolverOnDevice, RefusesGroupsThatItsMemoryCannotHold) {
  if (mode() != "small") GTEST_SKIP() << "needs the stand-in with little memory";
  EXPECT_EQ(cusolver().why_not(shape_of_groups(3000, 1), {}), "");
  EXPECT_EQ(cusolver().why_not(shape_of_groups(3000, 2), {}),
            "dense factors of 2 x 3000 unknowns need 137 MiB, and the GPU has 96 MiB");
  Random random(3);
  const Matrix a = ring(3000, random);
  const auto solver = cusolver().make({}, Precision::binary64);
  try {
    (void)solver->analyze(a.pattern, 2);
    FAIL() << "analyze() found memory";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::environment);
    EXPECT_STREQ(error.what(),
                 "the GPU has no memory for 137 MiB of dense factors; use fewer lanes or a sparse backend");
  }
}

TEST_F(CusolverOnDevice, AFailureOfTheDeviceIsAnError) {
  if (mode() != "fails") GTEST_SKIP() << "needs the stand-in that fails";
  Random random(3);
  const Matrix a = ring(200, random);
  const auto solver = cusolver().make({}, Precision::binary64);
  ASSERT_TRUE(solver->analyze(a.pattern, 1).ok());
  setenv("ASSUR_STAND_IN", "works", 1);
  ASSERT_TRUE(solver->factorize(a.values).ok());
  setenv("ASSUR_STAND_IN", "fails", 1);
  try {
    (void)solver->factorize(a.values);
    FAIL() << "factorize() did not fail";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::environment);
    EXPECT_STREQ(error.what(), "cusolver: cudaStreamSynchronize failed: launch failure");
  }
  EXPECT_FALSE(solver->figures(0).ok);  // the factors from before are not used again
}

// Each caller has a solver of its own, with its own stream.
TEST_F(CusolverOnDevice, CallersSolveSideBySide) {
  if (mode() == "fails") GTEST_SKIP();
  std::vector<double> worst(4, 1.0);
  std::vector<std::thread> callers;
  for (std::size_t c = 0; c < worst.size(); ++c) {
    callers.emplace_back([c, &worst] {
      Random random(3 + static_cast<unsigned>(c));
      const Matrix a = dense(c % 2 == 0 ? 40 : 160, random);
      const auto solver = cusolver().make({}, Precision::binary64);
      if (!solver->analyze(a.pattern, 1).ok()) return;
      worst[c] = 0;
      for (int i = 0; i < 20; ++i) {
        std::vector<double> b(static_cast<std::size_t>(a.pattern.n));
        for (double& element : b) element = nonzero(random);
        std::vector<double> x = b;
        const bool ok = solver->factorize(a.values).ok() && solver->solve(x, 1).ok();
        worst[c] = ok ? std::max(worst[c], backward_error(a, x, b, Transpose::no)) : 1.0;
      }
    });
  }
  for (std::thread& caller : callers) caller.join();
  for (const double error : worst) EXPECT_LE(error, 1e-13);
}

TEST_F(CusolverOnDevice, TheTimeOfACallIsThatOfItsParts) {
  if (mode() == "fails") GTEST_SKIP();
  Random random(3);
  for (const int n : {18, 400}) {
    const Matrix a = ring(n, random);
    const cusolver::Breakdown b = cusolver::break_down(a.pattern, a.values, 5);
    EXPECT_LE(b.backward_error, 1e-13) << n;
    EXPECT_GT(b.backward_error, 0) << n;
    for (const cusolver::CallTimes& times : {b.factorize, b.solve}) {
      EXPECT_GT(times.upload, 0) << n;
      EXPECT_GT(times.compute, 0) << n;
      EXPECT_GT(times.download, 0) << n;
      EXPECT_LT(times.compute, times.whole) << n;
    }
  }
  Matrix singular = ring(18, random);
  std::fill(singular.values.begin(), singular.values.end(), 0.0);
  EXPECT_THROW((void)cusolver::break_down(singular.pattern, singular.values, 5), Error);
}

}  // namespace
}  // namespace assur::test
